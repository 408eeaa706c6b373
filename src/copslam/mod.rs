//! Stage 4: COP-SLAM (Dubbelman & Browning 2015): the closed-form spreading of a jump over the poses of a loop.
//!
//! After the explicit correction there is a discontinuity C between the last pose of X_a and the first of X_b.
//! C = ∏ Uᵢ: every relative pose between takes a share of C's rotation, then of what is left of its translation,
//! each in proportion to its own variance (isotropic, as the method demands). One pass, O(n); the last pose ends
//! exactly where it should.

use crate::geometry::{Pose2, angle_diff, isotropic_variances};
use crate::map::SlamMap;

/// Variances of the step from pose k to k + 1: (metres², radians²); infinite where no factor joins the two.
pub fn chain_variances(map: &SlamMap) -> Vec<(f64, f64)> {
    let mut variances = vec![(f64::INFINITY, f64::INFINITY); map.poses.len().saturating_sub(1)];
    for factor in map.relative_factors.iter().filter(|f| f.i.abs_diff(f.j) == 1) {
        let (translation, rotation) = isotropic_variances(&factor.information.covariance());
        let entry = &mut variances[factor.i.min(factor.j)];
        *entry = (entry.0.min(translation), entry.1.min(rotation));
    }
    variances
}

/// Bends the chain `poses` so that its last pose becomes `target`; the first stays.
/// `variances` belong to the steps between them: one fewer than poses.
pub fn distribute(poses: &mut [Pose2], variances: &[(f64, f64)], target: Pose2) {
    let steps = variances.len();
    if steps == 0 || poses.len() != steps + 1 {
        return;
    }
    let rotation_shares = shares(variances.iter().map(|v| v.1));
    let translation_shares = shares(variances.iter().map(|v| v.0));
    let turn = angle_diff(target.theta_rad, poses[steps].theta_rad);

    let mut before = poses[0];
    for k in 0..steps {
        let step = before.between(poses[k + 1]);
        before = poses[k + 1];
        let bent = Pose2::new(step.x_m, step.y_m, step.theta_rad + turn * rotation_shares[k]);
        poses[k + 1] = poses[k].compose(bent);
    }
    let left = target.translation() - poses[steps].translation();
    let mut share = 0.0;
    for k in 0..steps {
        share += translation_shares[k];
        poses[k + 1].x_m += left.x * share;
        poses[k + 1].y_m += left.y * share;
    }
    poses[steps] = target;
}

/// Shares in proportion to the variances, summing to one. Infinite variances (nothing holds the two poses together)
/// take everything, equally; where all are zero, all are equal.
fn shares(variances: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let weight: fn(f64) -> f64 = if variances.clone().any(|v| v.is_infinite()) {
        |v| f64::from(v.is_infinite())
    } else if variances.clone().any(|v| v > 0.0) {
        |v| v
    } else {
        |_| 1.0
    };
    let total: f64 = variances.clone().map(weight).sum();
    variances.map(|v| weight(v) / total).collect()
}
