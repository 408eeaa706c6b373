//! How good a pedestrian map and its paths are.

use std::collections::HashSet;

use super::transition_map::TransitionMap;
use super::walk::{TruthPoint, Walk};
use crate::geometry::{Pose2, Segment, Vec2};

/// Mean entropy of a step out of a hexagon, bits: Σ_h N_h H_h / Σ N_h with H_h = −Σ_e p_e log₂ p_e and
/// p_e = (N_h^e + α)/(N_h + 6α). At most log₂ 6 = 2.58; the clearer the map, the lower.
pub fn entropy_bits(map: &TransitionMap, alpha: f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (cell, total) in map.cells() {
        let entropy: f64 = map
            .counts_of(cell)
            .iter()
            .map(|n| (n + alpha) / (total + 6.0 * alpha))
            .map(|p| -p * p.log2())
            .sum();
        sum += total * entropy;
        weights += total;
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// Share of the crossings whose way from cell centre to cell centre goes through a wall.
pub fn crossed_wall_ratio(map: &TransitionMap, walls: &[Segment]) -> f64 {
    let (mut crossed, mut all) = (0.0, 0.0);
    for (cell, edge, count) in map.edges() {
        let (from, to) = (map.grid.centre(cell), map.grid.centre(cell.across(edge)));
        if walls.iter().any(|wall| intersects(from, to, wall)) {
            crossed += count;
        }
        all += count;
    }
    if all > 0.0 { crossed / all } else { 0.0 }
}

/// How well a map covers the ways that people really took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// Share of the map's mass within `tolerance_m` of a true way.
    pub precision: f64,
    /// Share of the hexagons on true ways that hold at least `enough` crossings.
    pub recall: f64,
}

/// Of a map's crossings so near to a true way, metres, [`coverage`] says that they are on it.
pub const NEAR_A_WAY_M: f64 = 1.0;
/// So many crossings make a hexagon a way.
pub const A_WAY: f64 = 0.5;
/// A walk that is not this straight between two true positions took a way that they do not tell.
const STRAIGHT: f64 = 1.05;

/// The ways of a walker that its true positions tell: lines between two of them where the walk between was straight.
pub fn true_ways(walk: &Walk, truth: &[TruthPoint]) -> Vec<Vec<Vec2>> {
    let lengths = walk.lengths_m();
    let walked_m = |stamp_s: f64| {
        let (step, share) = walk.place_at(stamp_s);
        let before = step.checked_sub(1).and_then(|k| lengths.get(k)).copied().unwrap_or(0.0);
        before + share * (lengths.get(step).copied().unwrap_or(before) - before)
    };
    let own: Vec<&TruthPoint> = truth.iter().filter(|t| t.walker == walk.name).collect();
    let straight = |pair: &&[&TruthPoint]| {
        let distance_m = (pair[1].position - pair[0].position).norm();
        distance_m > 0.1
            && walked_m(pair[1].stamp_s) - walked_m(pair[0].stamp_s) < STRAIGHT * distance_m + 0.1
    };
    own.windows(2).filter(straight).map(|pair| vec![pair[0].position, pair[1].position]).collect()
}

/// Compares a map with true ways: polylines, world frame.
pub fn coverage(map: &TransitionMap, ways: &[Vec<Vec2>], tolerance_m: f64, enough: f64) -> Coverage {
    let mut near = HashSet::new();
    let mut on = HashSet::new();
    let rings = (tolerance_m / (1.5 * map.grid.radius_m)).ceil() as i16 + 1;
    for pair in ways.iter().flat_map(|way| way.windows(2)) {
        let samples = ((pair[1] - pair[0]).norm() / (0.5 * map.grid.radius_m)).ceil().max(1.0) as usize;
        for k in 0..=samples {
            let p = pair[0] + (pair[1] - pair[0]) * (k as f64 / samples as f64);
            let centre = map.grid.cell_at(p);
            if !on.insert(centre) && samples > 1 && k % 2 == 1 {
                continue;
            }
            for (dq, dr) in (-rings..=rings).flat_map(|dq| (-rings..=rings).map(move |dr| (dq, dr))) {
                let mut cell = centre;
                (cell.q, cell.r) = (cell.q.wrapping_add(dq), cell.r.wrapping_add(dr));
                if (map.grid.centre(cell) - p).norm() <= tolerance_m {
                    near.insert(cell);
                }
            }
        }
    }
    let (mut inside, mut all) = (0.0, 0.0);
    for (cell, total) in map.cells() {
        all += total;
        if near.contains(&cell) {
            inside += total;
        }
    }
    let found = on.iter().filter(|&&c| map.counts_of(c).iter().sum::<f64>() >= enough).count();
    Coverage {
        precision: if all > 0.0 { inside / all } else { 0.0 },
        recall: found as f64 / on.len().max(1) as f64,
    }
}

/// Distance of a path from a walker's true positions, one per truth point of that walker, in time order.
pub fn errors_m(walk: &Walk, path: &[Vec2], truth: &[TruthPoint]) -> Vec<f64> {
    let own = truth.iter().filter(|t| t.walker == walk.name);
    own.filter_map(|t| Some((walk.position_at(path, t.stamp_s)? - t.position).norm())).collect()
}

fn intersects(a: Vec2, b: Vec2, wall: &Segment) -> bool {
    let [p, q] = wall.ends();
    let side = |a: Vec2, b: Vec2, c: Vec2| (b - a).perp(&(c - a));
    side(a, b, p) * side(a, b, q) < 0.0 && side(p, q, a) * side(p, q, b) < 0.0
}

/// Rigid motion that lays points onto others best (least squares), both in one order.
pub fn rigid_fit(from: &[Vec2], to: &[Vec2]) -> Pose2 {
    let middle = |v: &[Vec2]| v.iter().sum::<Vec2>() / v.len() as f64;
    let (a, b) = (middle(from), middle(to));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (p, q) in from.iter().zip(to) {
        dot += (p - a).dot(&(q - b));
        cross += (p - a).perp(&(q - b));
    }
    let turn = Pose2::new(0.0, 0.0, cross.atan2(dot));
    let t = b - turn.rotate(a);
    Pose2::new(t.x, t.y, turn.theta_rad)
}
