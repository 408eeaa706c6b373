//! How the input chain goes wrong: white noise on every step, and a systematic bend and stretch of the whole run.
//!
//! A step is measured as z = z_true · n⁻¹, so that the residual of its factor at the true poses is exactly
//! n = (s·d + w_x, w_y − ℓ·n_θ, b + w_θ), with
//! - b the run's systematic heading error per step and s its scale error (d: length of the step),
//! - w white noise; w_θ sums to zero over the run, the run's mean belonging to b. So the chain's end heading is off by
//!   exactly what was drawn, and the bend in between still wanders;
//! - ℓ the lever arm: a scan match turns about what it sees, some way ahead of the robot, so a heading error comes
//!   with a sideways one. This is why the covariance is not diagonal.
//!
//! **Information.** A factor graph takes the steps for independent. Over N steps independent errors grow with √N, a
//! systematic one with N; a covariance from the white noise alone would make the true poses an 8 σ event and the
//! solver distrust every correction. So a systematic error b per step enters with the variance N·E\[b²\]: the end
//! of a chain of N such independent steps then has the variance N²·E\[b²\] that the end of the run really has.
//! Nominally 3–5 mrad and 2–6 mm a step; the released HitL-SLAM files say 11 mrad and 26 mm, for plain wheel odometry.

use rand_chacha::rand_core::Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

use nalgebra::Matrix3;

use crate::error::{Error, Result};
use crate::geometry::{Information, Pose2};
use crate::map::RelativeFactor;

/// The error model of a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Standard deviations of the white noise per step: x and y in metres, heading in radians.
    pub white: [f64; 3],
    /// The chain's end heading is off by something between these two, either way, radians.
    pub end_heading_rad: [f64; 2],
    /// Standard deviation of the run's scale error; 0.001 is a millimetre per metre.
    pub scale: f64,
    /// ℓ: how far ahead of the robot its scans are matched, metres.
    pub lever_m: f64,
}

impl Drift {
    /// A chain like that of a scan matcher in corridors: good scale, steps good to a millimetre, and a slow bend.
    pub fn scan_matched(end_heading_deg: [f64; 2], white_heading_rad: f64) -> Self {
        Drift {
            white: [0.001, 0.001, white_heading_rad],
            end_heading_rad: end_heading_deg.map(f64::to_radians),
            scale: 5e-4,
            lever_m: 0.5,
        }
    }

    /// The same with every error `factor` times as large.
    pub fn times(&self, factor: f64) -> Self {
        Drift {
            white: self.white.map(|s| s * factor),
            end_heading_rad: self.end_heading_rad.map(|h| h * factor),
            scale: self.scale * factor,
            ..*self
        }
    }

    /// The steps between consecutive `truth` poses as they are measured in one run.
    ///
    /// # Errors
    /// [`Error::Internal`] if the covariance cannot be inverted.
    pub fn measure(&self, truth: &[Pose2], random: &mut impl Rng) -> Result<Vec<RelativeFactor>> {
        let steps = truth.len().saturating_sub(1).max(1) as f64;
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let scale = self.scale * normal();
        let mut white: Vec<[f64; 3]> =
            truth.windows(2).map(|_| self.white.map(|sigma| sigma * normal())).collect();
        let mean_rad = white.iter().map(|w| w[2]).sum::<f64>() / steps;
        white.iter_mut().for_each(|w| w[2] -= mean_rad);
        let [low_rad, high_rad] = self.end_heading_rad;
        let share: f64 = StandardUniform.sample(random);
        let side: f64 = StandardUniform.sample(random);
        let end_rad = (low_rad + share * (high_rad - low_rad)) * if side < 0.5 { -1.0 } else { 1.0 };

        let mut factors = Vec::with_capacity(white.len());
        for (i, (pair, [x_m, y_m, theta_rad])) in truth.windows(2).zip(white).enumerate() {
            let i_from_j = pair[0].between(pair[1]);
            let heading_rad = end_rad / steps + theta_rad;
            let step_m = i_from_j.translation().norm();
            let error = Pose2::new(scale * step_m + x_m, y_m - self.lever_m * heading_rad, heading_rad);
            factors.push(RelativeFactor {
                i,
                j: i + 1,
                i_from_j: i_from_j.compose(error.inverse()),
                information: self.information(step_m, steps)?,
            });
        }
        Ok(factors)
    }

    /// Ω of a step of `step_m` in a run of `steps` such steps; see the module's text.
    fn information(&self, step_m: f64, steps: f64) -> Result<Information> {
        // E[h²] of a heading error spread evenly between the two bounds.
        let [low, high] = self.end_heading_rad;
        let end_heading_variance = (low * low + low * high + high * high) / 3.0;
        // Without noise there is no honest covariance: a tenth of a millimetre stands in for "exact".
        let variance = |white: f64, systematic: f64| (white * white + systematic).max(1e-8);
        let [x, y, theta] = self.white;
        let x = variance(x, steps * (self.scale * step_m).powi(2));
        let (y, theta) = (variance(y, 0.0), variance(theta, end_heading_variance / steps));
        let lever = self.lever_m;
        #[rustfmt::skip]
        let covariance = Matrix3::new(
            x,   0.0,                       0.0,
            0.0, y + lever * lever * theta, -lever * theta,
            0.0, -lever * theta,            theta,
        );
        Information::from_covariance(covariance).map_err(Error::Internal)
    }
}
