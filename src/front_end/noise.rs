//! How wrong wheel odometry may be over one step.
//!
//! Standard deviations of a step of d metres and Δθ radians, for the robots of the public logs (Pioneer, B21;
//! 1990s–2000s, indoors):
//!
//! σ_along = 5 mm + 5 % d      σ_across = 5 mm + 3 % d      σ_θ = 5 mrad + 5 % |Δθ| + 10 mrad/m · d
//!
//! The constants cover what does not shrink with the step: wheel slip while turning, and poses that are logged up to a
//! scan period away from their scan. Slip scales the distance, so along is worse than across; what carries a robot sideways
//! is its heading, which accumulates over the chain by itself. Over 10 m straight in steps of 0.25 m this makes
//! 0.11 m along, 0.05 rad (2.7°) of heading.

use crate::geometry::{Information, Pose2};

/// Error model of odometry; see the module's formula. Sigmas, not variances.
#[derive(Debug, Clone, PartialEq)]
pub struct OdometryNoise {
    /// Along the direction of motion, metres, of every step.
    pub along_m: f64,
    /// Along, metres per metre.
    pub along_per_m: f64,
    /// Across the direction of motion, metres, of every step.
    pub across_m: f64,
    /// Across, metres per metre.
    pub across_per_m: f64,
    /// Heading, radians, of every step.
    pub heading_rad: f64,
    /// Heading, radians per radian of turning.
    pub heading_per_rad: f64,
    /// Heading, radians per metre.
    pub heading_rad_per_m: f64,
}

impl Default for OdometryNoise {
    fn default() -> Self {
        OdometryNoise {
            along_m: 0.005,
            along_per_m: 0.05,
            across_m: 0.005,
            across_per_m: 0.03,
            heading_rad: 0.005,
            heading_per_rad: 0.05,
            heading_rad_per_m: 0.01,
        }
    }
}

impl OdometryNoise {
    /// Ω of a measured step, in the axes of its residual: those of pose j as measured. "Along" is the direction of
    /// the step's translation, which in those axes points at atan2(z_y, z_x) − z_θ.
    pub fn information(&self, i_from_j: Pose2) -> Information {
        let distance_m = i_from_j.translation().norm();
        let sigma_along_m = self.along_m + self.along_per_m * distance_m;
        let sigma_across_m = self.across_m + self.across_per_m * distance_m;
        let sigma_theta_rad = self.heading_rad
            + self.heading_per_rad * i_from_j.theta_rad.abs()
            + self.heading_rad_per_m * distance_m;
        let bearing_rad = i_from_j.y_m.atan2(i_from_j.x_m) - i_from_j.theta_rad;
        let diagonal = Information::from_sigmas(sigma_along_m, sigma_across_m, sigma_theta_rad);
        let rotated = diagonal.rotated(bearing_rad);
        // Symmetric to the last bit, so that a file gives back what was written.
        Information::new(rotated.matrix()).unwrap_or(rotated)
    }
}
