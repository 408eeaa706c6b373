//! R2 for one point q: r = scale·n̂·(R q + t − c), 1×1, its distance to the line of a segment.
//! Blocks: pose (t, θ), segment (c, φ).

use nalgebra::Vector3;

use super::{Pair, frame, quarter_turn, single_row, turn};
use crate::geometry::Vec2;
use crate::joint::problem::PointTerm;

/// R2 for one point at a pose and a segment.
pub fn point(term: &PointTerm, pose: &[f64; 3], segment: &[f64; 3]) -> Pair {
    let (along, normal) = frame(segment[2]);
    let arm = turn(pose[2], term.point);
    let offset = arm + Vec2::new(pose[0] - segment[0], pose[1] - segment[1]);
    let (axis, k) = (normal * term.scale, term.scale);
    Pair {
        residual: Vector3::new(k * normal.dot(&offset), 0.0, 0.0),
        j_first: single_row([axis.x, axis.y, axis.dot(&quarter_turn(arm))]),
        j_second: single_row([-axis.x, -axis.y, -k * along.dot(&offset)]),
    }
}
