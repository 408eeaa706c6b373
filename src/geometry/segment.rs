//! A line segment with a centre, a direction and a half-length: the feature a stroke stands for.

use super::{Pose2, Vec2};

/// A line segment. Its direction is only meaningful modulo π; the sign is kept so that
/// residuals have one zero in reach (docs/MATH.md, "Relations").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Centre, metres.
    pub centre: Vec2,
    /// Direction, radians in (−π, π].
    pub direction_rad: f64,
    /// Half of the length, metres.
    pub half_length_m: f64,
}

impl Segment {
    /// The segment from `start` to `end`.
    pub fn from_ends(start: Vec2, end: Vec2) -> Self {
        let d = end - start;
        Segment { centre: (start + end) / 2.0, direction_rad: d.y.atan2(d.x), half_length_m: d.norm() / 2.0 }
    }

    /// Both end points.
    pub fn ends(&self) -> [Vec2; 2] {
        let half = self.direction() * self.half_length_m;
        [self.centre - half, self.centre + half]
    }

    /// Unit vector along the segment.
    pub fn direction(&self) -> Vec2 {
        let (s, c) = self.direction_rad.sin_cos();
        Vec2::new(c, s)
    }

    /// Unit normal, 90° counter-clockwise from the direction.
    pub fn normal(&self) -> Vec2 {
        let (s, c) = self.direction_rad.sin_cos();
        Vec2::new(-s, c)
    }

    /// Signed coordinates of a point: (along the direction from the centre, across along the normal), metres.
    pub fn along_across(&self, p: Vec2) -> (f64, f64) {
        let d = p - self.centre;
        (d.dot(&self.direction()), d.dot(&self.normal()))
    }

    /// The segment after a rigid motion.
    pub fn transformed(&self, motion: Pose2) -> Segment {
        Segment {
            centre: motion.transform_point(self.centre),
            direction_rad: super::wrap_angle(self.direction_rad + motion.theta_rad),
            half_length_m: self.half_length_m,
        }
    }
}
