//! Aligning a laser scan with a local map of earlier ones: point to line, in the frame of a keyframe.
//!
//! [`SurfelMap`] is the local map: short oriented pieces of wall, the two faces of a wall kept apart by their normals.
//! [`align`] refines a pose by iterated least squares (point-to-line ICP), [`Search`] finds one by brute force where
//! the start is too far off. Everything happens in the frame of a reference keyframe, never in the world: the result
//! does not depend on how the map is turned. Metres, radians; order (x, y, θ). Knows no logs and no pose graphs.

mod icp;
mod search;
mod surfel_map;

pub use icp::{Match, Prior, Schedule, align};
pub use search::{Found, Search, Window};
pub use surfel_map::{Surfel, SurfelMap};

use crate::geometry::{Pose2, Vec2, angle_diff};

/// What a radian counts for, metres.
const METRES_PER_RADIAN: f64 = 0.5;

/// How far apart two poses are for what a laser sees: metres, a radian counting as half a metre.
pub fn reach_m(a: Pose2, b: Pose2) -> f64 {
    (b.translation() - a.translation()).norm()
        + METRES_PER_RADIAN * angle_diff(b.theta_rad, a.theta_rad).abs()
}

/// A scan as points and unit normals towards the sensor, robot frame; a normal is zero where unknown.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cloud {
    /// Metres.
    pub points: Vec<Vec2>,
    /// As long as `points`.
    pub normals: Vec<Vec2>,
}
