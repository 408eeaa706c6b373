//! Absolute trajectory error (evo calls it APE): distances of matched poses after SE(2) alignment without scale.

use super::alignment::align;
use crate::geometry::{Pose2, angle_diff};
use crate::map::Trajectory;

/// Absolute error of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Ate {
    /// √(mean of squared distances), metres.
    pub rmse_m: f64,
    /// Largest distance, metres.
    pub max_m: f64,
    /// √(mean of squared heading errors), radians.
    pub heading_rmse_rad: f64,
    /// The alignment that was applied to the estimate.
    pub truth_from_estimate: Pose2,
    /// One entry per matched pose, in the order of time.
    pub errors: Vec<PoseError>,
}

/// Error of one pose after alignment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// Index of the pose in the estimate.
    pub pose: usize,
    /// The truth's stamp, seconds.
    pub stamp_s: f64,
    /// Distance from the truth, metres.
    pub translation_m: f64,
    /// Heading minus true heading, radians in (−π, π].
    pub heading_rad: f64,
}

/// The error over the matched `pairs` (index in `estimate`, index in `truth`); `None` if there are none.
pub fn ate(estimate: &Trajectory, truth: &Trajectory, pairs: &[(usize, usize)]) -> Option<Ate> {
    let place = |&(i, j): &(usize, usize)| (estimate.poses[i].translation(), truth.poses[j].translation());
    let truth_from_estimate = align(&pairs.iter().map(place).collect::<Vec<_>>());
    let error = |&(i, j): &(usize, usize)| {
        let (aligned, true_pose) = (truth_from_estimate.compose(estimate.poses[i]), truth.poses[j]);
        PoseError {
            pose: i,
            stamp_s: truth.stamps_s[j],
            translation_m: (aligned.translation() - true_pose.translation()).norm(),
            heading_rad: angle_diff(aligned.theta_rad, true_pose.theta_rad),
        }
    };
    let errors: Vec<PoseError> = pairs.iter().map(error).collect();
    Some(Ate {
        rmse_m: rms(errors.iter().map(|e| e.translation_m))?,
        max_m: errors.iter().map(|e| e.translation_m).fold(0.0, f64::max),
        heading_rmse_rad: rms(errors.iter().map(|e| e.heading_rad))?,
        truth_from_estimate,
        errors,
    })
}

/// Root of the mean square; `None` of nothing.
pub(super) fn rms(values: impl ExactSizeIterator<Item = f64>) -> Option<f64> {
    let n = values.len();
    (n > 0).then(|| (values.map(|v| v * v).sum::<f64>() / n as f64).sqrt())
}
