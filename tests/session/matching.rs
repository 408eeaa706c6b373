//! Visits matched with each other, as a step of a session.

use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::map::Mode;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::session::{Answer, Event, Session};

use super::{Desk, act, done, wall};

fn matching() -> Event {
    Event::Match(Default::default())
}

fn names(session: &Session) -> Vec<String> {
    session.solved().corrector().map().automatic_factors.iter().map(|a| a.name()).collect()
}

/// A session with a stroke, the visits matched, another stroke, the visits matched again.
fn worked(desk: &Desk) -> (Session, Vec<Vec<u8>>) {
    let mut session = desk.open();
    let mut maps = vec![desk.shown(&session)];
    for k in 0..2 {
        let stroke = wall(&session, k, Mode::Collinear);
        for event in [stroke, matching()] {
            done(&mut session, event);
            maps.push(desk.shown(&session));
        }
    }
    assert!(!names(&session).is_empty(), "the room's two rounds fit together");
    (session, maps)
}

#[test]
fn matching_is_a_step_that_undo_redo_restart_and_replay_know() {
    let desk = Desk::new("match");
    let (mut session, maps) = worked(&desk);
    assert!(maps.windows(2).all(|w| w[0] != w[1]), "every step changes the map");
    assert!(desk.replayed() == maps[4]);
    for map in maps[..4].iter().rev() {
        done(&mut session, Event::Undo);
        assert!(desk.shown(&session) == *map);
    }
    for map in &maps[1..] {
        done(&mut session, Event::Redo);
        assert!(desk.shown(&session) == *map);
    }
    drop(session);
    let mut session = desk.open();
    assert!(desk.shown(&session) == maps[4]);
    done(&mut session, Event::Undo);
    assert!(desk.shown(&session) == maps[3]);
    assert!(desk.replayed() == maps[3]);
}

#[test]
fn a_session_that_matched_is_what_the_pipeline_does_by_hand() {
    let desk = Desk::new("by-hand");
    let (session, maps) = worked(&desk);
    let mut naive = Corrector::new(desk.map.clone(), Options::default()).unwrap();
    for correction in &session.state().corrections {
        naive.apply(correction).unwrap();
        naive.reassociate(&closures::Options::default(), &|_| {}, &AtomicBool::new(false)).unwrap().unwrap();
    }
    assert!(desk.bytes(naive.map()) == maps[4]);
}

#[test]
fn what_was_matched_beside_the_session_is_there_at_once_and_the_same() {
    let desk = Desk::new("beside");
    let mut session = desk.open();
    let stroke = wall(&session, 0, Mode::Collinear);
    done(&mut session, stroke);
    let before = desk.shown(&session);
    let mut branch = session.branch();
    assert!(!branch.run(&mut |_, _| false).unwrap(), "it can be given up");
    let mut branch = session.branch();
    assert!(branch.run(&mut |_, _| true).unwrap());
    session.learn(branch);
    assert!(desk.shown(&session) == before, "nothing has changed yet");
    let mut calls = 0;
    let answer = session.act(matching(), 1_700_000_000, &mut |_, _| {
        calls += 1;
        true
    });
    assert_eq!((answer.unwrap(), calls), (Answer::Done, 1), "nothing had to be found again");
    assert!(desk.shown(&session) == desk.replayed());

    // A branch of a map that is gone is of no use, and does no harm.
    let mut late = session.branch();
    let other = wall(&session, 1, Mode::Collinear);
    done(&mut session, other);
    assert!(late.run(&mut |_, _| true).unwrap());
    session.learn(late);
    done(&mut session, matching());
    assert!(desk.shown(&session) == desk.replayed());
}

#[test]
fn a_refused_factor_goes_at_once_stays_away_and_comes_back_if_allowed() {
    let desk = Desk::new("refuse");
    let (mut session, maps) = worked(&desk);
    let all = names(&session);
    let wrong = session.solved().corrector().map().automatic_factors[all.len() / 2].factor;
    let pair = (wrong.i, wrong.j);
    done(&mut session, Event::Refuse(pair.0, pair.1));
    assert!(!names(&session).contains(&all[all.len() / 2]));
    assert!(names(&session).len() < all.len() && desk.shown(&session) != maps[4]);
    assert!(desk.replayed() == desk.shown(&session));
    let event = wall(&session, 2, Mode::Collinear);
    done(&mut session, event);
    done(&mut session, matching());
    let path_m = desk.map.path_lengths_m();
    let is_back = |s: &Session| {
        let factors = &s.solved().corrector().map().automatic_factors;
        factors.iter().any(|a| closures::is_beside(&path_m, pair, (a.factor.i, a.factor.j)))
    };
    assert!(!is_back(&session), "also the next time");
    drop(session);
    let mut session = desk.open();
    assert!(!is_back(&session) && session.state().refused == [pair], "and after a restart");
    let again = act(&mut session, Event::Refuse(pair.0, pair.1));
    assert!(matches!(again, Answer::Refused(reason) if reason.contains("is refused already")));
    let nowhere = act(&mut session, Event::Refuse(0, 100_000));
    assert!(matches!(nowhere, Answer::Refused(reason) if reason.contains("expected one that the map has")));
    done(&mut session, Event::Allow(pair.0, pair.1));
    done(&mut session, matching());
    assert!(is_back(&session), "allowed again, it is found again");
    assert!(desk.replayed() == desk.shown(&session));
}

#[test]
fn a_change_of_a_correction_takes_what_was_matched_after_it_and_nothing_before() {
    let desk = Desk::new("forget");
    let (mut session, maps) = worked(&desk);
    done(&mut session, Event::Enable("c2".into(), false));
    let first = names(&session);
    assert!(!first.is_empty() && !session.state().is_matched());
    done(&mut session, Event::Undo);
    assert!(desk.shown(&session) == maps[4]);
    done(&mut session, Event::Delete("c1".into()));
    assert!(names(&session).is_empty(), "it may have caused any of them");
    assert!(desk.replayed() == desk.shown(&session));
    done(&mut session, matching());
    assert!(session.state().is_matched() && !names(&session).is_empty());
    assert!(desk.replayed() == desk.shown(&session));
}

#[test]
fn matching_without_any_stroke_is_a_session_too() {
    let desk = Desk::new("no-stroke");
    let mut session = desk.open();
    done(&mut session, matching());
    assert!(session.state().is_matched());
    assert!(desk.replayed() == desk.shown(&session));
    done(&mut session, matching());
    assert_eq!(session.state().closings.len(), 1, "found anew, not twice");
}
