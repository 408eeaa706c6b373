//! A hand-checked relation between two scans of a log (Kümmerle et al. 2009): what trajectories are scored on.

use crate::geometry::Pose2;

/// The true motion between two scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relation {
    /// Stamp of the first scan, seconds.
    pub stamp_1_s: f64,
    /// Stamp of the second scan, seconds.
    pub stamp_2_s: f64,
    /// The second pose seen from the first.
    pub first_from_second: Pose2,
}
