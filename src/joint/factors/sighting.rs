//! R2: the points q of one pose against the line (c, n̂) of a segment. With m their mean, n their number and
//! WᵀW = Σ (q − m)(q − m)ᵀ (W upper triangular):
//!
//! r = scale·[ W·Rᵀn̂ ; √n·n̂·(R m + t − c) ], 3×1, and ‖r‖² = scale²·Σ (n̂·(R q + t − c))² exactly.
//! Blocks: pose (t, θ), segment (c, φ).

use nalgebra::{Matrix3, Vector3};

use super::{Pair, frame, quarter_turn};
use crate::geometry::Vec2;
use crate::joint::problem::SightingTerm;

/// R2 at a pose and a segment.
pub fn sighting(term: &SightingTerm, pose: &[f64; 3], segment: &[f64; 3]) -> Pair {
    let [w11, w12, w22] = term.scatter_root.map(|w| w * term.scale);
    let root = term.count.sqrt() * term.scale;
    let (along, normal) = frame(segment[2]);
    let (ahead, left) = frame(pose[2]);
    let in_robot = |v: Vec2| Vec2::new(ahead.dot(&v), left.dot(&v));
    let (along_in_robot, normal_in_robot) = (in_robot(along), in_robot(normal));
    let arm = ahead * term.mean[0] + left * term.mean[1];
    let offset = arm + Vec2::new(pose[0] - segment[0], pose[1] - segment[1]);
    let shape = |v: Vec2| (w11 * v.x + w12 * v.y, w22 * v.y);
    let (r0, r1) = shape(normal_in_robot);
    // d(Rᵀn̂)/dφ = −Rᵀû = −d(Rᵀn̂)/dθ.
    let (d0, d1) = shape(along_in_robot);
    let j_first = Matrix3::new(
        0.0,
        0.0,
        d0,
        0.0,
        0.0,
        d1,
        root * normal.x,
        root * normal.y,
        root * normal.dot(&quarter_turn(arm)),
    );
    let j_second = Matrix3::new(
        0.0,
        0.0,
        -d0,
        0.0,
        0.0,
        -d1,
        -root * normal.x,
        -root * normal.y,
        -root * along.dot(&offset),
    );
    Pair { residual: Vector3::new(r0, r1, root * normal.dot(&offset)), j_first, j_second }
}
