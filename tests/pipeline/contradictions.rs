//! Corrections that fight the others are named, and nothing else is.

use std::path::Path;

use hitl_slam::contradictions::{self, Contradictions};
use hitl_slam::front_end::{self, Chain};
use hitl_slam::geometry::{Pose2, Segment, Vec2};
use hitl_slam::io;
use hitl_slam::joint;
use hitl_slam::map::{Correction, Mode, SlamMap, Stroke};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::{Scenario, Simulation};

use super::{corrected, simulated};
use crate::support::ate_m;

fn find(map: &SlamMap) -> Contradictions {
    contradictions::find(map, &joint::Options::default()).expect("a sound map")
}

fn named(map: &SlamMap) -> Vec<String> {
    find(map).named.into_iter().map(|strain| strain.id).collect()
}

/// The same correction with its second stroke on a parallel wall that stands at least a metre from the right one.
fn on_a_wrong_wall(s: &Simulation, correction: &Correction) -> Correction {
    let Stroke::Pose { pose, points } = correction.b else { panic!("strokes are anchored to poses") };
    let [p, q] = points.map(|p| s.truth[pose].transform_point(p));
    let right = Segment::from_ends(p, q);
    let wrong = s.walls.iter().map(|w| w.segment).find(|wall| {
        let (along, across) = right.along_across(wall.centre);
        let parallel = (wall.direction_rad - right.direction_rad).sin().abs() < 0.1;
        parallel && along.abs() < 4.0 && (1.0..3.5).contains(&across.abs()) && wall.half_length_m > 0.4
    });
    let robot_from_world = s.truth[pose].inverse();
    let ends = wrong.expect("a corridor has two sides").ends().map(|p| robot_from_world.transform_point(p));
    Correction { b: Stroke::Pose { pose, points: ends }, ..correction.clone() }
}

#[test]
fn of_true_corrections_none_is_named_and_their_visits_do_not_clash() {
    let scenarios = [Scenario::Loop, Scenario::LostPoses, Scenario::OfficeBent, Scenario::Campus];
    for (scenario, seed) in scenarios.into_iter().flat_map(|s| [(s, 1), (s, 2)]) {
        let s = simulated(scenario, seed, 0.02);
        let (map, _) = corrected(&s.map, &s.corrections);
        let found = find(&map);
        assert_eq!(found.named, [], "{scenario} {seed}");
        assert_eq!(found.strains.len(), s.corrections.len());
        assert!(found.strains.iter().all(|s| s.clash.is_none_or(|share| share < 0.03)), "{scenario} {seed}");
    }
}

#[test]
fn a_torn_odometry_is_not_held_against_the_strokes_that_mend_it() {
    // Least squares sees nothing but two corrections at 100 σ from 30° of odometry; their visits fit together.
    let s = simulated(Scenario::OfficeKick, 1, 0.02);
    let (map, _) = corrected(&s.map, &s.corrections);
    let found = find(&map);
    assert!(found.strains[0].ratio > 50.0, "{:?}", found.strains[0]);
    assert_eq!(found.named, []);
}

#[test]
fn a_colocation_on_the_wrong_wall_is_named_alone_and_without_it_the_map_is_good_again() {
    let mut right = 0;
    for (seed, k) in [(1, 1), (2, 2), (3, 3), (4, 1), (5, 2), (6, 3)] {
        let s = simulated(Scenario::Campus, seed, 0.02);
        let mut corrections = s.corrections.clone();
        corrections[k] = on_a_wrong_wall(&s, &corrections[k]);
        let (map, reports) = corrected(&s.map, &corrections);
        assert!(reports[k].accepted());
        right += usize::from(named(&map) == [corrections[k].id.clone()]);
        if seed == 1 {
            let without: Vec<Correction> =
                corrections.iter().filter(|c| c.id != corrections[k].id).cloned().collect();
            let others: Vec<Correction> =
                s.corrections.iter().filter(|c| c.id != corrections[k].id).cloned().collect();
            let (mended, _) = corrected(&s.map, &without);
            let (as_good, _) = corrected(&s.map, &others);
            assert_eq!(ate_m(&mended.poses, &s.truth), ate_m(&as_good.poses, &s.truth));
        }
    }
    assert!(right >= 5, "{right} of 6");
}

#[test]
fn what_is_found_does_not_depend_on_how_the_map_lies() {
    let s = simulated(Scenario::OfficeBent, 3, 0.02);
    let mut corrections = s.corrections.clone();
    corrections[0] = on_a_wrong_wall(&s, &corrections[0]);
    let (map, _) = corrected(&s.map, &corrections);
    let turn = Pose2::new(100.0, -40.0, 2.5);
    let mut turned = map.clone();
    turned.poses.iter_mut().for_each(|p| *p = turn.compose(*p));
    for feature in turned.human_factors.iter_mut().flat_map(|f| [&mut f.a, &mut f.b]) {
        feature.segment = feature.segment.transformed(turn);
    }
    let (a, b) = (find(&map), find(&turned));
    assert_eq!(
        a.named.iter().map(|s| &s.id).collect::<Vec<_>>(),
        b.named.iter().map(|s| &s.id).collect::<Vec<_>>()
    );
    for (a, b) in a.strains.iter().zip(&b.strains) {
        assert!((a.delta_chi2 - b.delta_chi2).abs() < 1e-3 * a.delta_chi2.max(1.0), "{a:?} {b:?}");
        assert!((a.clash.unwrap_or(0.0) - b.clash.unwrap_or(0.0)).abs() < 0.01, "{a:?} {b:?}");
    }
}

#[test]
fn on_a_real_map_strokes_drawn_by_a_person_are_not_named_and_one_on_another_junction_is() {
    let shipped = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
    let log = io::carmen::read(&shipped("aces.clf.bz2")).expect("shipped data").value;
    let (map, _) = front_end::build(&log, Chain::Odometry, &front_end::Options::default()).expect("a log");
    let corrections = io::corrections::read(&shipped("aces.corrections.jsonl")).expect("shipped data").value;
    let (good, _) = corrected(&map, &corrections);
    assert_eq!(named(&good), Vec::<String>::new());

    // Nor while there are only the first few of them, nor a collinear that leaves its visits 12 m apart along the wall.
    for count in [1, 2, 4] {
        let (early, _) = corrected(&map, &corrections[..count]);
        assert_eq!(named(&early), Vec::<String>::new(), "after {count}");
    }
    let slid = Correction {
        id: "slid".into(),
        mode: Mode::Collinear,
        a: Stroke::World([Vec2::new(-0.9, -1.5), Vec2::new(-3.4, -1.5)]),
        b: Stroke::World([Vec2::new(-4.9, 11.1), Vec2::new(-7.1, 9.9)]),
        ..corrections[0].clone()
    };
    let (early, reports) = corrected(&map, &[slid]);
    assert!(reports[0].accepted() && named(&early).is_empty());

    let place = |id: &str| corrections.iter().position(|c| c.id == id).expect("the file has it");
    let (east, north) = (place("east-junction"), place("north-junction"));
    let mut wrong = corrections.clone();
    wrong[east].b = corrections[north].b;
    let mut corrector = corrector_of(&map);
    let agreement = corrector.apply_agreeing(&wrong, false, &|_| ()).expect("strokes on the map");
    assert_eq!(agreement.set_aside.iter().map(|(k, _)| *k).collect::<Vec<_>>(), [east]);
    assert!(agreement.reports[east].accepted(), "it could be applied; it was set aside");
    let mut others = corrections.clone();
    others.remove(east);
    assert_eq!(corrector.map().poses, corrected(&map, &others).0.poses, "as if it had not been said");

    let kept = corrector_of(&map).apply_agreeing(&wrong, true, &|_| ()).expect("strokes on the map");
    assert!(kept.set_aside.is_empty() && kept.left.iter().any(|s| s.id == "east-junction"));
}

fn corrector_of(map: &SlamMap) -> Corrector {
    Corrector::new(map.clone(), Options::default()).expect("a map")
}
