//! Table 1 of Nashed & Biswas 2018: angles and distances between named walls of the map against the true ones.
//!
//! A return belongs to a wall if, seen from its **true** pose, it lies on it ([`ON_WALL_M`], ends excluded). The wall of
//! the map is the total-least-squares line through those same returns as the map's poses place them, all visits
//! together. So nobody picks what to measure, and a doubled wall counts as the doubled wall that it is.

use serde::Serialize;

use super::associate;
use crate::geometry::{Scatter, Segment, Vec2, principal_direction, wrap_angle};
use crate::map::{Measure, SlamMap, Trajectory, Wall, WallPair};

/// A return this close to a true wall is of that wall, metres: four times a good laser's noise.
pub const ON_WALL_M: f64 = 0.04;
/// Returns this close to a wall's end may be of the next one and are left out, metres.
const END_M: f64 = 0.08;
/// A wall with fewer returns is taken for unseen.
const FEWEST_RETURNS: usize = 20;

/// One comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WallSample {
    /// Name of one wall.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// What is compared.
    pub measure: Measure,
    /// In truth: degrees 0..=90, or metres.
    pub truth: f64,
    /// On the map.
    pub measured: f64,
    /// |measured − truth|.
    pub error: f64,
}

/// All comparisons. Without any of a kind: zero count and no numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WallErrors {
    /// Pairs whose angle was compared.
    pub angle_count: usize,
    /// Mean error of the angle, degrees.
    pub angle_mean_deg: Option<f64>,
    /// The largest, degrees.
    pub angle_worst_deg: Option<f64>,
    /// Pairs whose distance was compared.
    pub distance_count: usize,
    /// Mean error of the distance, metres.
    pub distance_mean_m: Option<f64>,
    /// The largest, metres.
    pub distance_worst_m: Option<f64>,
    /// Pairs left out because the laser never saw one of the walls.
    pub unseen: usize,
    /// Every comparison, in the order of the pairs.
    pub samples: Vec<WallSample>,
}

/// Compares the walls of a map with the true ones. `truth` is matched to the map's poses by stamp within
/// `tolerance_s`; a pair that names a wall which is not among `walls` counts as unseen.
pub fn wall_errors(
    map: &SlamMap,
    truth: &Trajectory,
    walls: &[Wall],
    pairs: &[WallPair],
    tolerance_s: f64,
) -> WallErrors {
    let stamps_s = match &map.stamps_s {
        Some(stamps) => stamps.clone(),
        None => (0..map.poses.len()).map(|i| i as f64).collect(),
    };
    let own = Trajectory { stamps_s, poses: map.poses.clone() };
    let matched = associate(&own, truth, tolerance_s);
    let named: Vec<(&Wall, Option<Segment>)> = walls
        .iter()
        .filter(|w| pairs.iter().any(|p| p.a == w.name || p.b == w.name))
        .map(|w| (w, fitted(map, truth, &matched, &w.segment)))
        .collect();
    let find = |name: &str| named.iter().find(|(w, _)| w.name == name);
    let sample = |pair: &WallPair| {
        let ((a, on_map_a), (b, on_map_b)) = (find(&pair.a)?, find(&pair.b)?);
        let truth = measure(pair.measure, &a.segment, &b.segment);
        let measured = measure(pair.measure, on_map_a.as_ref()?, on_map_b.as_ref()?);
        let error = (measured - truth).abs();
        Some(WallSample {
            a: pair.a.clone(),
            b: pair.b.clone(),
            measure: pair.measure,
            truth,
            measured,
            error,
        })
    };
    let samples: Vec<WallSample> = pairs.iter().filter_map(sample).collect();
    let errors =
        |wanted| -> Vec<f64> { samples.iter().filter(|s| s.measure == wanted).map(|s| s.error).collect() };
    let mean = |v: &[f64]| (!v.is_empty()).then(|| v.iter().sum::<f64>() / v.len() as f64);
    let worst = |v: &[f64]| v.iter().copied().max_by(f64::total_cmp);
    let [angles, distances] = Measure::ALL.map(errors);
    WallErrors {
        angle_count: angles.len(),
        angle_mean_deg: mean(&angles),
        angle_worst_deg: worst(&angles),
        distance_count: distances.len(),
        distance_mean_m: mean(&distances),
        distance_worst_m: worst(&distances),
        unseen: pairs.len() - samples.len(),
        samples,
    }
}

/// The line through a true wall's returns as the map places them; `None` if there are too few.
fn fitted(map: &SlamMap, truth: &Trajectory, matched: &[(usize, usize)], wall: &Segment) -> Option<Segment> {
    let mut points: Vec<Vec2> = Vec::new();
    for &(pose, true_pose) in matched {
        let (placed, world_from_robot) = (map.poses[pose], truth.poses[true_pose]);
        for k in map.observations.range(pose) {
            let p = map.observations.point(k);
            let (along, across) = wall.along_across(world_from_robot.transform_point(p));
            if across.abs() <= ON_WALL_M && along.abs() <= wall.half_length_m - END_M {
                points.push(placed.transform_point(p));
            }
        }
    }
    if points.len() < FEWEST_RETURNS {
        return None;
    }
    let scatter = Scatter::of(points.iter().copied());
    let direction_rad = principal_direction(scatter.second_moments());
    Some(Segment { centre: scatter.mean, direction_rad, half_length_m: wall.half_length_m })
}

/// The angle between two lines in degrees, 0..=90; or the distance across, the mean of either centre from the other
/// line, in metres.
fn measure(measure: Measure, a: &Segment, b: &Segment) -> f64 {
    match measure {
        Measure::Angle => (wrap_angle(2.0 * (a.direction_rad - b.direction_rad)) / 2.0).abs().to_degrees(),
        Measure::Distance => (a.along_across(b.centre).1.abs() + b.along_across(a.centre).1.abs()) / 2.0,
    }
}
