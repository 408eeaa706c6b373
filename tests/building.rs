//! A made-up building and a robot's run through it: maps of any size with known truth, by hand and without a seed.

use hitl_slam::geometry::{Information, Pose2, Segment, Vec2};
use hitl_slam::map::{Feature, HumanFactor, Mode, Observations, RelativeFactor, Sighting, SlamMap};

/// A ring corridor, 2 m wide, around a core of 26 m × 14 m, with rooms outside along both long sides.
fn walls() -> Vec<[Vec2; 2]> {
    let mut walls = Vec::new();
    let mut wall = |x0: f64, y0: f64, x1: f64, y1: f64| walls.push([Vec2::new(x0, y0), Vec2::new(x1, y1)]);
    wall(2.0, 2.0, 28.0, 2.0);
    wall(28.0, 2.0, 28.0, 16.0);
    wall(28.0, 16.0, 2.0, 16.0);
    wall(2.0, 16.0, 2.0, 2.0);
    for (inner, outer) in [(0.0, -4.5), (18.0, 22.5)] {
        wall(0.0, outer, 30.0, outer);
        for room in 0..5 {
            let x = f64::from(room) * 6.0;
            wall(x, inner, x, outer);
            wall(x, inner, x + 2.4, inner);
            wall(x + 3.6, inner, x + 6.0, inner); // a door of 1.2 m between the two
        }
        wall(30.0, inner, 30.0, outer);
    }
    wall(0.0, 0.0, 0.0, 18.0);
    wall(30.0, 0.0, 30.0, 18.0);
    walls
}

/// A number in −1..1 that looks random and depends on `k` only.
fn noise(k: usize) -> f64 {
    let h = (k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let h = (h ^ (h >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((h ^ (h >> 32)) & 0xFFFF_FFFF) as f64 / 2_147_483_648.0 - 1.0
}

/// The robot's true poses: once around the ring and a third of the way again.
fn driven(poses: usize) -> Vec<Pose2> {
    let corners = [(1.0, 1.0), (29.0, 1.0), (29.0, 17.0), (1.0, 17.0)];
    let lengths = [28.0, 16.0, 28.0, 16.0];
    let total: f64 = lengths.iter().sum();
    let pose = |k: usize| {
        let mut s = k as f64 / poses as f64 * total * 1.33 % total;
        let mut side = 0;
        while side < 3 && s > lengths[side] {
            s -= lengths[side];
            side += 1;
        }
        let theta = side as f64 * std::f64::consts::FRAC_PI_2;
        let (x, y) = corners[side];
        Pose2::new(x + s * theta.cos(), y + s * theta.sin(), theta + 0.05 * noise(k))
    };
    (0..poses).map(pose).collect()
}

fn range(walls: &[[Vec2; 2]], from: Vec2, bearing_rad: f64) -> Option<f64> {
    let ray = Vec2::new(bearing_rad.cos(), bearing_rad.sin());
    let hit = |[a, b]: &[Vec2; 2]| {
        let (d, to_a) = (b - a, a - from);
        let cross = ray.perp(&d);
        let (t, u) = (to_a.perp(&d) / cross, to_a.perp(&ray) / cross);
        (t > 0.0 && (0.0..=1.0).contains(&u)).then_some(t)
    };
    walls.iter().filter_map(hit).min_by(f64::total_cmp).filter(|&r| r < 12.0)
}

/// The map with its poses as they truly were.
pub fn true_map(poses: usize, beams: usize) -> SlamMap {
    let walls = walls();
    let poses = driven(poses);
    let mut observations = Observations::empty(0);
    for (i, pose) in poses.iter().enumerate() {
        for beam in 0..beams {
            let bearing = (beam as f64 / (beams as f64 - 1.0) - 0.5) * 4.2;
            let Some(range) = range(&walls, pose.translation(), pose.theta_rad + bearing) else { continue };
            let range = range + 0.012 * (noise(i * beams + beam) + noise(i * beams + beam + 7_777_777));
            let point = Vec2::new(bearing.cos(), bearing.sin()) * range;
            observations.push(point, Vec2::zeros(), range);
        }
        observations.end_pose();
    }
    let edge = |i: usize| RelativeFactor {
        i,
        j: i + 1,
        i_from_j: poses[i].between(poses[i + 1]),
        information: Information::from_sigmas(0.05, 0.05, 0.01),
    };
    let stamps_s = Some((0..poses.len()).map(|i| 0.5 * i as f64).collect());
    let relative_factors = (0..poses.len() - 1).map(edge).collect();
    SlamMap { poses, stamps_s, relative_factors, observations, ..SlamMap::default() }
}

/// The same map with a heading that drifts by `drift_rad` a pose.
pub fn drifted(map: &SlamMap, drift_rad: f64) -> SlamMap {
    let mut poses = vec![map.poses[0]];
    for i in 1..map.poses.len() {
        let step = map.poses[i - 1].between(map.poses[i]).compose(Pose2::new(0.0, 0.0, drift_rad));
        poses.push(poses[i - 1].compose(step));
    }
    SlamMap { poses, ..map.clone() }
}

/// Adds a human factor between what two groups of poses saw near a segment of the (true) map.
pub fn add_factor(map: &mut SlamMap, id: &str, wall: [Vec2; 2], a: [usize; 2], b: [usize; 2]) {
    let segment = Segment::from_ends(wall[0], wall[1]);
    let feature = |[from, to]: [usize; 2]| {
        let (mut points, mut sightings) = (Vec::new(), Vec::new());
        for pose in from..to {
            let near = map.observations.range(pose).filter(|&p| {
                let at = map.poses[pose].transform_point(map.observations.point(p));
                let (along, across) = segment.along_across(at);
                along.abs() < segment.half_length_m && across.abs() < 0.05
            });
            let near: Vec<u32> = near.map(|p| p as u32).collect();
            if !near.is_empty() {
                let bearing_rad = segment.direction_rad - map.poses[pose].theta_rad;
                sightings.push(Sighting { tied: true, pose, along_m: 0.0, bearing_rad });
                points.extend(near);
            }
        }
        Feature { segment, points, sightings }
    };
    let (a, b) = (feature(a), feature(b));
    map.human_factors.push(HumanFactor { id: id.into(), mode: Mode::Collinear, weight: 1.0, a, b });
}

/// A bent map and its repaired twin with two human factors.
pub fn before_and_after(poses: usize, beams: usize) -> (SlamMap, SlamMap) {
    let mut after = true_map(poses, beams);
    let before = drifted(&after, 0.22 / poses as f64);
    let at = |share: f64| (share * poses as f64) as usize;
    let along = |x0: f64, x1: f64, y: f64| [Vec2::new(x0, y), Vec2::new(x1, y)];
    add_factor(&mut after, "c1", along(10.0, 16.0, 2.0), [at(0.05), at(0.15)], [at(0.80), at(0.90)]);
    add_factor(&mut after, "c2", along(18.0, 22.0, 2.0), [at(0.14), at(0.2)], [at(0.9), at(0.97)]);
    (before, after)
}
