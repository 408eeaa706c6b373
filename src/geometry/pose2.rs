//! SE(2): a pose, or the transform that takes points of one frame to another.
//!
//! `world_from_robot` maps robot-frame points to world points. Tangent order (x, y, θ), metres and radians.
//! Estimators step by plain addition on (x, y, θ), the heading wrapped (docs/CONVENTIONS.md).

use super::{Vec2, angle_diff, wrap_angle};

/// Rigid motion of the plane: rotation by `theta_rad`, then translation by (`x_m`, `y_m`).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose2 {
    /// Translation, metres.
    pub x_m: f64,
    /// Translation, metres.
    pub y_m: f64,
    /// Heading, radians in (−π, π].
    pub theta_rad: f64,
}

impl Pose2 {
    /// The identity.
    pub const IDENTITY: Pose2 = Pose2 { x_m: 0.0, y_m: 0.0, theta_rad: 0.0 };

    /// A pose; the heading is wrapped into (−π, π].
    pub fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Pose2 { x_m, y_m, theta_rad: wrap_angle(theta_rad) }
    }

    /// From (x, y, θ).
    pub fn from_array([x_m, y_m, theta_rad]: [f64; 3]) -> Self {
        Pose2::new(x_m, y_m, theta_rad)
    }

    /// As (x, y, θ).
    pub fn to_array(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.theta_rad]
    }

    /// The translation part, metres.
    pub fn translation(self) -> Vec2 {
        Vec2::new(self.x_m, self.y_m)
    }

    /// `a_from_b.compose(b_from_c) = a_from_c`.
    pub fn compose(self, other: Pose2) -> Pose2 {
        let t = self.transform_point(other.translation());
        Pose2::new(t.x, t.y, self.theta_rad + other.theta_rad)
    }

    /// `a_from_b.inverse() = b_from_a`.
    pub fn inverse(self) -> Pose2 {
        let t = Pose2 { x_m: 0.0, y_m: 0.0, theta_rad: -self.theta_rad }.rotate(-self.translation());
        Pose2::new(t.x, t.y, -self.theta_rad)
    }

    /// `world_from_i.between(world_from_j) = i_from_j`.
    pub fn between(self, other: Pose2) -> Pose2 {
        let t = self.inverse_rotate(other.translation() - self.translation());
        Pose2::new(t.x, t.y, angle_diff(other.theta_rad, self.theta_rad))
    }

    /// A point of the inner frame, in the outer frame.
    pub fn transform_point(self, p: Vec2) -> Vec2 {
        self.rotate(p) + self.translation()
    }

    /// A direction of the inner frame, in the outer frame (no translation).
    pub fn rotate(self, v: Vec2) -> Vec2 {
        let (s, c) = self.theta_rad.sin_cos();
        Vec2::new(c * v.x - s * v.y, s * v.x + c * v.y)
    }

    /// A direction of the outer frame, in the inner frame.
    pub fn inverse_rotate(self, v: Vec2) -> Vec2 {
        let (s, c) = self.theta_rad.sin_cos();
        Vec2::new(c * v.x + s * v.y, -s * v.x + c * v.y)
    }

    /// The pose a share `t` in 0..=1 of the way from `self` to `other`: straight line, short way round.
    pub fn interpolate(self, other: Pose2, t: f64) -> Pose2 {
        let p = self.translation() + (other.translation() - self.translation()) * t;
        Pose2::new(p.x, p.y, self.theta_rad + t * angle_diff(other.theta_rad, self.theta_rad))
    }

    /// True if all three numbers are finite.
    pub fn is_finite(self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.theta_rad.is_finite()
    }
}
