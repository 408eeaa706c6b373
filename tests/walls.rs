//! Table 1's metric: walls fitted to the map's own points against the true ones.

use hitl_slam::geometry::{Pose2, Segment, Vec2};
use hitl_slam::map::{Measure, SlamMap, Trajectory, Wall, WallPair};
use hitl_slam::metrics::wall_errors;

use crate::building::{drifted, true_map};

fn wall(name: &str, x0: f64, y0: f64, x1: f64, y1: f64) -> Wall {
    Wall { name: name.into(), segment: Segment::from_ends(Vec2::new(x0, y0), Vec2::new(x1, y1)) }
}

fn setting() -> (SlamMap, Trajectory, Vec<Wall>, Vec<WallPair>) {
    let map = true_map(300, 120);
    let truth = Trajectory { stamps_s: map.stamps_s.clone().unwrap(), poses: map.poses.clone() };
    let walls = vec![
        wall("south", 2.0, 2.0, 28.0, 2.0),
        wall("north", 28.0, 16.0, 2.0, 16.0),
        wall("east", 28.0, 2.0, 28.0, 16.0),
        wall("nowhere", 100.0, 0.0, 110.0, 0.0),
    ];
    let pairs = vec![
        WallPair::new("south", "north", Measure::Distance),
        WallPair::new("south", "north", Measure::Angle),
        WallPair::new("south", "east", Measure::Angle),
        WallPair::new("south", "nowhere", Measure::Angle),
    ];
    (map, truth, walls, pairs)
}

#[test]
fn the_true_map_has_the_true_walls_and_an_unseen_wall_is_counted_not_measured() {
    let (map, truth, walls, pairs) = setting();
    let errors = wall_errors(&map, &truth, &walls, &pairs, 0.01);
    assert_eq!((errors.angle_count, errors.distance_count, errors.unseen), (2, 1, 1));
    assert!(errors.angle_worst_deg.unwrap() < 0.1 && errors.distance_worst_m.unwrap() < 0.01, "{errors:?}");
    let truths: Vec<f64> = errors.samples.iter().map(|s| s.truth).collect();
    assert!((truths[0] - 14.0).abs() < 1e-9 && truths[1].abs() < 1e-9 && (truths[2] - 90.0).abs() < 1e-9);
}

#[test]
fn a_rigid_motion_of_the_map_changes_nothing_and_a_bend_shows() {
    let (map, truth, walls, pairs) = setting();
    let still = wall_errors(&map, &truth, &walls, &pairs, 0.01);
    let motion = Pose2::new(5.0, -3.0, 2.5);
    let mut moved = map.clone();
    moved.poses.iter_mut().for_each(|p| *p = motion.compose(*p));
    let moved = wall_errors(&moved, &truth, &walls, &pairs, 0.01);
    for (a, b) in still.samples.iter().zip(&moved.samples) {
        assert!((a.measured - b.measured).abs() < 1e-6, "{a:?} {b:?}");
    }
    let bent = wall_errors(&drifted(&map, 0.001), &truth, &walls, &pairs, 0.01);
    assert!(bent.angle_mean_deg.unwrap() > 1.0, "{bent:?}");
}
