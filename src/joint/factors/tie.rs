//! R3: r = scale·(û·(R m + t − c) − τ), 1×1: where the pose's points sit along the segment (û at φ, m their mean,
//! τ the coordinate when the correction was made). Without it a segment slides along its wall at no cost.
//! Blocks: pose (t, θ), segment (c, φ).

use nalgebra::{Matrix3, Vector3};

use super::{Pair, frame, quarter_turn, turn};
use crate::geometry::Vec2;
use crate::joint::problem::TieTerm;

/// R3 at a pose and a segment.
pub fn tie(term: &TieTerm, pose: &[f64; 3], segment: &[f64; 3]) -> Pair {
    let (along, normal) = frame(segment[2]);
    let arm = turn(pose[2], term.mean);
    let offset = arm + Vec2::new(pose[0] - segment[0], pose[1] - segment[1]);
    let mut j_first = Matrix3::zeros();
    let mut j_second = Matrix3::zeros();
    let turned = along.dot(&quarter_turn(arm));
    for (k, (first, second)) in
        [(along.x, -along.x), (along.y, -along.y), (turned, normal.dot(&offset))].into_iter().enumerate()
    {
        j_first[(0, k)] = term.scale * first;
        j_second[(0, k)] = term.scale * second;
    }
    let residual = Vector3::new(term.scale * (along.dot(&offset) - term.along), 0.0, 0.0);
    Pair { residual, j_first, j_second }
}
