//! What dead reckoning can be told; every number with its unit and range.

use crate::error::{Error, Result};

/// What the sensor is fixed to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mount {
    /// A foot, which rests on the ground in every stride.
    Foot,
    /// A hand (or a trunk), which never rests.
    Hand,
}

impl Mount {
    /// `foot` or `hand`.
    pub fn name(self) -> &'static str {
        match self {
            Mount::Foot => "foot",
            Mount::Hand => "hand",
        }
    }
}

/// Settings of dead reckoning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// What the sensor is fixed to; `None`: told from the recording.
    pub mount: Option<Mount>,
    /// Take the gyroscope's bias from still periods.
    pub still_bias: bool,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
    /// Foot: the stance detector's threshold γ on the likelihood ratio T.
    pub stance_threshold: f64,
    /// Foot: white noise of the specific force, m/s² per sample at 100 Hz (it covers what the model leaves out).
    pub force_noise_mps2: f64,
    /// Foot: white noise of the angular rate, rad/s per sample at 100 Hz.
    pub rate_noise_radps: f64,
    /// Foot: what is left of the velocity in a stance, m/s.
    pub stance_speed_mps: f64,
    /// Hand: Weinberg's K: a step's length is K (a_max − a_min)^¼.
    pub weinberg_gain: f64,
    /// Hand: the least swing of the vertical acceleration in a step, m/s².
    pub step_swing_mps2: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            mount: None,
            still_bias: true,
            gravity_mps2: 9.80665,
            stance_threshold: 1e5,
            force_noise_mps2: 0.5,
            rate_noise_radps: 0.5f64.to_radians(),
            stance_speed_mps: 0.01,
            weinberg_gain: 0.55,
            step_swing_mps2: 1.5,
        }
    }
}

impl Options {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Input`] at the first setting out of range.
    pub fn validate(&self) -> Result<()> {
        for (name, value, low, high) in [
            ("gravity", self.gravity_mps2, 9.7, 9.9),
            ("stance threshold", self.stance_threshold, 1.0, 1e9),
            ("force noise", self.force_noise_mps2, 1e-4, 100.0),
            ("rate noise", self.rate_noise_radps, 1e-6, 10.0),
            ("stance speed", self.stance_speed_mps, 1e-5, 1.0),
            ("Weinberg gain", self.weinberg_gain, 0.1, 2.0),
            ("step swing", self.step_swing_mps2, 0.1, 20.0),
        ] {
            if !(low..=high).contains(&value) {
                let message = format_args!("found {value}, expected a number from {low} to {high}");
                return Err(Error::input(name, message));
            }
        }
        Ok(())
    }
}
