//! The residuals R1…R6 with their Jacobians, written once here and once in docs/MATH.md.
//!
//! R1…R4 (`smooth`) touch two blocks and return a [`Pair`]; R5 and R6 (`paper`) touch many and fill a list. All are
//! whitened, rows that do not exist are zero. Blocks are (x, y, θ); a segment's block is (centre x, centre y,
//! direction); an end point's is (x, y, nothing). Twin: `cpp/residuals.h`.

mod paper_fit;
mod paper_relation;
mod point;
mod relation;
mod relative;
mod sighting;
mod tie;

pub use paper_fit::{paper_fit, paper_fit_residual};
pub use paper_relation::paper_relation;
pub use point::point;
pub use relation::relation;
pub use relative::relative;
pub use sighting::sighting;
pub use tie::tie;

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Vec2, cos_sin};

/// ε: keeps the paper's roots and norms differentiable at zero, √(s² + ε²) for |s|. Metres; far below any sensor.
pub const PAPER_EPSILON_M: f64 = 1e-5;

/// A term on two blocks at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// r, whitened, 3×1.
    pub residual: Vector3<f64>,
    /// ∂r/∂(first block), 3×3.
    pub j_first: Matrix3<f64>,
    /// ∂r/∂(second block), 3×3.
    pub j_second: Matrix3<f64>,
}

/// (cos, sin) unit vector û at an angle, and its normal n̂, 90° counter-clockwise.
fn frame(angle_rad: f64) -> (Vec2, Vec2) {
    let [c, s] = cos_sin(angle_rad);
    (Vec2::new(c, s), Vec2::new(-s, c))
}

/// A vector turned by an angle.
fn turn(angle_rad: f64, v: [f64; 2]) -> Vec2 {
    let (u, n) = frame(angle_rad);
    u * v[0] + n * v[1]
}

/// A vector turned by +90°: the derivative of a turned vector with respect to its angle.
fn quarter_turn(v: Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
}

/// The Jacobian of a term with one row.
fn single_row(gradient: [f64; 3]) -> Matrix3<f64> {
    let [x, y, z] = gradient;
    Matrix3::new(x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
}
