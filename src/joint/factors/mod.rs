//! The residuals R1…R4 with their Jacobians, written once here and once in docs/MATH.md.
//!
//! Every function returns (residual 3×1, J first 3×3, J second 3×3), whitened, rows that do not exist zero.
//! Blocks are (x, y, θ); a segment's block is (centre x, centre y, direction).

mod relation;
mod relative;
mod sighting;
mod tie;

pub use relation::relation;
pub use relative::relative;
pub use sighting::sighting;
pub use tie::tie;

use crate::geometry::Vec2;

/// (cos, sin) unit vector û at an angle, and its normal n̂, 90° counter-clockwise.
fn frame(angle_rad: f64) -> (Vec2, Vec2) {
    let (s, c) = angle_rad.sin_cos();
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
