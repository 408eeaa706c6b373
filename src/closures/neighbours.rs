//! The chain compared with what its own neighbours saw: where the walls before a step and the points after it do not fit.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::candidates::Candidate;
use super::matching;
use super::place::Places;
use crate::geometry::angle_diff;
use crate::map::{AutomaticFactor, SlamMap};
use crate::scan_match::Search;

/// Steps are compared over so much path, metres …
const SPACING_M: f64 = 1.0;
/// … or so much turning, radians.
const SPACING_RAD: f64 = 0.5;
/// Half-width of the search where the neighbours do not fit as they stand: metres, radians.
const WINDOW: (f64, f64) = (0.8, 40.0 * PI / 180.0);
/// If so many of the points with any wall near fit as the map stands, nothing contradicts it and no search is made: a robot that drives
/// into the open would be found standing still.
const FITS: f64 = 0.8;

/// So many points that fit near the estimate make a search needless.
const ENOUGH: f64 = 0.8;
/// Where fewer points than this fit as the map stands, and not enough as matched, too little is seen from both ends: each edge
/// within is compared by itself.
const TOO_FEW: f64 = 0.5;

/// A piece of the chain, and how what was seen from its two ends fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Its first pose.
    pub i: usize,
    /// Its last pose.
    pub j: usize,
    /// Share of the last pose's points that fit the walls before the step as the map stands, 0 to 1.
    pub inliers: f64,
    /// The same among those that have any of these walls near: small where the two contradict each other.
    pub fitting: f64,
    /// Where pose j was found, seen from pose i; `None` if too few points fit anywhere near.
    pub matched: Option<AutomaticFactor>,
}

/// All steps of the chain, about a metre (or 30° of turning) each, in order; single edges where a metre is too much to compare.
pub fn compare_steps(map: &SlamMap) -> Vec<Step> {
    let path_m = map.path_lengths_m();
    let mut ends: Vec<usize> = Vec::new();
    for pose in (0..map.poses.len()).filter(|&p| !map.observations.range(p).is_empty()) {
        let is_far = ends.last().is_none_or(|&last| {
            path_m[pose] - path_m[last] >= SPACING_M
                || angle_diff(map.poses[pose].theta_rad, map.poses[last].theta_rad).abs() >= SPACING_RAD
        });
        if is_far {
            ends.push(pose);
        }
    }
    let places = Places { poses: &map.poses, observations: &map.observations, path_m: &path_m };
    let steps = ends.par_windows(2).flat_map_iter(|pair| {
        let (i, j) = (pair[0], pair[1]);
        let step = compare(map, &places, i, j);
        if step.inliers >= TOO_FEW || step.matched.is_some_and(|m| m.inliers >= ENOUGH) {
            return vec![step];
        }
        let seen: Vec<usize> = (i..=j).filter(|&p| !map.observations.range(p).is_empty()).collect();
        seen.windows(2).map(|edge| compare(map, &places, edge[0], edge[1])).collect()
    });
    steps.collect()
}

/// One step from pose i to a later pose j.
pub fn compare_step(map: &SlamMap, i: usize, j: usize) -> Step {
    let path_m = map.path_lengths_m();
    compare(map, &Places { poses: &map.poses, observations: &map.observations, path_m: &path_m }, i, j)
}

fn compare(map: &SlamMap, places: &Places, i: usize, j: usize) -> Step {
    let (local, query) = (places.map_before(i), places.query_alone(j));
    let estimate = map.poses[i].between(map.poses[j]);
    let (inliers, covered) = matching::standing(&local, &query, estimate);
    let fitting = if covered > 0.0 { inliers / covered } else { 1.0 };
    let near = matching::compare_near(&local, &query, estimate, (i, j)).accepted();
    if fitting >= FITS || near.is_some_and(|m| m.inliers >= ENOUGH) {
        return Step { i, j, inliers, fitting, matched: near };
    }
    let candidate = Candidate { i, j, position_m: WINDOW.0, heading_rad: WINDOW.1, reach_m: 0.0 };
    let found = matching::compare(&local, &Search::new(&local), &query, estimate, &candidate).accepted();
    let matched = [near, found].into_iter().flatten().max_by(|a, b| a.inliers.total_cmp(&b.inliers));
    Step { i, j, inliers, fitting, matched }
}
