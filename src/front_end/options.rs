//! What can be set about making a map from a log.

use super::OdometryNoise;
use crate::error::{Error, Result};

/// Settings of [`super::build`].
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// A new keyframe after this much motion since the last one, metres, > 0.
    pub keyframe_distance_m: f64,
    /// … or after this much turning, radians, > 0.
    pub keyframe_angle_rad: f64,
    /// Returns at or beyond this are dropped, metres: far beams hit at grazing angles and lever pose errors.
    pub max_range_m: f64,
    /// Returns at or below this are dropped, metres: the robot itself, or a "no return" that is written as 0.
    pub min_range_m: f64,
    /// Scan matching: match every scan again to what was seen after it too. Off where [`super::rematch`] follows anyway.
    pub second_look: bool,
    /// How far the odometry is trusted.
    pub odometry_noise: OdometryNoise,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            keyframe_distance_m: 0.25,
            keyframe_angle_rad: 10_f64.to_radians(),
            max_range_m: 30.0,
            min_range_m: 0.1,
            second_look: true,
            odometry_noise: OdometryNoise::default(),
        }
    }
}

impl Options {
    /// As the default, with the wider keyframes that scan matching needs: each one costs a new local map.
    pub fn for_scan_matching() -> Self {
        Options { keyframe_distance_m: 0.4, keyframe_angle_rad: 0.3, ..Options::default() }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::Input`] that names the option.
    pub fn validate(&self) -> Result<()> {
        let noise = &self.odometry_noise;
        let positive = [
            ("keyframe distance", self.keyframe_distance_m),
            ("keyframe angle", self.keyframe_angle_rad),
            ("maximum range", self.max_range_m),
            ("odometry noise along", noise.along_m),
            ("odometry noise across", noise.across_m),
            ("odometry noise of the heading", noise.heading_rad),
        ];
        let not_negative = [
            ("minimum range", self.min_range_m),
            ("odometry noise along per metre", noise.along_per_m),
            ("odometry noise across per metre", noise.across_per_m),
            ("odometry noise of the heading per radian", noise.heading_per_rad),
            ("odometry noise of the heading per metre", noise.heading_rad_per_m),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::input(name, format_args!("found {value}, expected a number > 0")));
            }
        }
        for (name, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::input(
                    name,
                    format_args!("found {value}, expected a number of 0 or more"),
                ));
            }
        }
        if self.min_range_m >= self.max_range_m {
            let message =
                format!("found {}, expected less than the maximum of {}", self.min_range_m, self.max_range_m);
            return Err(Error::input("minimum range", message));
        }
        Ok(())
    }
}
