//! R5, the paper's R_a (and R_b): r = scale·√(m + ε²), 1×1, m = Σ_{s∈S} δ(s, P)/|S|, δ the squared distance to the
//! segment, its ends included. Blocks: every pose of X, then both ends of P.
//!
//! With p = e₀ + τ(e₁ − e₀) the point of P nearest to q (τ clamped to 0..=1) and g = 2(q − p): ∂δ = g·∂q − (1 − τ)
//! g·∂e₀ − τ g·∂e₁, also where τ is clamped.

use nalgebra::Vector3;

use super::{PAPER_EPSILON_M, quarter_turn, single_row, turn};
use crate::geometry::Vec2;
use crate::joint::problem::FitTerm;
use crate::solver::{Block, Linearization};

/// R5 alone. `poses[i]` is pose i; the ends are blocks.
pub fn paper_fit_residual(term: &FitTerm, poses: &[Block], ends: [&Block; 2]) -> Vector3<f64> {
    let [start, end] = ends.map(|e| Vec2::new(e[0], e[1]));
    let mut sum = 0.0;
    for sighting in &term.sightings {
        let [x, y, theta] = poses[sighting.pose];
        for &q in &sighting.points {
            let q = turn(theta, q) + Vec2::new(x, y);
            sum += (q - start - (end - start) * share(q, start, end)).norm_squared();
        }
    }
    Vector3::new(term.scale * guarded_root(sum / count(term)), 0.0, 0.0)
}

/// R5 with its Jacobians. `x` holds every block, pose i first at i; `end_blocks` are the ends' indices.
pub fn paper_fit(term: &FitTerm, x: &[Block], end_blocks: [usize; 2], at: &mut Linearization) {
    let [start, end] = end_blocks.map(|e| Vec2::new(x[e][0], x[e][1]));
    let mut sum = 0.0;
    let mut by_ends = [Vec2::zeros(); 2];
    for sighting in &term.sightings {
        let [px, py, theta] = x[sighting.pose];
        let mut by_pose = [0.0; 3];
        for &q in &sighting.points {
            let arm = turn(theta, q);
            let q = arm + Vec2::new(px, py);
            let tau = share(q, start, end);
            let gap = q - start - (end - start) * tau;
            sum += gap.norm_squared();
            let g = gap * 2.0;
            by_pose[0] += g.x;
            by_pose[1] += g.y;
            by_pose[2] += g.dot(&quarter_turn(arm));
            by_ends[0] -= g * (1.0 - tau);
            by_ends[1] -= g * tau;
        }
        at.jacobians.push((sighting.pose, single_row(by_pose)));
    }
    let root = guarded_root(sum / count(term));
    at.residual[0] = term.scale * root;
    at.jacobians.extend([0, 1].map(|k| (end_blocks[k], single_row([by_ends[k].x, by_ends[k].y, 0.0]))));
    let slope = term.scale / (2.0 * root * count(term));
    for (_, j) in &mut at.jacobians {
        *j *= slope;
    }
}

/// τ: where on the segment the nearest point lies, 0 at its start and 1 at its end.
fn share(q: Vec2, start: Vec2, end: Vec2) -> f64 {
    let w = end - start;
    let length_squared = w.norm_squared();
    if length_squared > 0.0 { ((q - start).dot(&w) / length_squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// √(m + ε²).
fn guarded_root(mean: f64) -> f64 {
    (mean + PAPER_EPSILON_M * PAPER_EPSILON_M).sqrt()
}

fn count(term: &FitTerm) -> f64 {
    term.sightings.iter().map(|s| s.points.len()).sum::<usize>() as f64
}
