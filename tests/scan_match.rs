//! Scan matching: the parts against naive twins, the chain on the real log that ships with the project.

use std::path::{Path, PathBuf};

use hitl_slam::front_end::{self, Chain, Options};
use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::map::{RawLog, SlamMap};
use hitl_slam::metrics::relation_errors;
use hitl_slam::scan_match::{Cloud, Prior, Schedule, Search, Surfel, SurfelMap, Window, align};
use hitl_slam::simulate::{self, Scenario, Settings};
use nalgebra::Matrix3;

use crate::support::{Dice, shared};

const SCHEDULE: Schedule = Schedule { coarse_m: 0.5, fine_m: 0.2, rounds: 12 };

fn aces() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/aces.clf.bz2")
}

fn chain(log: &RawLog) -> SlamMap {
    let progress = |_| {};
    let chain = Chain::ScanMatch { progress: &progress };
    front_end::build(log, chain, &Options::for_scan_matching()).expect("a log").0
}

/// A corner of a simulated building: a local map in the frame of pose 20, and the scan of pose 24 with its true place.
fn corner() -> (SurfelMap, Cloud, Pose2) {
    let s = simulate::run(Scenario::Loop, &Settings { seed: 3, ..Settings::default() }).expect("a run");
    let (reference, query) = (s.truth[20], s.truth[24]);
    let mut points = Vec::new();
    for pose in 10..=20 {
        let from_robot = reference.between(s.truth[pose]);
        for i in s.map.observations.range(pose) {
            let normal = s.map.observations.normal(i);
            if normal != Vec2::zeros() {
                let mean = from_robot.transform_point(s.map.observations.point(i));
                points.push(Surfel { mean, normal: from_robot.rotate(normal) });
            }
        }
    }
    let range = s.map.observations.range(24);
    let cloud = Cloud {
        points: range.clone().map(|i| s.map.observations.point(i)).collect(),
        normals: range.map(|i| s.map.observations.normal(i)).collect(),
    };
    (SurfelMap::new(points), cloud, reference.between(query))
}

#[test]
fn the_nearest_surfel_is_the_one_that_a_search_of_all_finds() {
    let mut dice = Dice::new(1);
    let direction = |angle: f64| Vec2::new(angle.cos(), angle.sin());
    let mut random = |reach: f64| Vec2::new(dice.uniform(-reach, reach), dice.uniform(-reach, reach));
    let points = (0..2000).map(|_| (random(6.0), random(1.0)));
    let points = points.map(|(mean, n)| Surfel { mean, normal: direction(n.y.atan2(n.x)) }).collect();
    let map = SurfelMap::new(points);
    for _ in 0..2000 {
        let (point, n) = (random(7.0), random(1.0));
        let normal = if n.x > 0.5 { Vec2::zeros() } else { direction(n.y.atan2(n.x)) };
        let agrees = |s: &&Surfel| {
            (s.mean - point).norm() < 0.4 && (normal == Vec2::zeros() || s.normal.dot(&normal) > 0.7)
        };
        let naive = map
            .surfels()
            .iter()
            .filter(agrees)
            .min_by(|a, b| (a.mean - point).norm_squared().total_cmp(&(b.mean - point).norm_squared()));
        assert_eq!(map.nearest(point, normal, 0.4, 0.7), naive);
    }
    assert_eq!(SurfelMap::new(Vec::new()).nearest(Vec2::zeros(), Vec2::zeros(), 1.0, 0.7), None);
}

#[test]
fn the_two_faces_of_a_wall_stay_apart() {
    let mut dice = Dice::new(2);
    let face = |y: f64, side: f64, dice: &mut Dice| Surfel {
        mean: Vec2::new(dice.uniform(0.0, 3.0), y + dice.normal(0.01)),
        normal: Vec2::new(0.0, side),
    };
    let points =
        (0..600).map(|k| if k % 2 == 0 { face(0.0, -1.0, &mut dice) } else { face(0.1, 1.0, &mut dice) });
    let map = SurfelMap::new(points.collect());
    for s in map.surfels() {
        let expected = if s.normal.y < 0.0 { 0.0 } else { 0.1 };
        assert!((s.mean.y - expected).abs() < 0.02, "{s:?}");
    }
}

#[test]
fn a_scan_that_starts_20_cm_and_8_degrees_off_finds_its_place() {
    let (map, cloud, truth) = corner();
    let mut dice = Dice::new(3);
    for _ in 0..50 {
        let off = Pose2::new(dice.uniform(-0.2, 0.2), dice.uniform(-0.2, 0.2), dice.uniform(-0.14, 0.14));
        let found = align(&map, &cloud, truth.compose(off), None, SCHEDULE);
        let error = truth.between(found.pose);
        assert!(error.translation().norm() < 0.03 && error.theta_rad.abs() < 0.01, "{off:?}: {error:?}");
        assert!(found.inliers > 0.7 && found.covered >= found.inliers);
        assert!(found.hessian.cholesky().is_some(), "a corner holds a scan in every direction");
    }
}

#[test]
fn a_strong_prior_wins_and_an_empty_map_leaves_the_start() {
    let (map, cloud, truth) = corner();
    let start = truth.compose(Pose2::new(0.1, 0.0, 0.0));
    let prior = Prior { pose: start, information: Matrix3::identity() * 1e12 };
    let held = align(&map, &cloud, start, Some(&prior), SCHEDULE);
    assert!((held.pose.translation() - start.translation()).norm() < 1e-4);
    let lost = align(&SurfelMap::new(Vec::new()), &cloud, start, None, SCHEDULE);
    assert_eq!((lost.pose, lost.inliers, lost.covered), (start, 0.0, 0.0));
}

#[test]
fn the_search_finds_a_scan_half_a_metre_and_15_degrees_away() {
    let (map, cloud, truth) = corner();
    let search = Search::new(&map);
    let window = Window {
        position_m: 0.6,
        heading_rad: 20_f64.to_radians(),
        position_step_m: 0.1,
        heading_step_rad: 1_f64.to_radians(),
    };
    for off in [Pose2::new(0.4, -0.3, 0.26), Pose2::new(-0.5, 0.2, -0.26)] {
        let coarse = search.best(&cloud.points, truth.compose(off), window).pose;
        let error = truth.between(align(&map, &cloud, coarse, None, SCHEDULE).pose);
        assert!(error.translation().norm() < 0.03 && error.theta_rad.abs() < 0.01, "{off:?}: {error:?}");
    }
}

#[test]
fn the_aces_log_becomes_a_crisp_chain_with_a_pose_for_every_scan() {
    let log = io::carmen::read(&aces()).expect("the log of the demo").value;
    let map = chain(&log);
    assert_eq!(map.scans.len(), 7374);
    let relations = aces().with_file_name("aces.relations");
    let relations = io::relations::read(&relations).expect("its relations").value;
    let errors = relation_errors(&map.trajectory(), &relations, 0.02);
    let short = &errors.by_span[0];
    let (m, deg) = (short.translation_mean_m.expect("some"), short.rotation_mean_deg.expect("some"));
    // Raw odometry: 0.0374 m, 0.87°; what is left is the relations' own noise, 0.033 m.
    assert!(m <= 0.034 && deg <= 0.31, "relations below 10 s: {m} m, {deg}°");
}

#[test]
fn the_chain_does_not_depend_on_how_the_odometry_is_turned() {
    let mut log = io::carmen::read(&aces()).expect("the log of the demo").value;
    log.scans.truncate(700);
    let upright = chain(&log);
    for angle in [0.7, 2.4, -3.1] {
        let by = Pose2::new(5.0, -3.0, angle);
        let mut turned = log.clone();
        for scan in &mut turned.scans {
            scan.odometry_from_robot = by.compose(scan.odometry_from_robot);
        }
        let map = chain(&turned);
        assert_eq!(map.poses.len(), upright.poses.len());
        for (a, b) in map.poses.iter().zip(&upright.poses) {
            let back = by.inverse().compose(*a);
            assert!((back.translation() - b.translation()).norm() < 1e-3, "{angle}: {back:?} {b:?}");
        }
    }
}

#[test]
fn a_scan_after_a_gap_in_the_log_is_where_the_odometry_says_and_not_where_it_looks_alike() {
    // The robot turns round in the gap; taken for standing still, the rest of the map lay the wrong way round.
    let log = io::carmen::read(&aces()).expect("the log of the demo").value;
    for (first, last) in [(5433, 5806), (5041, 5419)] {
        let mut gap = log.clone();
        gap.scans = [&log.scans[first - 300..first], &log.scans[last + 1..last + 100]].concat();
        let estimate = chain(&gap).trajectory();
        let moved = estimate.poses[299].between(estimate.poses[300]);
        let odometry =
            log.scans[first - 1].odometry_from_robot.between(log.scans[last + 1].odometry_from_robot);
        let error = odometry.between(moved);
        assert!(error.theta_rad.abs() < 0.36 && error.translation().norm() < 1.0, "{odometry:?}: {error:?}");
    }
}

#[test]
fn frozen_odometry_is_noticed() {
    // CSAIL: five scans while the encoders stand still and the robot turns, then 85° in one step. Believed, it costs 9 m.
    let Some(log) = shared("radish_raw/mit-csail.clf.bz2") else { return };
    let Some(reference) = shared("radish_ref/mit-csail.ref.csv") else { return };
    let map = chain(&io::carmen::read(&log).expect("a log").value);
    let estimate = map.trajectory();
    let text = std::fs::read_to_string(reference).expect("a reference");
    let rows = text.lines().skip(1).map(|line| {
        let v: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        (v[0] as usize, Pose2::new(v[2], v[3], v[4]))
    });
    let pairs: Vec<(Vec2, Vec2)> =
        rows.map(|(scan, truth)| (estimate.poses[scan].translation(), truth.translation())).collect();
    let aligned = hitl_slam::metrics::align(&pairs);
    let errors = pairs.iter().map(|(p, q)| (aligned.transform_point(*p) - q).norm_squared());
    let ate_m = (errors.sum::<f64>() / pairs.len() as f64).sqrt();
    assert!(ate_m < 0.3, "ATE {ate_m} m");
}
