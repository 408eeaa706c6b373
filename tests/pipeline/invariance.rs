//! The result is the same however the map is turned and however the strokes are drawn: to 1 mm.

use std::f64::consts::{PI, TAU};

use hitl_slam::geometry::{Pose2, angle_diff};
use hitl_slam::map::{Correction, SlamMap, Stroke};
use hitl_slam::simulate::{Scenario, Simulation};

use super::{corrected, simulated};
use crate::support::largest_distance_m;

const SAME_M: f64 = 1e-3;

fn turned(map: &SlamMap, by: Pose2) -> SlamMap {
    let mut map = map.clone();
    for pose in &mut map.poses {
        *pose = by.compose(*pose);
    }
    map
}

/// The same strokes in the world frame of the turned map, or still on their poses.
fn turned_strokes(s: &Simulation, by: Pose2, in_world: bool) -> Vec<Correction> {
    let turn = |stroke: Stroke| match stroke {
        Stroke::Pose { pose, points } if in_world => {
            Stroke::World(points.map(|p| by.compose(s.map.poses[pose]).transform_point(p)))
        }
        other => other,
    };
    s.corrections.iter().map(|c| Correction { a: turn(c.a), b: turn(c.b), ..c.clone() }).collect()
}

#[test]
fn the_result_is_the_same_under_24_rotations_of_the_input() {
    for seed in [1, 2] {
        let s = simulated(Scenario::Loop, seed, 0.03);
        let (upright, _) = corrected(&s.map, &s.corrections);
        for k in 0..24 {
            let by = Pose2::new(12.0, -7.0, TAU * f64::from(k) / 24.0);
            let (map, reports) = corrected(&turned(&s.map, by), &turned_strokes(&s, by, false));
            assert!(reports.iter().all(|r| r.accepted()), "{k}");
            let back: Vec<Pose2> = map.poses.iter().map(|p| by.inverse().compose(*p)).collect();
            assert!(largest_distance_m(&back, &upright.poses) < SAME_M, "seed {seed}, rotation {k}");
            let turn =
                back.iter().zip(&upright.poses).map(|(p, q)| angle_diff(p.theta_rad, q.theta_rad).abs());
            assert!(turn.fold(0.0, f64::max) < 1e-3, "seed {seed}, rotation {k}");
        }
    }
}

#[test]
fn strokes_in_the_world_frame_turn_with_the_map() {
    let s = simulated(Scenario::Loop, 3, 0.02);
    let one = |by: Pose2| {
        let corrections = turned_strokes(&s, by, true);
        corrected(&turned(&s.map, by), &corrections[..1]).0.poses
    };
    let upright = one(Pose2::IDENTITY);
    let by = Pose2::new(0.0, 0.0, 2.0);
    let back: Vec<Pose2> = one(by).iter().map(|p| by.inverse().compose(*p)).collect();
    assert!(largest_distance_m(&back, &upright) < SAME_M);
}

#[test]
fn neither_the_direction_nor_the_order_of_the_strokes_matters() {
    let reversed = |stroke: Stroke| match stroke {
        Stroke::Pose { pose, points: [p, q] } => Stroke::Pose { pose, points: [q, p] },
        other => other,
    };
    for (scenario, seed) in [(Scenario::Loop, 4), (Scenario::Campus, 2)] {
        let s = simulated(scenario, seed, 0.03);
        let (expected, _) = corrected(&s.map, &s.corrections);
        for variant in 1..8 {
            let change = |c: &Correction| {
                let a = if variant & 1 > 0 { reversed(c.a) } else { c.a };
                let b = if variant & 2 > 0 { reversed(c.b) } else { c.b };
                let (a, b) = if variant & 4 > 0 { (b, a) } else { (a, b) };
                Correction { a, b, ..c.clone() }
            };
            let corrections: Vec<Correction> = s.corrections.iter().map(change).collect();
            let (map, _) = corrected(&s.map, &corrections);
            let moved_m = largest_distance_m(&map.poses, &expected.poses);
            assert!(moved_m < SAME_M, "{scenario:?} variant {variant}: {moved_m} m");
        }
    }
}

#[test]
fn a_robot_that_drives_along_minus_x_is_no_different() {
    // Headings near ±π: the released implementation does not wrap its angle residuals (ATE 0.10 → 3.1 m).
    let s = simulated(Scenario::Loop, 5, 0.02);
    let (upright, _) = corrected(&s.map, &s.corrections);
    for heading in [PI, PI - 1e-9, -PI + 1e-9, PI - 1e-3] {
        let by = Pose2::new(0.0, 0.0, heading - s.map.poses[0].theta_rad);
        let (map, _) = corrected(&turned(&s.map, by), &s.corrections);
        let back: Vec<Pose2> = map.poses.iter().map(|p| by.inverse().compose(*p)).collect();
        assert!(largest_distance_m(&back, &upright.poses) < SAME_M, "{heading}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let s = simulated(Scenario::Loop, 6, 0.02);
    let bits =
        |map: SlamMap| map.poses.iter().flat_map(|p| p.to_array()).map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(corrected(&s.map, &s.corrections).0), bits(corrected(&s.map, &s.corrections).0));
}
