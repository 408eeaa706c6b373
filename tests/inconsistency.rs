//! The fast inconsistency against the definition as a naive double loop over pairs of poses.

use std::collections::BTreeSet;

use hitl_slam::geometry::Vec2;
use hitl_slam::map::SlamMap;
use hitl_slam::metrics::{InconsistencyOptions, inconsistency};

use crate::building::{drifted, true_map};

type Cells = BTreeSet<(i64, i64)>;

/// The part of a ray, as shares of it, that lies in a cell's square; None: none.
fn inside(from: Vec2, to: Vec2, low: Vec2) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let d = to[axis] - from[axis];
        let (a, b) = ((low[axis] - from[axis]) / d, (low[axis] + 1.0 - from[axis]) / d);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    (enter < leave).then_some((enter, leave))
}

/// Free and occupied cells of a pose, straight from the definition.
fn seen(map: &SlamMap, pose: usize, origin: Vec2, options: &InconsistencyOptions) -> (Cells, Cells) {
    let place = |p: Vec2| (p - origin) / options.resolution_m;
    let margin = options.free_margin_m / options.resolution_m;
    let from = place(map.poses[pose].transform_point(map.robot_from_laser.translation()));
    let ends: Vec<Vec2> = map
        .observations
        .range(pose)
        .map(|k| place(map.poses[pose].transform_point(map.observations.point(k))))
        .collect();
    let cell = |p: Vec2| (p.x.floor() as i64, p.y.floor() as i64);
    let occupied: Cells = ends.iter().map(|&p| cell(p)).collect();
    let mut free = Cells::new();
    for &end in &ends {
        let length = (end - from).norm();
        if length <= margin {
            continue;
        }
        let stop = from + (end - from) * ((length - margin) / length);
        let (low, high) = (cell(from.inf(&stop)), cell(from.sup(&stop)));
        for x in low.0..=high.0 {
            for y in low.1..=high.1 {
                let is_passed = inside(from, stop, Vec2::new(x as f64, y as f64)).is_some();
                let is_far =
                    |&(a, b): &(i64, i64)| ((a - x).pow(2) + (b - y).pow(2)) as f64 >= margin * margin;
                if is_passed
                    && !free.contains(&(x, y))
                    && !occupied.contains(&(x, y))
                    && occupied.iter().all(is_far)
                {
                    free.insert((x, y));
                }
            }
        }
    }
    (free, occupied)
}

fn naive(map: &SlamMap, options: &InconsistencyOptions) -> u64 {
    let mut origin = Vec2::repeat(f64::INFINITY);
    for (i, pose) in map.poses.iter().enumerate() {
        origin = origin.inf(&pose.transform_point(map.robot_from_laser.translation()));
        for k in map.observations.range(i) {
            origin = origin.inf(&pose.transform_point(map.observations.point(k)));
        }
    }
    let all: Vec<(Cells, Cells)> = (0..map.poses.len()).map(|i| seen(map, i, origin, options)).collect();
    let mut sum = 0;
    for i in 0..all.len() {
        for j in i + 1..all.len() {
            sum += all[i].0.intersection(&all[j].1).count() as u64;
        }
    }
    sum
}

#[test]
fn one_pass_over_the_rays_equals_the_double_loop_over_pairs() {
    let map = drifted(&true_map(40, 24), 0.012);
    for (resolution_m, free_margin_m) in [(0.25, 0.5), (0.2, 0.3), (0.4, 0.0)] {
        let options = InconsistencyOptions { resolution_m, free_margin_m };
        let fast = inconsistency(&map, &options).unwrap();
        assert!(fast.pairs > 0);
        assert_eq!(fast.pairs, naive(&map, &options), "{options:?}");
        assert!((fast.area_m2 - fast.pairs as f64 * resolution_m * resolution_m).abs() < 1e-9);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_inconsistency() {
    let map = drifted(&true_map(200, 60), 0.002);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| inconsistency(&map, &InconsistencyOptions::default()).unwrap())
    };
    let one = with(1);
    assert!(one.pairs > 0);
    for threads in [2, 3, 7] {
        assert_eq!(with(threads), one, "{threads} threads");
    }
}

#[test]
fn a_bent_map_is_more_inconsistent_than_the_true_one() {
    let truth = true_map(300, 120);
    let area = |map: &SlamMap| inconsistency(map, &InconsistencyOptions::default()).unwrap().area_m2;
    assert!(area(&drifted(&truth, 0.0015)) > 2.0 * area(&truth));
}

#[test]
fn a_map_without_points_has_none_and_a_senseless_option_is_refused() {
    let mut map = true_map(5, 12);
    let mut options = InconsistencyOptions { resolution_m: f64::NAN, free_margin_m: 0.3 };
    assert!(inconsistency(&map, &options).is_err());
    options.resolution_m = 1e-7;
    assert!(inconsistency(&map, &options).is_err(), "more cells than any memory has");
    map.observations = hitl_slam::map::Observations::empty(5);
    assert_eq!(inconsistency(&map, &InconsistencyOptions::default()).unwrap().pairs, 0);
}
