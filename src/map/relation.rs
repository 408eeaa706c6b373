//! A hand-checked relation between two scans of a log (Kümmerle et al. 2009): ground truth where there is no map.

use crate::geometry::Pose2;

/// Where the robot was at one stamp, seen from where it was at another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relation {
    /// Seconds, the log's clock.
    pub stamp_1_s: f64,
    /// Seconds, the log's clock.
    pub stamp_2_s: f64,
    /// The pose at `stamp_2_s` in the robot frame at `stamp_1_s`.
    pub first_from_second: Pose2,
}
