use hitl_slam::geometry::{Information, Pose2, Vec2, angle_diff};
use hitl_slam::io::stfs;
use hitl_slam::map::{Observations, RelativeFactor, SlamMap};

use crate::support::{Dice, Scratch, message};

const ZERO: &str = "0,0,0,0,0,0,0,0,0";
const STEP: &str = "7e-4,1e-4,0,1e-4,5e-4,2e-5,0,2e-5,1.2e-4";

fn text(lines: &[String]) -> String {
    format!("map\n1400000000\n{}\n", lines.join("\n"))
}

#[test]
fn points_and_normals_come_into_the_robot_frame() {
    let scratch = Scratch::new("stfs-frames");
    let lines = [
        format!("0,0,0,1,0,-1,0,{ZERO}"),
        format!("1,2,1.5707963267948966,1,5,0,-1,{STEP}"),
        format!("1,2,1.5707963267948966,-1,2,1,0,{STEP}"),
    ];
    let map = stfs::read(&scratch.file("a.stfs.covars", text(&lines))).unwrap().value;
    assert_eq!((map.poses.len(), map.observations.starts.clone()), (2, vec![0, 1, 3]));
    let o = &map.observations;
    // Pose 1 looks along +y: a point 3 m north of it is 3 m ahead, its normal looks back (not moved by the position).
    assert!((o.point(1) - Vec2::new(3.0, 0.0)).norm() < 1e-12);
    assert!((o.normal(1) - Vec2::new(-1.0, 0.0)).norm() < 1e-7);
    assert!((o.point(2) - Vec2::new(0.0, 2.0)).norm() < 1e-12);
    assert!((o.ranges_m[1] - 3.0).abs() < 1e-6);
    assert_eq!(map.relative_factors.len(), 1);
    assert_eq!(map.relative_factors[0].i_from_j, map.poses[0].between(map.poses[1]));
}

/// chi2 of a step must be that of its displacement in world axes: the covariance is turned the right way.
#[test]
fn the_covariance_is_turned_into_the_frame_of_the_residual() {
    let scratch = Scratch::new("stfs-covariance");
    let lines = [format!("3,1,0.4,1,0,-1,0,{ZERO}"), format!("1,2,2.2,1,5,0,-1,{STEP}")];
    let map = stfs::read(&scratch.file("a.stfs.covars", text(&lines))).unwrap().value;
    let c = nalgebra::Matrix3::new(7e-4, 1e-4, 0.0, 1e-4, 5e-4, 2e-5, 0.0, 2e-5, 1.2e-4);
    let world = Information::from_covariance(c).unwrap();
    let (dx, dy, dtheta) = (0.03, -0.05, 0.02);
    let moved = Pose2::new(1.0 + dx, 2.0 + dy, 2.2 + dtheta);
    let expected = world.chi2(Vec2::new(dx, dy), dtheta);
    let found = map.relative_factors[0].chi2(map.poses[0], moved);
    assert!((found - expected).abs() < 1e-9 * expected, "{found} {expected}");
}

#[test]
fn a_map_comes_back_as_it_was_written() {
    let scratch = Scratch::new("stfs-round-trip");
    for seed in 0..10 {
        let mut dice = Dice::new(seed);
        let mut map = dice.map(12);
        // What the format can hold: measurements that are the differences of the poses.
        map.relative_factors.retain(|f| f.j == f.i + 1);
        for f in &mut map.relative_factors {
            f.i_from_j = map.poses[f.i].between(map.poses[f.j]);
        }
        let path = scratch.path("a.stfs.covars");
        stfs::write(&path, &map).unwrap();
        let read = stfs::read(&path).unwrap().value;
        assert_eq!(read.poses, map.poses);
        assert_eq!(read.observations.starts, map.observations.starts);
        for k in 0..map.observations.len() {
            assert!((read.observations.point(k) - map.observations.point(k)).norm() < 1e-9);
            assert!((read.observations.normal(k) - map.observations.normal(k)).norm() < 1e-6);
        }
        for (a, b) in read.relative_factors.iter().zip(&map.relative_factors) {
            let difference = (a.information.matrix() - b.information.matrix()).amax();
            assert!(difference < 1e-8 * b.information.matrix().amax(), "seed {seed}: {difference}");
        }
    }
}

#[test]
fn poses_without_points_are_joined_with_the_next_step() {
    let scratch = Scratch::new("stfs-empty-pose");
    let mut observations = Observations { starts: vec![0], ..Observations::default() };
    for pose in 0..3 {
        if pose != 1 {
            observations.push(Vec2::new(1.0, 0.0), Vec2::zeros(), 1.0);
        }
        observations.end_pose();
    }
    let poses = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]].map(Pose2::from_array).to_vec();
    let factor = |i: usize| RelativeFactor {
        i,
        j: i + 1,
        i_from_j: poses[i].between(poses[i + 1]),
        information: Information::from_sigmas(0.1, 0.2, 0.01),
    };
    let relative_factors = vec![factor(0), factor(1)];
    let map = SlamMap { poses, observations, relative_factors, ..SlamMap::default() };
    let path = scratch.path("a.stfs.covars");
    stfs::write(&path, &map).unwrap();
    let read = stfs::read(&path).unwrap().value;
    assert_eq!(read.poses.len(), 2);
    let c = read.relative_factors[0].information.covariance();
    // The first step's heading error of 0.01 rad acts over the 2 m of the second.
    assert!((c[(0, 0)] - 0.02).abs() < 1e-9 && (c[(1, 1)] - (0.08 + 4e-4)).abs() < 1e-9);
    assert!((c[(1, 2)] - 2e-4).abs() < 1e-9 && (c[(2, 2)] - 2e-4).abs() < 1e-9);
    let broken = SlamMap { relative_factors: Vec::new(), ..map };
    let text = message(stfs::write(&scratch.path("b.stfs.covars"), &broken));
    assert_eq!(text, "b.stfs.covars: found no relative factor from pose 0 to 1, expected a chain");
    assert!(!scratch.path("b.stfs.covars").exists());
}

#[test]
fn faults_are_named_with_line_and_field() {
    let scratch = Scratch::new("stfs-errors");
    let not_positive = "covariance of pose 1: covariance: found one that is not positive definite, expected a positive definite one";
    let cases = [
        ("1,0,0,1,0,0,1,7e-4,0".to_string(), "found 9 fields, expected 16 comma-separated numbers"),
        (format!("1,0,0,1,0,0,1,{STEP},4"), "found 17 fields, expected 16 comma-separated numbers"),
        (String::new(), "found 1 fields, expected 16 comma-separated numbers"),
        (format!("1,0,0,1,nan,0,1,{STEP}"), "point_y: found 'nan', expected a finite number"),
        (format!("1,0,x,1,0,0,1,{STEP}"), "pose_th: found 'x', expected a finite number"),
        (format!("1,0,0,1,0,0,,{STEP}"), "normal_y: found '', expected a finite number"),
        (format!("1,0,0,1,0,0,1,{STEP}e999"), "Cthth: found '1.2e-4e999', expected a finite number"),
        (format!("1,0,0,1,0,0,1,{ZERO}"), not_positive),
        ("1,0,0,1,0,0,1,1,0,0,0,-1,0,0,0,1".to_string(), not_positive),
        (
            "1,0,0,1,0,0,1,1,0.5,0,0,1,0,0,0,1".to_string(),
            "covariance of pose 1: found an asymmetric matrix, expected a symmetric one",
        ),
    ];
    for (line, expected) in cases {
        let path = scratch.file("a.stfs.covars", text(&[format!("0,0,0,1,0,-1,0,{ZERO}"), line]));
        assert_eq!(message(stfs::read(&path)), format!("a.stfs.covars:4: {expected}"));
    }
    let path = scratch.file("a.stfs.covars", "map\n1\n");
    let expected = "a.stfs.covars:3: found no laser return, expected 16 comma-separated numbers a line";
    assert_eq!(message(stfs::read(&path)), expected);
    let path = scratch.file("a.stfs.covars", "map\n");
    let expected = "a.stfs.covars:2: found the end of the file, expected a time stamp";
    assert_eq!(message(stfs::read(&path)), expected);
}

#[test]
fn headings_near_pi_do_not_jump() {
    let scratch = Scratch::new("stfs-pi");
    let lines = [format!("0,0,3.1415,1,0,-1,0,{ZERO}"), format!("-0.1,0,-3.1415,1,0,-1,0,{STEP}")];
    let map = stfs::read(&scratch.file("a.stfs.covars", text(&lines))).unwrap().value;
    assert!(angle_diff(map.relative_factors[0].i_from_j.theta_rad, 1.853e-4).abs() < 1e-6);
}
