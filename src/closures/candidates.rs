//! Which pairs of places to compare, and how far the truth may be from the estimate.
//!
//! The map is sampled at *stations*, a fixed path length apart. A station is compared with one station of every earlier
//! visit that comes near it. Near means: near enough to see the same walls, allowing for how badly the two are known
//! relative to each other (three standard deviations of their relative pose, from the joint covariance of the map).

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector2};
use rayon::prelude::*;

use super::SHORTEST_LOOP_M;
use crate::geometry::{Pose2, angle_diff};
use crate::scan_match::reach_m;
use crate::solver::Covariance;

/// Path from one station to the next, metres.
const STATION_SPACING_M: f64 = 2.0;
/// … or so much turning, radians.
const STATION_TURN_RAD: f64 = 1.0;
/// Poses within this reach of each other see the same walls, metres.
const OVERLAP_M: f64 = 2.3;
/// Of many earlier visits the nearest.
const MOST_VISITS: usize = 4;
/// Half-width of the search: at least, at most, metres. Beyond, a building looks like itself too often.
const POSITION_WINDOW_M: (f64, f64) = (1.2, 8.0);
/// … and radians.
const HEADING_WINDOW_RAD: (f64, f64) = (8.0 * PI / 180.0, 24.0 * PI / 180.0);

/// Two places to compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    /// Pose of the earlier visit.
    pub i: usize,
    /// Pose of the later visit.
    pub j: usize,
    /// Half-width of the search, metres.
    pub position_m: f64,
    /// Half-width of the search, radians.
    pub heading_rad: f64,
    /// Distance as the map stands, metres; a radian counts as half a metre.
    pub reach_m: f64,
}

/// Poses at even path lengths, of those that have points.
pub(super) fn stations(poses: &[Pose2], path_m: &[f64], has_points: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut stations: Vec<usize> = Vec::new();
    for pose in (0..poses.len()).filter(|&p| has_points(p)) {
        let is_far = stations.last().is_none_or(|&last| {
            path_m[pose] - path_m[last] >= STATION_SPACING_M
                || angle_diff(poses[pose].theta_rad, poses[last].theta_rad).abs() >= STATION_TURN_RAD
        });
        if is_far {
            stations.push(pose);
        }
    }
    stations
}

/// All pairs to compare, ascending by (j, i).
pub(super) fn find(
    poses: &[Pose2],
    path_m: &[f64],
    stations: &[usize],
    covariance: &Covariance,
) -> Vec<Candidate> {
    // Whatever the uncertainty, these can become candidates.
    let near: Vec<Vec<usize>> = stations
        .par_iter()
        .enumerate()
        .map(|(s, &j)| {
            let limit_m = OVERLAP_M + POSITION_WINDOW_M.1;
            let is_near =
                |&i: &usize| path_m[j] - path_m[i] > SHORTEST_LOOP_M && reach_m(poses[i], poses[j]) < limit_m;
            stations[..s].iter().copied().filter(is_near).collect()
        })
        .collect();
    // Σ_jj and Σ_ij of each: one column of the inverse a station.
    let columns: Vec<Vec<Matrix3<f64>>> = stations
        .par_iter()
        .zip(&near)
        .map(|(&j, near)| {
            let mut wanted = vec![j];
            wanted.extend(near);
            covariance.with(j, &wanted)
        })
        .collect();
    let station_of = |pose: usize| stations.partition_point(|&s| s < pose);
    let mut candidates = Vec::new();
    for (s, &j) in stations.iter().enumerate() {
        let open = near[s].iter().zip(&columns[s][1..]).filter_map(|(&i, sigma_ij)| {
            let sigma_ii = &columns[station_of(i)][0];
            let (position_m, heading_rad) = sigmas(poses[i], poses[j], sigma_ii, sigma_ij, &columns[s][0]);
            let position_m = (3.0 * position_m).clamp(POSITION_WINDOW_M.0, POSITION_WINDOW_M.1);
            let heading_rad = (3.0 * heading_rad).clamp(HEADING_WINDOW_RAD.0, HEADING_WINDOW_RAD.1);
            let reach_m = reach_m(poses[i], poses[j]);
            let candidate = Candidate { i, j, position_m, heading_rad, reach_m };
            (reach_m < OVERLAP_M + position_m).then_some((station_of(i), candidate))
        });
        candidates.extend(one_of_each_visit(open));
    }
    candidates
}

/// Of every run of consecutive stations the nearest; of those the nearest few, ascending.
fn one_of_each_visit(open: impl Iterator<Item = (usize, Candidate)>) -> Vec<Candidate> {
    let mut visits: Vec<Candidate> = Vec::new();
    let mut last = None;
    for (station, candidate) in open {
        match visits.last_mut().filter(|_| last == Some(station.wrapping_sub(1))) {
            Some(visit) if candidate.reach_m < visit.reach_m => *visit = candidate,
            Some(_) => {}
            None => visits.push(candidate),
        }
        last = Some(station);
    }
    visits.sort_by(|a, b| a.reach_m.total_cmp(&b.reach_m));
    visits.truncate(MOST_VISITS);
    visits.sort_by_key(|c| c.i);
    visits
}

/// σ of pose j seen from pose i: largest of the position (metres), heading (radians).
fn sigmas(
    world_from_i: Pose2,
    world_from_j: Pose2,
    sigma_ii: &Matrix3<f64>,
    sigma_ij: &Matrix3<f64>,
    sigma_jj: &Matrix3<f64>,
) -> (f64, f64) {
    // In world axes about pose i: d = t_j − t_i turned back by δθ_i.
    let d = world_from_j.translation() - world_from_i.translation();
    let of_i = Matrix3::new(-1.0, 0.0, d.y, 0.0, -1.0, -d.x, 0.0, 0.0, -1.0);
    let cross = of_i * sigma_ij;
    let relative = of_i * sigma_ii * of_i.transpose() + cross + cross.transpose() + sigma_jj;
    let position = relative.fixed_view::<2, 2>(0, 0);
    let half = Vector2::new((position[(0, 0)] - position[(1, 1)]) / 2.0, position[(0, 1)]).norm();
    let largest = (position[(0, 0)] + position[(1, 1)]) / 2.0 + half;
    (largest.max(0.0).sqrt(), relative[(2, 2)].max(0.0).sqrt())
}
