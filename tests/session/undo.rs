//! Undo, redo and later changes; among them what the released implementation of the paper gets wrong.

use std::time::Instant;

use hitl_slam::geometry::Vec2;
use hitl_slam::joint::Backend;
use hitl_slam::map::{Mode, Stroke};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::session::{Answer, Event, EventResult, Settings};

use super::{Desk, act, any_event, done, wall};
use crate::support::Dice;

#[test]
fn undo_leaves_the_very_map_that_was_there_before_and_redo_the_one_after() {
    // The released implementation leaves a stale map after an undo.
    let desk = Desk::new("undo");
    let mut session = desk.open();
    let mut maps = vec![desk.shown(&session)];
    for k in 0..4 {
        let event = wall(&session, k, Mode::Collinear);
        done(&mut session, event);
        maps.push(desk.shown(&session));
        assert!(maps[k] != maps[k + 1], "a correction moves something");
    }
    for k in (0..4).rev() {
        done(&mut session, Event::Undo);
        assert!(desk.shown(&session) == maps[k], "after undo to {k}");
    }
    assert_eq!(act(&mut session, Event::Undo), Answer::Refused("undo: found nothing to undo".into()));
    for map in &maps[1..] {
        done(&mut session, Event::Redo);
        assert!(desk.shown(&session) == *map);
    }
    assert_eq!(act(&mut session, Event::Redo), Answer::Refused("redo: found nothing to redo".into()));
}

#[test]
fn undo_after_a_refused_correction_takes_back_the_last_one_that_was_accepted() {
    // The released implementation drops a valid correction with the refused one.
    let desk = Desk::new("refused");
    let mut session = desk.open();
    let first = wall(&session, 0, Mode::Collinear);
    done(&mut session, first);
    let one = desk.shown(&session);
    let second = wall(&session, 1, Mode::Collinear);
    done(&mut session, second);
    let Event::Correct(mut nowhere, _) = wall(&session, 2, Mode::Collinear) else { unreachable!() };
    nowhere.b = Stroke::World([Vec2::new(500.0, 500.0), Vec2::new(501.0, 500.0)]);
    let written = std::fs::read(desk.log()).unwrap();
    let answer = act(&mut session, Event::Correct(nowhere, EventResult::default()));
    assert!(matches!(&answer, Answer::Refused(reason) if reason.starts_with("stroke b: ")), "{answer:?}");
    assert!(std::fs::read(desk.log()).unwrap() == written, "a refused correction is not an event");
    done(&mut session, Event::Undo);
    assert!(desk.shown(&session) == one);
}

#[test]
fn a_replay_applies_every_entry_of_every_mode() {
    // The released implementation applies the first only, and reads back `parallel` as nothing.
    let desk = Desk::new("modes");
    let mut session = desk.open();
    for (k, mode) in [Mode::Colocation, Mode::Collinear, Mode::Parallel].into_iter().enumerate() {
        let event = wall(&session, k, mode);
        done(&mut session, event);
    }
    let Event::Correct(mut turned, _) = wall(&session, 0, Mode::Perpendicular) else { unreachable!() };
    if let Event::Correct(other, _) = wall(&session, 1, Mode::Perpendicular) {
        turned.b = other.b;
    }
    done(&mut session, Event::Correct(turned, EventResult::default()));
    assert_eq!(session.solved().corrector().map().human_factors.len(), 4);
    assert!(desk.replayed() == desk.shown(&session));
}

#[test]
fn a_session_goes_on_after_a_restart_with_its_whole_past() {
    // The released implementation writes its log on Ctrl-C only, forgets the past on replay and undoes one step.
    let desk = Desk::new("restart");
    let mut session = desk.open();
    let before = desk.shown(&session);
    for k in 0..3 {
        let event = wall(&session, k, Mode::Collinear);
        done(&mut session, event);
    }
    done(&mut session, Event::Undo);
    let after = desk.shown(&session);
    drop(session);
    let mut session = desk.open();
    assert!(desk.shown(&session) == after);
    done(&mut session, Event::Redo);
    for _ in 0..3 {
        done(&mut session, Event::Undo);
    }
    assert!(desk.shown(&session) == before);
}

#[test]
fn switching_off_and_deleting_are_as_if_the_correction_had_never_been() {
    let desk = Desk::new("without");
    let mut session = desk.open();
    for k in 0..3 {
        let event = wall(&session, k, Mode::Collinear);
        done(&mut session, event);
    }
    let all = desk.shown(&session);
    let mut naive = Corrector::new(desk.map.clone(), Options::default()).unwrap();
    for k in [0, 2] {
        naive.apply(&session.state().corrections[k].clone()).unwrap();
    }
    let without = desk.bytes(naive.map());
    done(&mut session, Event::Enable("c2".into(), false));
    assert!(desk.shown(&session) == without);
    done(&mut session, Event::Enable("c2".into(), true));
    assert!(desk.shown(&session) == all);
    done(&mut session, Event::Delete("c2".into()));
    assert!(desk.shown(&session) == without);
    let next = wall(&session, 1, Mode::Collinear);
    assert!(
        matches!(&next, Event::Correct(c, _) if c.id == "c4"),
        "the name of a deleted one is not used again"
    );
}

#[test]
fn a_weight_pulls() {
    let desk = Desk::new("weight");
    let mut session = desk.open();
    let event = wall(&session, 0, Mode::Collinear);
    done(&mut session, event);
    let offset = |s: &hitl_slam::session::Session| s.solved().corrector().standings()[0].offset_m.unwrap();
    let plain = offset(&session);
    done(&mut session, Event::Reweight("c1".into(), 0.001));
    assert!(offset(&session) > 2.0 * plain, "{} against {plain}", offset(&session));
}

#[test]
fn a_straightened_wall_lies_along_an_axis_whatever_comes_later() {
    let desk = Desk::new("straight");
    let mut session = desk.open();
    let Event::Correct(c, _) = wall(&session, 1, Mode::Collinear) else { unreachable!() };
    done(&mut session, Event::Straighten(Some(c.b)));
    for k in 0..2 {
        let event = wall(&session, k, Mode::Collinear);
        done(&mut session, event);
        let Stroke::Pose { pose, points } = c.b else { unreachable!() };
        let shown = session.solved().map().poses[pose];
        let (caught, _) = session.catch(points.map(|p| shown.transform_point(p))).unwrap();
        let off = super::off_axis(hitl_slam::geometry::Pose2::IDENTITY, caught.fit.segment.direction_rad);
        assert!(off < 1e-9, "{off}");
    }
    assert!(desk.replayed() == desk.shown(&session));
    done(&mut session, Event::Straighten(None));
    assert_eq!(session.solved().map().poses, session.solved().corrector().map().poses);
}

#[test]
fn work_that_is_given_up_changes_nothing() {
    let desk = Desk::new("cancel");
    let mut session = desk.open();
    for k in 0..4 {
        let event = wall(&session, k, Mode::Collinear);
        done(&mut session, event);
    }
    let (before, written) = (desk.shown(&session), std::fs::read(desk.log()).unwrap());
    let mut calls = 0;
    let answer = session.act(Event::Delete("c1".into()), 7, &mut |done, of| {
        calls += 1;
        assert_eq!((done, of), (100 * (calls - 1), 300));
        done < 200
    });
    assert_eq!(answer.unwrap(), Answer::Cancelled);
    assert!(desk.shown(&session) == before && std::fs::read(desk.log()).unwrap() == written);
    assert!(desk.replayed() == before);
}

#[test]
fn a_preview_is_what_the_commit_then_does() {
    let desk = Desk::new("preview");
    let mut session = desk.open();
    let Event::Correct(c, r) = wall(&session, 0, Mode::Collinear) else { unreachable!() };
    let seen = session.preview(&c).unwrap().state.clone().unwrap();
    done(&mut session, Event::Correct(c, r));
    assert_eq!(session.solved().corrector().state(), seen);
    assert!(desk.replayed() == desk.shown(&session));
}

#[test]
fn the_solver_can_be_chosen_and_the_choice_undone() {
    if !Backend::Ceres.available() {
        crate::support::both_backends::skipped("built without Ceres");
        return;
    }
    let desk = Desk::new("solver");
    let mut session = desk.open();
    let event = wall(&session, 0, Mode::Collinear);
    done(&mut session, event);
    let by_rust = session.solved().corrector().map().poses.clone();
    done(&mut session, Event::Settings(Settings { solver: Backend::Ceres, ..Settings::default() }));
    let by_ceres = session.solved().corrector().map().poses.clone();
    let difference = crate::support::largest_distance_m(&by_rust, &by_ceres);
    assert!(difference > 0.0 && difference < 1e-6, "{difference}");
    assert!(desk.replayed() == desk.shown(&session));
    done(&mut session, Event::Undo);
    assert_eq!(session.solved().corrector().map().poses, by_rust);
}

#[test]
fn what_is_on_screen_is_always_what_a_replay_gives() {
    let start = Instant::now();
    for seed in 0..12 {
        let dice = &mut Dice::new(seed);
        let desk = Desk::new(&format!("random-{seed}"));
        let mut session = desk.open();
        for step in 0..10 {
            let event = any_event(&session, dice);
            act(&mut session, event);
            assert!(desk.shown(&session) == desk.replayed(), "seed {seed}, step {step}");
        }
        if start.elapsed().as_secs() > 60 {
            break;
        }
    }
}
