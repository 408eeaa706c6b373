//! From a raw log to a map.

use std::f64::consts::PI;

use hitl_slam::front_end::{self, Chain, Options};
use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io::{carmen, g2o};
use hitl_slam::map::{LogScan, Observations, RawLog, SlamMap, Trajectory};

use crate::support::{Scratch, message, shared, small_log};

fn log(scans: usize) -> RawLog {
    let scratch = Scratch::new(&format!("front-end-{scans}-{:?}", std::thread::current().id()));
    carmen::read(&scratch.file("a.clf", small_log(scans))).unwrap().value
}

fn build(log: &RawLog, chain: Chain<'_>) -> SlamMap {
    let (map, warnings) = front_end::build(log, chain, &Options::default()).unwrap();
    assert_eq!(warnings, [""; 0]);
    map
}

fn close(a: Pose2, b: Pose2) -> bool {
    a.between(b).to_array().iter().all(|v| v.abs() < 1e-9)
}

#[test]
fn keyframes_are_made_by_motion_and_every_scan_hangs_on_the_last_one() {
    let log = log(10);
    let map = build(&log, Chain::Odometry);
    // 0.1 m a scan, a keyframe every 0.25 m: scans 0, 3, 6, 9.
    assert_eq!(map.stamps_s.as_deref(), Some(&[100.0, 100.3, 100.6, 100.9][..]));
    assert_eq!(map.scans.iter().map(|s| s.parent).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1, 2, 2, 2, 3]);
    let trajectory = map.trajectory();
    for (pose, scan) in trajectory.poses.iter().zip(&log.scans) {
        assert!(close(*pose, scan.odometry_from_robot));
    }
    assert_eq!(map.relative_factors.len(), 3);
    let factor = &map.relative_factors[1];
    assert!(close(factor.i_from_j, Pose2::new(0.3, 0.0, 0.0)));
    let c = factor.information.covariance();
    assert!((c[(0, 0)].sqrt() - 0.02).abs() < 1e-9 && (c[(1, 1)].sqrt() - 0.014).abs() < 1e-9);
    assert!((c[(2, 2)].sqrt() - 0.008).abs() < 1e-9);
    assert_eq!(map.robot_from_laser, log.robot_from_laser);
}

#[test]
fn the_error_of_a_step_lies_along_its_direction_in_the_frame_of_the_second_pose() {
    let noise = front_end::OdometryNoise::default();
    // One metre to the left while turning left by 90°: seen from the second pose that is straight ahead.
    let information = noise.information(Pose2::new(0.0, 1.0, PI / 2.0));
    let c = information.covariance();
    assert!(c[(0, 0)] > 2.0 * c[(1, 1)] && c[(0, 1)].abs() < 1e-9);
}

#[test]
fn returns_are_taken_into_the_robot_frame_with_normals_to_the_sensor() {
    // A wall 2 m ahead of a laser that sits 0.5 m ahead of the robot and looks to the left.
    let bearings: Vec<f64> = (-60..=60).map(|d| f64::from(d).to_radians()).collect();
    let mut scan = LogScan {
        stamp_s: 0.0,
        odometry_from_robot: Pose2::IDENTITY,
        world_from_robot: Pose2::IDENTITY,
        first_bearing_rad: bearings[0],
        bearing_step_rad: 1_f64.to_radians(),
        max_range_m: 80.0,
        ranges_m: bearings.iter().map(|b| (2.0 / b.cos()) as f32).collect(),
    };
    scan.ranges_m[3] = 81.0;
    scan.ranges_m[4] = 0.05;
    let mut o = Observations { starts: vec![0], ..Observations::default() };
    front_end::observe(&scan, Pose2::new(0.5, 0.0, PI / 2.0), &Options::default(), &mut o);
    assert_eq!(o.len(), 119);
    for k in 0..o.len() {
        assert!((o.point(k).y - 2.0).abs() < 1e-5, "{}", o.point(k));
        assert!((o.normal(k) - Vec2::new(0.0, -1.0)).norm() < 1e-4, "{k}: {}", o.normal(k));
        assert!((f64::from(o.ranges_m[k]) - (o.point(k) - Vec2::new(0.5, 0.0)).norm()).abs() < 1e-5);
    }
    // Lone returns and blobs have no normal.
    scan.ranges_m = vec![1.0, 5.0, 9.0, 5.0];
    let mut o = Observations::default();
    front_end::observe(&scan, Pose2::IDENTITY, &Options::default(), &mut o);
    assert!((0..4).all(|k| o.normal(k) == Vec2::zeros()));
}

#[test]
fn the_poses_of_the_log_stand_as_they_are() {
    let mut log = log(10);
    for (k, scan) in log.scans.iter_mut().enumerate() {
        scan.world_from_robot = Pose2::new(0.0, k as f64 * 0.3, 1.0);
    }
    let map = build(&log, Chain::LoggedPoses);
    assert_eq!(map.poses.len(), 10);
    assert_eq!(map.poses[7], log.scans[7].world_from_robot);
}

#[test]
fn a_trajectory_gives_its_poses_to_the_scans_it_names_and_odometry_the_rest() {
    let log = log(10);
    let given = |k: usize| Pose2::new(5.0, 0.5 * k as f64, PI / 2.0);
    let keyframes = [1, 4, 7];
    let trajectory = Trajectory {
        stamps_s: keyframes.iter().map(|&k| 100.0 + 0.1 * k as f64 + 0.01).collect(),
        poses: keyframes.iter().map(|&k| given(k)).collect(),
    };
    let map = build(&log, Chain::Initial(&trajectory));
    assert_eq!(map.poses, trajectory.poses);
    let all = map.trajectory();
    assert_eq!(all.stamps_s.len(), 10);
    for k in 0..10_usize {
        let anchor = keyframes.iter().rev().find(|&&a| a <= k).copied().unwrap_or(1);
        let offset = log.scans[anchor].odometry_from_robot.between(log.scans[k].odometry_from_robot);
        assert!(close(all.poses[k], given(anchor).compose(offset)), "scan {k}");
    }
    let (_, warnings) = front_end::build(
        &log,
        Chain::Initial(&Trajectory { stamps_s: vec![100.0, 100.56], poses: vec![given(0); 2] }),
        &Options::default(),
    )
    .unwrap();
    assert_eq!(warnings, [""; 0]);
    let foreign = Trajectory { stamps_s: vec![5.0], poses: vec![Pose2::IDENTITY] };
    let text = message(front_end::build(&log, Chain::Initial(&foreign), &Options::default()));
    assert!(text.starts_with("--initial: found no stamp within 0.0"), "{text}");
}

fn ring(n: usize) -> SlamMap {
    let scratch = Scratch::new(&format!("ring-{n}-{:?}", std::thread::current().id()));
    let mut text: String = (0..n).map(|k| format!("VERTEX_SE2 {} {k} 0.5 0.25\n", 10 * k)).collect();
    for k in 1..n {
        text += &format!("EDGE_SE2 {} {} 1 0 0 9 1 0 8 0 7\n", 10 * (k - 1), 10 * k);
    }
    text += &format!("EDGE_SE2 0 {} 1 0 0 9 1 0 8 0 7\n", 10 * (n - 1));
    g2o::read(&scratch.file("a.g2o", text)).unwrap().value
}

#[test]
fn a_graph_keeps_its_poses_and_closures_and_gets_the_scans() {
    let log = log(10);
    let graph = ring(4);
    let stamps = Trajectory { stamps_s: vec![100.1, 100.3, 100.5, 100.9], poses: vec![Pose2::IDENTITY; 4] };
    let map = build(&log, Chain::Graph { graph: &graph, stamps: Some(&stamps) });
    assert_eq!((&map.poses, &map.relative_factors), (&graph.poses, &graph.relative_factors));
    assert_eq!(map.vertex_ids, graph.vertex_ids);
    assert_eq!(map.scans.iter().map(|s| s.parent).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 2, 2, 2, 2, 3]);
    assert!(close(map.scans[0].parent_from_robot, Pose2::new(-0.1, 0.0, 0.0)));
    assert!(close(map.scans[8].parent_from_robot, Pose2::new(0.3, 0.0, 0.0)));
    assert!((0..4).all(|pose| map.observations.range(pose).len() == 181));
    // As many vertices as scans: one to one.
    let map = build(&log, Chain::Graph { graph: &ring(10), stamps: None });
    assert_eq!(map.scans.iter().map(|s| s.parent).collect::<Vec<_>>(), (0..10).collect::<Vec<_>>());
    let chain = Chain::Graph { graph: &graph, stamps: None };
    let text = message(front_end::build(&log, chain, &Options::default()));
    assert!(
        text.starts_with("--graph: found 4 vertices without stamps for 10 scans, expected ROBOTLASER1"),
        "{text}"
    );
}

#[test]
fn bad_options_are_named() {
    let options = Options { keyframe_distance_m: 0.0, ..Options::default() };
    let text = message(front_end::build(&log(2), Chain::Odometry, &options));
    assert_eq!(text, "keyframe distance: found 0, expected a number > 0");
    let options = Options { min_range_m: 40.0, ..Options::default() };
    let text = message(front_end::build(&log(2), Chain::Odometry, &options));
    assert_eq!(text, "minimum range: found 40, expected less than the maximum of 30");
}

#[test]
fn the_public_logs_become_maps() {
    for (name, scans) in [("radish_raw/intel.clf.bz2", 13_631), ("ual/ual_2014_05_23.clf.bz2", 3_318)] {
        let Some(path) = shared(name) else { return };
        let log = carmen::read(&path).unwrap().value;
        let map = build(&log, Chain::Odometry);
        assert_eq!(map.scans.len(), scans);
        let with_normal =
            (0..map.observations.len()).filter(|&k| map.observations.normal(k) != Vec2::zeros()).count();
        println!(
            "{name}: {} keyframes, {} points, {with_normal} with a normal",
            map.poses.len(),
            map.observations.len()
        );
        assert!(map.poses.len() > 1_000 && with_normal * 2 > map.observations.len());
        // The log's own trajectory as --initial gives every scan its own pose back, equal stamps or not.
        let trajectory = Trajectory {
            stamps_s: log.scans.iter().map(|s| s.stamp_s).collect(),
            poses: log.scans.iter().map(|s| s.odometry_from_robot).collect(),
        };
        let again = build(&log, Chain::Initial(&trajectory));
        assert_eq!(again, map);
    }
}
