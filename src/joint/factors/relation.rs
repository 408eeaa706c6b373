//! R4: what the person said about segments a and b; Δφ = φ_b − φ_a, d = c_b − c_a, each entry over its σ.
//!
//! colocation [d; sin Δφ] · collinear [n̂_a·d; sin Δφ] · parallel [sin Δφ] · perpendicular [cos Δφ].
//! The paper's K₁, K₂ are 1/σ_offset, 1/σ_angle. Blocks: segment a, segment b.

use nalgebra::{Matrix3, Vector3};

use super::{Pair, frame};
use crate::geometry::Vec2;
use crate::joint::problem::RelationTerm;
use crate::map::Mode;

/// R4 at two segments.
pub fn relation(term: &RelationTerm, a: &[f64; 3], b: &[f64; 3]) -> Pair {
    let d = Vec2::new(b[0] - a[0], b[1] - a[1]);
    let (sin, cos) = (b[2] - a[2]).sin_cos();
    let (k_offset, k_angle) = (term.offset_scale, term.angle_scale);
    let mut residual = Vector3::zeros();
    let mut j_first = Matrix3::zeros();
    let mut j_second = Matrix3::zeros();
    match term.mode {
        Mode::Colocation => {
            // In the frame of a, so that the residual does not depend on how the map is turned.
            let (u, n) = frame(a[2]);
            for (row, (axis, turned)) in [(u, n), (n, -u)].into_iter().enumerate() {
                residual[row] = k_offset * axis.dot(&d);
                set_offset_row(&mut j_first, &mut j_second, row, axis * k_offset, k_offset * turned.dot(&d));
            }
        }
        Mode::Collinear => {
            let (u, n) = frame(a[2]);
            residual[0] = k_offset * n.dot(&d);
            set_offset_row(&mut j_first, &mut j_second, 0, n * k_offset, -k_offset * u.dot(&d));
        }
        Mode::Parallel | Mode::Perpendicular => {}
    }
    let (angle, slope) = if term.mode == Mode::Perpendicular { (cos, -sin) } else { (sin, cos) };
    residual[2] = k_angle * angle;
    j_first[(2, 2)] = -k_angle * slope;
    j_second[(2, 2)] = k_angle * slope;
    Pair { residual, j_first, j_second }
}

fn set_offset_row(
    first: &mut Matrix3<f64>,
    second: &mut Matrix3<f64>,
    row: usize,
    axis: Vec2,
    by_direction_a: f64,
) {
    for k in 0..2 {
        first[(row, k)] = -axis[k];
        second[(row, k)] = axis[k];
    }
    first[(row, 2)] = by_direction_a;
}
