//! The simulated person draws what repairs the map, sees when it is good, and errs where told to.

use std::path::Path;

use hitl_slam::geometry::{Pose2, Segment, Vec2};
use hitl_slam::io;
use hitl_slam::map::{SlamMap, Stroke, Trajectory};
use hitl_slam::metrics;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::damage::{self, Kind};
use hitl_slam::simulate::person::{self, Drawn, Person, Reference, Settings};
use hitl_slam::simulate::{self, Scenario, Simulation};

use crate::support::{message, shared};

fn simulated(scenario: Scenario, seed: u64, drift: f64) -> Simulation {
    let settings = simulate::Settings { seed, drift, ..simulate::Settings::default() };
    simulate::run(scenario, &settings).expect("a run")
}

fn truth_of(s: &Simulation) -> Trajectory {
    Trajectory { poses: s.truth.clone(), ..s.map.trajectory() }
}

/// Lets a person repair a map: what was drawn, and the ATE after each stroke.
fn repaired(
    map: &SlamMap,
    truth: &Trajectory,
    settings: &Settings,
    strokes: usize,
) -> (Vec<Drawn>, Vec<f64>) {
    let mut person = Person::new(map, Reference::Truth(truth), settings).expect("a reference");
    let mut corrector = Corrector::new(map.clone(), Options::default()).expect("a map");
    let (mut drawn, mut ate_m) = (Vec::new(), Vec::new());
    for _ in 0..strokes {
        let done = person::repair(&mut corrector, &mut person, 1).expect("a repair");
        let Some((one, _)) = done.into_iter().next() else { break };
        drawn.push(one);
        let pairs: Vec<(usize, usize)> = (0..truth.poses.len()).map(|k| (k, k)).collect();
        ate_m.push(metrics::ate(&corrector.map().trajectory(), truth, &pairs).expect("poses").rmse_m);
    }
    (drawn, ate_m)
}

fn posed(stroke: &Stroke) -> (usize, [Vec2; 2]) {
    match *stroke {
        Stroke::Pose { pose, points } => (pose, points),
        _ => panic!("not anchored to a pose: {stroke:?}"),
    }
}

/// A stroke where it truly lies.
fn true_segment(stroke: &Stroke, truth: &[Pose2]) -> Segment {
    let (pose, points) = posed(stroke);
    let [p, q] = points.map(|p| truth[pose].transform_point(p));
    Segment::from_ends(p, q)
}

#[test]
fn a_loop_is_repaired_with_two_strokes_and_a_campus_with_eight() {
    for seed in 1..=6 {
        let s = simulated(Scenario::Loop, seed, 1.0);
        let (_, ate_m) = repaired(&s.map, &truth_of(&s), &Settings { seed, ..Settings::default() }, 2);
        assert!(*ate_m.last().expect("a bent map") < 0.06, "loop {seed}: {ate_m:?}");
    }
    let s = simulated(Scenario::Campus, 1, 1.0);
    let (_, ate_m) = repaired(&s.map, &truth_of(&s), &Settings::default(), 8);
    assert!(*ate_m.last().expect("a bent map") < 0.15, "campus: {ate_m:?}");
}

#[test]
fn a_map_that_is_good_is_left_alone() {
    let s = simulated(Scenario::Loop, 1, 0.0);
    let settings = Settings { drawing_noise_m: 0.0, ..Settings::default() };
    assert_eq!(repaired(&s.map, &truth_of(&s), &settings, 5).0, []);
    // And a repaired one is left alone after the last stroke.
    let s = simulated(Scenario::Loop, 2, 1.0);
    assert!(repaired(&s.map, &truth_of(&s), &settings, 20).0.len() < 6);
}

#[test]
fn right_strokes_lie_on_one_wall_and_wrong_ones_on_two() {
    let (mut right, mut wrong) = (0, 0);
    for seed in 1..=10 {
        let s = simulated(Scenario::Loop, seed, 1.0);
        let settings = Settings { seed, wrong: 0.5, drawing_noise_m: 0.0, ..Settings::default() };
        for drawn in repaired(&s.map, &truth_of(&s), &settings, 4).0 {
            let [a, b] = [&drawn.correction.a, &drawn.correction.b].map(|x| true_segment(x, &s.truth));
            let across_m = a.along_across(b.centre).1.abs();
            let on_a_wall = s.walls.iter().any(|wall| {
                let (along_m, across_m) = wall.segment.along_across(b.centre);
                along_m.abs() <= wall.segment.half_length_m + 0.1 && across_m.abs() < 0.05
            });
            assert!(on_a_wall, "seed {seed}: {drawn:?}");
            assert!(
                if drawn.is_wrong { across_m > 0.25 } else { across_m < 0.05 },
                "seed {seed}: {across_m}"
            );
            *if drawn.is_wrong { &mut wrong } else { &mut right } += 1;
        }
    }
    assert!(right >= 5 && wrong >= 5, "{right} right, {wrong} wrong");
}

#[test]
fn exactly_the_strokes_that_are_told_to_be_wrong_are() {
    let s = simulated(Scenario::Campus, 2, 1.0);
    let truth = truth_of(&s);
    let mut person =
        Person::new(&s.map, Reference::Truth(&truth), &Settings::default()).expect("a reference");
    let mut corrector = Corrector::new(s.map.clone(), Options::default()).expect("a map");
    for k in 0..4 {
        person.set_wrong(f64::from(k % 2)).expect("a probability");
        let done = person::repair(&mut corrector, &mut person, 1).expect("a repair");
        assert_eq!(done[0].0.is_wrong, k % 2 == 1, "{:?}", done[0].0);
    }
    assert!(message(person.set_wrong(-0.1)).contains("probability of a wrong wall: found -0.1"));
}

#[test]
fn strokes_have_the_noise_that_was_asked_for_and_follow_from_the_seed() {
    let s = simulated(Scenario::Loop, 1, 1.0);
    let truth = truth_of(&s);
    let first = |noise_m: f64, seed: u64| {
        let settings = Settings { seed, drawing_noise_m: noise_m, ..Settings::default() };
        let mut person = Person::new(&s.map, Reference::Truth(&truth), &settings).expect("a reference");
        person.look(&s.map).expect("a bent map").correction
    };
    let clean = first(0.0, 1);
    let mut squares = Vec::new();
    for seed in 1..=100 {
        let drawn = first(0.05, seed);
        for (noisy, exact) in [(&drawn.a, &clean.a), (&drawn.b, &clean.b)] {
            let ((pose, noisy), (same, exact)) = (posed(noisy), posed(exact));
            assert_eq!(pose, same);
            squares.extend(noisy.iter().zip(exact).map(|(p, q)| (p - q).norm_squared() / 2.0));
        }
        assert_eq!(drawn, first(0.05, seed));
    }
    let sigma_m = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((sigma_m - 0.05).abs() < 0.005, "{sigma_m}");
}

#[test]
fn a_kick_is_mended_where_it_is_and_insisted_on() {
    for seed in 1..=5 {
        let s = simulated(Scenario::Loop, seed, 1.0);
        let settings = damage::Settings { kind: Kind::Kick, count: 1, seed };
        let (bad, damages) = damage::map(&s.map, &settings).expect("room for it");
        let (drawn, ate_m) = repaired(&bad, &truth_of(&s), &Settings { seed, ..Settings::default() }, 4);
        let first = &drawn[0].correction;
        let (a, b) = (posed(&first.a).0, posed(&first.b).0);
        assert!(a <= damages[0].first && damages[0].first < b, "{damages:?}: {first:?}");
        assert!(b - a < 60 && first.weight > 1.0, "{first:?}");
        assert!(*ate_m.last().expect("strokes") < 0.12, "{seed}: {ate_m:?}");
    }
}

#[test]
fn relations_are_enough_to_repair_a_real_log() {
    let data = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
    let log = io::carmen::read(&data("aces.clf.bz2")).expect("the log of the demo").value;
    let relations = io::relations::read(&data("aces.relations")).expect("its relations").value;
    let chain = hitl_slam::front_end::Chain::Odometry;
    let (map, _) = hitl_slam::front_end::build(&log, chain, &Default::default()).expect("a map");
    let over_120_s = |map: &SlamMap| {
        let errors = metrics::relation_errors(&map.trajectory(), &relations, metrics::DEFAULT_TOLERANCE_S);
        errors.by_span[3].translation_mean_m.expect("some")
    };
    let mut person =
        Person::new(&map, Reference::Relations(&relations), &Settings::default()).expect("a reference");
    let before_m = over_120_s(&map);
    let mut corrector = Corrector::new(map, Options::default()).expect("a map");
    person::repair(&mut corrector, &mut person, 8).expect("a repair");
    let after_m = over_120_s(corrector.map());
    assert!(before_m > 5.0 && after_m < 0.4, "{before_m} → {after_m} m");
}

#[test]
fn a_run_through_a_floor_plan_keeps_off_its_walls_and_can_be_repaired() {
    let Some(path) = shared("amrl_maps/GHC7.vectormap.txt") else { return };
    let walls = io::floor_plan::read(&path).expect("a plan").value;
    let settings = simulate::Settings { seed: 2, ..simulate::Settings::default() };
    let s = simulate::run_through(&walls, 300.0, &settings).expect("a building");
    assert_eq!(s, simulate::run_through(&walls, 300.0, &settings).expect("a building"));
    for pose in &s.truth {
        let nearest = walls.iter().map(|w| {
            let (along_m, across_m) = w.along_across(pose.translation());
            across_m.hypot((along_m.abs() - w.half_length_m).max(0.0))
        });
        let nearest_m = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest_m > 0.1, "{pose:?} is {nearest_m} m from a wall");
    }
    let (_, ate_m) = repaired(&s.map, &truth_of(&s), &Settings::default(), 6);
    assert!(*ate_m.last().expect("a bent map") < 0.15, "{ate_m:?}");
    let text = message(simulate::run_through(&walls, 1.0, &settings));
    assert_eq!(text, "length: found 1, expected metres from 10 to 5000");
    assert!(message(simulate::run_through(&walls[..3], 300.0, &settings)).contains("found no free space"));
}

#[test]
fn settings_and_references_that_make_no_sense_are_refused() {
    let s = simulated(Scenario::Loop, 1, 1.0);
    let truth = truth_of(&s);
    for (settings, part) in [
        (Settings { drawing_noise_m: -1.0, ..Settings::default() }, "drawing noise: found -1"),
        (Settings { wrong: 1.5, ..Settings::default() }, "probability of a wrong wall: found 1.5"),
        (Settings { wrong: f64::NAN, ..Settings::default() }, "probability of a wrong wall: found NaN"),
        (Settings { visible_m: 0.0, ..Settings::default() }, "visible distance: found 0"),
    ] {
        let result = Person::new(&s.map, Reference::Truth(&truth), &settings);
        assert!(message(result).contains(part), "{part}");
    }
    let elsewhere = Trajectory { stamps_s: truth.stamps_s.iter().map(|s| s + 1e6).collect(), ..truth };
    let text = message(Person::new(&s.map, Reference::Truth(&elsewhere), &Settings::default()));
    assert!(text.contains("reference: found no two scans of the map in it"), "{text}");
}
