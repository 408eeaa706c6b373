//! Relative pose error: the motion from one matched pose to the next against the true motion (delta: 1 pose).

use super::ate::rms;
use crate::map::Trajectory;

/// Relative error of a trajectory. Needs no alignment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rpe {
    /// √(mean of squared translation errors), metres.
    pub translation_rmse_m: f64,
    /// √(mean of squared rotation errors), radians.
    pub rotation_rmse_rad: f64,
    /// Largest translation error, metres.
    pub translation_max_m: f64,
    /// Largest rotation error, radians.
    pub rotation_max_rad: f64,
}

/// The error over consecutive `pairs` (index in `estimate`, index in `truth`); `None` if there are fewer than two.
pub fn rpe(estimate: &Trajectory, truth: &Trajectory, pairs: &[(usize, usize)]) -> Option<Rpe> {
    let error = |step: &[(usize, usize)]| {
        let ((i0, j0), (i1, j1)) = (step[0], step[1]);
        let true_motion = truth.poses[j0].between(truth.poses[j1]);
        let error = true_motion.between(estimate.poses[i0].between(estimate.poses[i1]));
        (error.translation().norm(), error.theta_rad.abs())
    };
    let errors: Vec<(f64, f64)> = pairs.windows(2).map(error).collect();
    Some(Rpe {
        translation_rmse_m: rms(errors.iter().map(|e| e.0))?,
        rotation_rmse_rad: rms(errors.iter().map(|e| e.1))?,
        translation_max_m: errors.iter().map(|e| e.0).fold(0.0, f64::max),
        rotation_max_rad: errors.iter().map(|e| e.1).fold(0.0, f64::max),
    })
}
