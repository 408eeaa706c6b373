use hitl_slam::geometry::angle_diff;
use hitl_slam::io::{relations, tum};
use hitl_slam::map::Trajectory;

use crate::support::{Dice, Scratch, message, shared};

#[test]
fn a_trajectory_comes_back_as_it_was_written() {
    let scratch = Scratch::new("tum-round-trip");
    let mut dice = Dice::new(1);
    let poses: Vec<_> = (0..200).map(|_| dice.pose()).collect();
    let stamps_s = (0..200).map(|k| 976052857.337530 + 1e-6 * f64::from(k)).collect();
    let trajectory = Trajectory { stamps_s, poses };
    let path = scratch.path("a.tum");
    tum::write(&path, &trajectory).unwrap();
    let read = tum::read(&path).unwrap();
    assert!(read.warnings.is_empty());
    assert_eq!(read.value.stamps_s, trajectory.stamps_s);
    for (a, b) in read.value.poses.iter().zip(&trajectory.poses) {
        assert_eq!((a.x_m, a.y_m), (b.x_m, b.y_m));
        assert!(angle_diff(a.theta_rad, b.theta_rad).abs() < 1e-15);
    }
}

#[test]
fn lines_that_are_no_pose_are_named() {
    let scratch = Scratch::new("tum-errors");
    let cases = [
        ("1 2 3 0 0 0 1", "a.tum:2: found 7 fields, expected 8: stamp x y z qx qy qz qw"),
        ("1 2 3 0 0 0 0 x", "a.tum:2: qw: found 'x', expected a finite number"),
        ("1 2 NaN 0 0 0 0 1", "a.tum:2: y: found 'NaN', expected a finite number"),
        ("1 2 3 0 0 0 0 inf", "a.tum:2: qw: found 'inf', expected a finite number"),
        ("1 2 3 0 0 0 0 1.2", "a.tum:2: quaternion: found length 1.2, expected 1"),
        ("# only comments", "a.tum: found no pose, expected lines `stamp x y z qx qy qz qw`"),
    ];
    for (line, expected) in cases {
        let path = scratch.file("a.tum", format!("# stamp x y z qx qy qz qw\n{line}\n"));
        assert_eq!(message(tum::read(&path)), expected);
    }
}

#[test]
fn tilted_poses_are_projected_with_a_warning() {
    let scratch = Scratch::new("tum-tilt");
    let path = scratch.file("a.tum", "1 2 3 4 0.1 0 0 0.99498743710662\n");
    let read = tum::read(&path).unwrap();
    assert!(read.warnings[0].ends_with("a.tum:1: the poses are tilted: z, roll and pitch are dropped"));
    assert!(read.value.poses[0].theta_rad.abs() < 1e-12);
}

#[test]
fn relations_are_read_and_their_errors_named() {
    let scratch = Scratch::new("relations");
    let path = scratch.file("a.relations", "1 2 0.5 -0.25 0 0 0 1.5\n\n# x\n");
    let relations = relations::read(&path).unwrap().value;
    assert_eq!(relations.len(), 1);
    assert_eq!((relations[0].stamp_1_s, relations[0].stamp_2_s), (1.0, 2.0));
    assert_eq!(relations[0].first_from_second.to_array(), [0.5, -0.25, 1.5]);
    for (line, expected) in [
        ("1 2 3", "a.relations:1: found 3 fields, expected 8: t1 t2 x y z roll pitch yaw"),
        ("1 2 3 4 5 6 7 inf", "a.relations:1: yaw: found 'inf', expected a finite number"),
        ("", "a.relations: found no relation, expected lines `t1 t2 x y z roll pitch yaw`"),
    ] {
        assert_eq!(message(relations::read(&scratch.file("a.relations", line))), expected);
    }
    for (name, count) in [("radish_raw/intel.relations", 2_984), ("radish_raw/aces.relations", 1_279)] {
        let Some(path) = shared(name) else { return };
        assert_eq!(relations::read(&path).unwrap().value.len(), count);
    }
}
