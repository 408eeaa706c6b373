//! Stage 1: a stroke drawn with a shaky hand finds its wall, its face, its poses.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::interpret::{Caught, Options, Reach, catch, make_feature, two_walls};
use hitl_slam::map::Observations;

use crate::support::Dice;

/// Poses along y = −2 (or +2) that see the wall from (0, 0) to (4, 0), 2 cm of noise; the other face lies 12 cm behind.
fn wall(random: &mut Dice, sides: &[f64], per_pose: usize) -> (Observations, Vec<Pose2>) {
    let mut observations = Observations::default();
    let mut poses = Vec::new();
    for &side in sides {
        let pose = Pose2::new(random.uniform(0.0, 4.0), -2.0 * side, random.uniform(-3.0, 3.0));
        let face = if side > 0.0 { 0.0 } else { 0.12 };
        for _ in 0..per_pose {
            let p = Vec2::new(random.uniform(-0.5, 4.5), face + random.normal(0.01));
            let normal = Vec2::new(0.0, -side);
            observations.push(pose.inverse().transform_point(p), pose.inverse_rotate(normal), 2.0);
        }
        observations.end_pose();
        poses.push(pose);
    }
    (observations, poses)
}

fn read(observations: &Observations, poses: &[Pose2], ends: [[f64; 2]; 2]) -> Result<Caught, String> {
    let ends = ends.map(|[x, y]| Vec2::new(x, y));
    catch(observations, poses, &Reach::new(observations), ends, &Options::default())
}

#[test]
fn a_stroke_drawn_5_cm_off_snaps_to_its_wall() {
    let mut random = Dice::new(31);
    let (observations, poses) = wall(&mut random, &[1.0; 10], 60);
    for _ in 0..100 {
        let off = [random.normal(0.05), random.normal(0.05)];
        let caught = read(&observations, &poses, [[1.0, off[0]], [3.0, off[1]]]).expect("a wall");
        let across = caught.fit.segment.ends().map(|end| end.y.abs());
        assert!(across.iter().all(|&y| y < 0.01), "{across:?}");
        assert!(caught.fit.settled && caught.poses.len() == 10);
    }
}

#[test]
fn of_a_walls_two_faces_the_better_supported_one_is_taken() {
    let mut random = Dice::new(32);
    let (observations, poses) = wall(&mut random, &[1.0, 1.0, 1.0, -1.0], 60);
    let caught = read(&observations, &poses, [[1.0, 0.05], [3.0, 0.05]]).expect("a wall");
    assert_eq!(caught.poses.iter().map(|p| p.0).collect::<Vec<_>>(), [0, 1, 2]);
    assert!(caught.fit.segment.centre.y.abs() < 0.01, "the face at y = 0: {:?}", caught.fit.segment);

    let (observations, poses) = wall(&mut random, &[1.0, -1.0, -1.0, -1.0], 60);
    let caught = read(&observations, &poses, [[1.0, 0.05], [3.0, 0.05]]).expect("a wall");
    assert_eq!(caught.poses.iter().map(|p| p.0).collect::<Vec<_>>(), [1, 2, 3]);
    assert!((caught.fit.segment.centre.y - 0.12).abs() < 0.01, "the face at 12 cm: {:?}", caught.fit.segment);
}

#[test]
fn a_pose_that_saw_too_little_is_left_out_and_an_empty_stroke_says_why() {
    let mut random = Dice::new(33);
    let (mut observations, mut poses) = wall(&mut random, &[1.0; 3], 300);
    // One pose with two points on the wall.
    poses.push(Pose2::IDENTITY);
    for x in [1.5, 2.5] {
        observations.push(Vec2::new(x, 0.0), Vec2::new(0.0, -1.0), 2.0);
    }
    observations.end_pose();
    let caught = read(&observations, &poses, [[1.0, 0.0], [3.0, 0.0]]).expect("a wall");
    assert_eq!(caught.poses.len(), 3);
    assert_eq!(caught.points.len(), caught.poses.iter().map(|p| p.1).sum::<usize>());

    let reason = read(&observations, &poses, [[1.0, 3.0], [3.0, 3.0]]).expect_err("nothing is there");
    assert!(reason.contains("no wall within"), "{reason}");
}

#[test]
fn what_a_stroke_catches_is_what_a_naive_search_finds() {
    // Twin of the search that skips poses out of reach: every point of every pose is looked at.
    let mut random = Dice::new(34);
    let (mut observations, mut poses) = wall(&mut random, &[1.0; 6], 80);
    for _ in 0..30 {
        poses.push(Pose2::new(
            random.uniform(-60.0, 60.0),
            random.uniform(-60.0, 60.0),
            random.uniform(-3.0, 3.0),
        ));
        for _ in 0..50 {
            let p = Vec2::new(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0));
            observations.push(p, Vec2::zeros(), p.norm());
        }
        observations.end_pose();
    }
    let caught = read(&observations, &poses, [[0.5, 0.03], [3.5, -0.02]]).expect("a wall");
    let segment = caught.fit.segment;
    let mut naive = Vec::new();
    for (pose, world_from_robot) in poses.iter().enumerate() {
        let on_wall: Vec<u32> = observations
            .range(pose)
            .filter(|&i| {
                let (along, across) =
                    segment.along_across(world_from_robot.transform_point(observations.point(i)));
                let normal = world_from_robot.rotate(observations.normal(i));
                along.abs() <= segment.half_length_m
                    && across.abs() <= 0.1
                    && (normal == Vec2::zeros() || normal.dot(&segment.normal()).abs() > 0.866)
            })
            .map(|i| i as u32)
            .collect();
        if on_wall.len() >= Reach::new(&observations).min_points() {
            naive.extend(on_wall);
        }
    }
    assert_eq!(caught.points, naive);
}

#[test]
fn of_two_visits_to_a_plain_wall_one_ties_the_segment_along_it_and_both_say_where_it_is_across() {
    let mut random = Dice::new(35);
    let (mut observations, mut poses) = wall(&mut random, &[1.0; 6], 60);
    // Somewhere else in between, then the wall again, seen better.
    for _ in 0..30 {
        observations.end_pose();
        poses.push(Pose2::new(50.0, 50.0, 0.0));
    }
    let (again, more_poses) = wall(&mut random, &[1.0; 8], 60);
    for (pose, &world_from_robot) in more_poses.iter().enumerate() {
        let seen = again.range(pose);
        seen.for_each(|k| observations.push(again.point(k), again.normal(k), 2.0));
        observations.end_pose();
        poses.push(world_from_robot);
    }
    let caught = read(&observations, &poses, [[1.0, 0.0], [3.0, 0.0]]).expect("a wall");
    assert_eq!(caught.poses.len(), 14);
    let tied = |own: std::ops::Range<usize>, anchor| -> Vec<usize> {
        let feature = make_feature(caught.fit.segment, &caught, own, anchor, &observations, &poses);
        assert_eq!(feature.sightings.len(), 14, "every pose says where the wall is across");
        feature.sightings.iter().filter(|s| s.tied).map(|s| s.pose).collect()
    };
    let (first, second): (Vec<usize>, Vec<usize>) = ((0..6).collect(), (36..44).collect());
    assert_eq!(tied(0..100, None), second, "the visit that saw most");
    assert_eq!(tied(0..100, Some(2)), first, "the visit on which the stroke was drawn");
    assert_eq!(tied(0..20, Some(40)), first, "only visits on the feature's own side");
    assert_eq!(tied(50..60, None), second, "all, where none is on its own side");
}

#[test]
fn two_walls_under_one_stroke_are_told_from_one_thick_one() {
    let dice = &mut Dice::new(11);
    for _ in 0..200 {
        let sigma = dice.uniform(0.005, 0.04);
        let one: Vec<f64> = (0..300).map(|_| dice.normal(sigma)).collect();
        assert_eq!(two_walls(&one), None, "one wall, σ {sigma}");
        let band: Vec<f64> = (0..300).map(|_| dice.uniform(-0.1, 0.1)).collect();
        assert_eq!(two_walls(&band), None, "a band");
        let (apart, share) = (dice.uniform(0.07, 0.15), dice.uniform(0.25, 0.75));
        let of_two = |k: usize| if (k as f64) < 300.0 * share { apart } else { 0.0 };
        let two: Vec<f64> = (0..300).map(|k| of_two(k) + dice.normal(apart / 8.0)).collect();
        let found = two_walls(&two).expect("two walls");
        assert!((found - apart).abs() < 0.01, "{found} for {apart}");
    }
    assert_eq!(two_walls(&[]), None);
    assert_eq!(two_walls(&[0.01]), None);
}
