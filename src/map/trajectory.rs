//! Stamped poses: what TUM files hold and what errors are measured on.

use crate::geometry::Pose2;

/// Poses with the time of each, in the order of the file or log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Seconds; the pose's index where there are no stamps. As long as `poses`.
    pub stamps_s: Vec<f64>,
    /// `world_from_robot` at each stamp.
    pub poses: Vec<Pose2>,
}

impl Trajectory {
    /// Indices of the poses, sorted by stamp; poses of equal stamps stay in their order.
    pub fn order_by_stamp(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.poses.len()).collect();
        order.sort_by(|&i, &j| self.stamps_s[i].total_cmp(&self.stamps_s[j]));
        order
    }
}
