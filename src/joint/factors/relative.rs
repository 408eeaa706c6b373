//! R1: r = U·[Rzᵀ(Riᵀ(tj − ti) − tz); wrap(θj − θi − θz)], 3×1. Blocks: pose i, pose j.

use nalgebra::{Matrix3, Vector3};

use super::{Pair, frame};
use crate::geometry::{Vec2, wrap_angle};
use crate::joint::problem::RelativeTerm;

/// R1 at two poses.
pub fn relative(term: &RelativeTerm, i: &[f64; 3], j: &[f64; 3]) -> Pair {
    // Rzᵀ Riᵀ is one rotation by −(θi + θz); its rows are the axes û, n̂ at that angle.
    let z = term.measured;
    let (u, n) = frame(i[2] + z[2]);
    let (uz, nz) = frame(z[2]);
    let d = Vec2::new(j[0] - i[0], j[1] - i[1]);
    let tz = Vec2::new(z[0], z[1]);
    let e = Vector3::new(u.dot(&d) - uz.dot(&tz), n.dot(&d) - nz.dot(&tz), wrap_angle(j[2] - i[2] - z[2]));
    let j_second = Matrix3::new(u.x, u.y, 0.0, n.x, n.y, 0.0, 0.0, 0.0, 1.0);
    let mut j_first = -j_second;
    j_first[(0, 2)] = n.dot(&d);
    j_first[(1, 2)] = -u.dot(&d);
    let whiten = Matrix3::from_row_slice(&term.sqrt_information);
    Pair { residual: whiten * e, j_first: whiten * j_first, j_second: whiten * j_second }
}
