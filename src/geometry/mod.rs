//! Numbers only: angles, SE(2) poses, line segments, covariances. Knows nothing of maps.

mod angle;
mod cells;
mod information;
mod pose2;
mod scatter;
mod segment;

pub use angle::{angle_diff, cos_sin, cos_sin_of, wrap_angle};
pub use cells::walk_cells;
pub use information::{Information, isotropic_variances};
pub use pose2::Pose2;
pub use scatter::{Scatter, principal_direction};
pub use segment::Segment;

/// A point or vector in the plane, metres.
pub type Vec2 = nalgebra::Vector2<f64>;
