//! Walks as maps, and maps as walks.

use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::front_end::{WalkOptions, map_of_walks};
use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::map::{AutomaticFactor, Correction, Mode, SlamMap, Stroke};
use hitl_slam::pedestrian::random::Key;
use hitl_slam::pedestrian::{OdometryNoise, Start, Step, Walk, metrics};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::walkers::{Scenario, Settings, Simulation};
use nalgebra::{Matrix3, Vector3};

use crate::support::Scratch;

fn simulate(scenario: Scenario, seed: u64) -> Simulation {
    scenario.run(&Settings { seed, minutes: 2.0, ..Settings::default() }, &[]).unwrap()
}

fn map_of(simulation: &Simulation) -> SlamMap {
    let starts = vec![Start { pose: simulation.starts[0], ..Start::default() }];
    map_of_walks(&simulation.walks, &WalkOptions { starts, ..WalkOptions::default() }).unwrap()
}

/// Positions of every walker's footprints on a map of walks, the start first.
fn paths(map: &SlamMap, walks: &[Walk]) -> Vec<Vec<Vec2>> {
    let all: Vec<Vec2> = map.trajectory().poses.iter().map(|p| p.translation()).collect();
    let mut rest = &all[..];
    let mut split = |walk: &Walk| {
        let (mine, others) = rest.split_at(walk.steps.len() + 1);
        rest = others;
        mine.to_vec()
    };
    walks.iter().map(&mut split).collect()
}

/// Mean over the walkers of the error at the end.
fn end_error_m(simulation: &Simulation, map: &SlamMap) -> f64 {
    let ends = simulation
        .walks
        .iter()
        .zip(paths(map, &simulation.walks))
        .map(|(walk, path)| *metrics::errors_m(walk, &path, &simulation.truth).last().unwrap());
    ends.sum::<f64>() / simulation.walks.len() as f64
}

/// A stroke along a walker's path from one step to another, drawn with 5 cm of noise.
fn stroke(map: &SlamMap, walks: &[Walk], walker: usize, steps: [usize; 2], key: Key) -> Stroke {
    let path = &paths(map, walks)[walker];
    let noise = |k: u64| Vec2::new(key.normal(2 * k), key.normal(2 * k + 1)) * 0.05;
    Stroke::World([path[steps[0]] + noise(0), path[steps[1]] + noise(1)])
}

both_backends! {
    fn corridors_said_to_be_straight_and_the_same_bring_walks_nearer_to_the_truth(backend: Backend) {
        for seed in 1..=3 {
            let simulation = simulate(Scenario::Six, seed);
            let map = map_of(&simulation);
            let mut options = Options::default();
            options.joint.backend = backend;
            options.interpret.drawing_sigma_m = 0.3;
            options.joint.observation_sigma_m = 0.2;
            let mut corrector = Corrector::new(map.clone(), options).unwrap();
            let walkers = simulation.walks.len();
            let straight = (0..walkers).map(|j| ([j, j], [[10, 20], [46, 58]]));
            let same = (1..walkers).map(|j| ([0, j], [[30, 45], [30, 45]]));
            for (number, (who, steps)) in straight.chain(same).enumerate() {
                let key = Key::new(seed).with(number as u64);
                let side = |k: usize| stroke(corrector.map(), &simulation.walks, who[k], steps[k], key.with(k as u64));
                let correction = Correction {
                    id: format!("c{number}"), mode: Mode::Collinear, a: side(0), b: side(1), weight: 1.0, enabled: true,
                };
                let report = corrector.apply(&correction).unwrap();
                assert!(report.accepted(), "seed {seed}, {number}: {:?}", report.rejection);
            }
            let (before, after) = (end_error_m(&simulation, &map), end_error_m(&simulation, corrector.map()));
            assert!(after < 0.4 * before, "seed {seed}: {before:.2} m before, {after:.2} m after");
        }
    }
}

#[test]
fn the_covariance_of_a_window_is_that_of_many_walkers_who_take_its_steps() {
    let step = |forward_m: f64, left_m: f64, turn_rad: f64| Step { time_s: 0.0, forward_m, left_m, turn_rad };
    let steps = [
        step(0.7, 0.1, 0.4),
        step(0.8, 0.0, -0.2),
        step(0.6, -0.1, 2.9),
        step(0.7, 0.0, 0.1),
        step(0.7, 0.0, 0.0),
    ];
    let walk = Walk {
        name: "w".into(),
        steps: steps
            .iter()
            .chain([&steps[0]])
            .enumerate()
            .map(|(k, s)| Step { time_s: k as f64, ..*s })
            .collect(),
    };
    let noise = OdometryNoise { position_m: 0.03, scale: 0.02, ..OdometryNoise::default() };
    let options = WalkOptions { noise, ..WalkOptions::default() };
    let map = map_of_walks(&[walk], &options).unwrap();
    let [factor] = &map.relative_factors[..] else { panic!("one factor") };
    // The particle model of docs/MATH-pedestrian.md, step by step.
    let (mut sum, count) = (Matrix3::zeros(), 20_000);
    for walker in 0..count {
        let key = Key::new(7).with(walker);
        let (mut rho, scale) = (noise.drift_start_rad * key.normal(0), 1.0 + noise.scale * key.normal(1));
        let (mut phi, mut heading, mut p) = (0.0, 0.0_f64, Vec2::zeros());
        for (k, s) in steps.iter().enumerate() {
            let normal = |n: u64| key.normal(2 + 4 * k as u64 + n);
            let share = s.length_m() / OdometryNoise::STEP_M;
            rho += share.sqrt() * noise.drift_rad * normal(0);
            phi += share * rho + share.sqrt() * noise.heading_rad * normal(1);
            let d = Pose2::new(0.0, 0.0, heading + phi).rotate(Vec2::new(s.forward_m, s.left_m));
            p += d * scale + Vec2::new(normal(2), normal(3)) * (share.sqrt() * noise.position_m);
            heading += s.turn_rad;
        }
        let e = factor.i_from_j.between(Pose2::new(p.x, p.y, heading + phi)).to_array();
        let e = Vector3::from(e);
        sum += e * e.transpose();
    }
    let (sampled, modelled) = (sum / count as f64, factor.information.covariance());
    for (r, c) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let size = (modelled[(r, r)] * modelled[(c, c)]).sqrt();
        let difference = (sampled[(r, c)] - modelled[(r, c)]).abs() / size;
        assert!(difference < 0.05, "entry {r}, {c}: {sampled} sampled, {modelled} modelled");
    }
}

#[test]
fn a_map_of_walks_gives_the_walks_back() {
    let scratch = Scratch::new("walks-of-map");
    for seed in 1..=2 {
        let simulation = simulate(Scenario::Rooms, seed);
        let map = map_of(&simulation);
        let native = scratch.path("m.npz");
        io::write_map(&native, &map).unwrap();
        let io::Source::Map(read) = io::read(&native).unwrap().1.value else { panic!("a map") };
        assert_eq!(read, map);
        let back = io::walks_of_map::walks(&read).unwrap();
        assert_eq!(back.len(), simulation.walks.len());
        for ((walk, start), original) in back.iter().zip(&simulation.walks) {
            let [a, b] = [start, &simulation.starts[0]].map(|p| p.to_array());
            assert!(a.iter().zip(b).all(|(p, q)| (p - q).abs() < 1e-9));
            // Steps without motion and tiny ones are merged; nobody is displaced by that.
            let ends = [walk.track(*start), original.track(*start)].map(|t| *t.last().unwrap());
            assert!((ends[0].translation() - ends[1].translation()).norm() < 1e-9);
            for s in &walk.steps {
                let at = |w: &Walk| {
                    let track: Vec<Vec2> = w.track(*start).iter().map(|p| p.translation()).collect();
                    track[w.steps.partition_point(|t| t.time_s <= s.time_s)]
                };
                assert!((at(walk) - at(original)).norm() < 1e-9, "at {} s", s.time_s);
            }
        }
    }
}

#[test]
fn footprints_of_a_corridor_walked_there_and_back_have_one_face() {
    for heading_deg in [-180.0f64, -90.0, 0.0, 37.0, 90.0, 179.0] {
        let step =
            |k: u32, turn_rad: f64| Step { time_s: f64::from(k), forward_m: 0.7, left_m: 0.0, turn_rad };
        let steps = (0..40).map(|k| step(k, if k == 19 { std::f64::consts::PI } else { 0.0 })).collect();
        let start = Start { pose: Pose2::new(0.0, 0.0, heading_deg.to_radians()), ..Start::default() };
        let options = WalkOptions { starts: vec![start], ..WalkOptions::default() };
        let map = map_of_walks(&[Walk { name: "w".into(), steps }], &options).unwrap();
        let seen = &map.observations;
        let world = |p: usize| map.poses[seen.pose_of(p)].rotate(seen.normal(p));
        let across = Vec2::new(-start.pose.theta_rad.sin(), start.pose.theta_rad.cos());
        let faces: Vec<f64> = (0..seen.len())
            .map(|p| world(p).dot(&across))
            .filter(|f| f.abs() > 0.5)
            .map(f64::signum)
            .collect();
        assert!(faces.len() > 35 && faces.iter().all(|f| *f == faces[0]), "{heading_deg}°: {faces:?}");
    }
}

#[test]
fn on_a_map_of_walks_nothing_is_matched_and_what_was_is_forgotten() {
    let simulation = simulate(Scenario::Six, 1);
    let mut map = map_of(&simulation);
    assert!(map.points_are_footprints());
    let again = |map: &mut SlamMap| {
        let (joint, options) = (Default::default(), Default::default());
        closures::reassociate(map, &joint, &options, &|_| (), &AtomicBool::new(false)).unwrap().unwrap()
    };
    let off = closures::Report { footprints: true, ..Default::default() };
    let before = map.clone();
    assert_eq!(again(&mut map), off);
    assert_eq!(map, before);
    let factor = map.relative_factors[3];
    map.automatic_factors =
        vec![AutomaticFactor { factor, inliers: 1.0, ambiguity: 0.0, weak_rad: None, chi2: 0.0 }];
    assert_eq!(again(&mut map), off);
    assert!(map.automatic_factors.is_empty());
    // One point that is not where its walker trod, and they are a laser's.
    map.observations.points[7][0] += 0.01;
    assert!(!map.points_are_footprints());
    let settings = hitl_slam::simulate::Settings::default();
    let run = hitl_slam::simulate::run(hitl_slam::simulate::Scenario::Loop, &settings).unwrap();
    assert!(!run.map.points_are_footprints() && !SlamMap::default().points_are_footprints());
}

#[test]
fn several_walks_are_tied_where_they_began_and_nowhere_else() {
    let simulation = simulate(Scenario::Six, 1);
    let starts: Vec<Start> = (0..6)
        .map(|k| Start { pose: Pose2::new(f64::from(k), 2.0, 3.0 - f64::from(k)), ..Start::default() })
        .collect();
    let options = WalkOptions { starts: starts.clone(), ..WalkOptions::default() };
    let map = map_of_walks(&simulation.walks, &options).unwrap();
    assert_eq!(map.relative_factors.len(), map.poses.len() - 1, "a tree");
    let began =
        |pose: &Pose2| starts.iter().any(|s| (s.pose.translation() - pose.translation()).norm() < 1e-9);
    let firsts = io::walks_of_map::first_poses(&map);
    assert!(firsts.len() == 6 && firsts.iter().all(|&first| began(&map.poses[first])), "{firsts:?}");
    for f in &map.relative_factors {
        assert!(f.chi2(map.poses[f.i], map.poses[f.j]) < 1e-12, "every factor is met");
        assert!(f.i + 1 == f.j || f.i == 0);
    }
    let first_poses = map.relative_factors.iter().filter(|f| f.i + 1 != f.j).map(|f| map.poses[f.j]);
    assert!(
        first_poses.zip(&starts[1..]).all(|(p, s)| (p.translation() - s.pose.translation()).norm() < 1e-12)
    );

    let bad = |starts: &[Start]| WalkOptions { starts: starts.to_vec(), ..WalkOptions::default() };
    assert!(map_of_walks(&simulation.walks, &bad(&starts[..2])).is_err());
    assert!(map_of_walks(&[], &bad(&starts[..1])).is_err());
}

#[test]
fn a_corrected_robot_trajectory_is_a_better_walk_than_its_odometry() {
    for seed in 1..=3 {
        let settings = hitl_slam::simulate::Settings { seed, ..Default::default() };
        let run = hitl_slam::simulate::run(hitl_slam::simulate::Scenario::Loop, &settings).unwrap();
        let mut corrector = Corrector::new(run.map.clone(), Options::default()).unwrap();
        run.corrections.iter().for_each(|c| drop(corrector.apply(c).unwrap()));
        let error_m = |map: &SlamMap| {
            let found = io::walks_of_map::walks(map).unwrap();
            let [(walk, start)] = &found[..] else { panic!("one robot, one walk") };
            assert!(walk.steps.iter().all(|s| s.length_m() < 2.5));
            // Where the walk has the robot at the time of a pose, against where it truly was.
            let track: Vec<Vec2> = walk.track(*start).iter().map(|p| p.translation()).collect();
            let stamps = run.map.stamps_s.as_ref().unwrap();
            let errors: Vec<f64> = stamps
                .iter()
                .zip(&run.truth)
                .filter_map(|(&t, p)| Some((walk.position_at(&track, t)? - p.translation()).norm()))
                .collect();
            errors.iter().sum::<f64>() / errors.len() as f64
        };
        let (before, after) = (error_m(&run.map), error_m(corrector.map()));
        assert!(after < 0.5 * before, "seed {seed}: {before:.2} m before, {after:.2} m after");
    }
}
