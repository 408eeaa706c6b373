//! From raw inertial data to steps: pedestrian dead reckoning (PDR).
//!
//! A [`Recording`] is checked by [`check`] (units, stuck and saturated sensors, dropouts), then read by what the sensor
//! was fixed to ([`Mount`]): on a foot, a strapdown solution that is told at every [`stance`] that the foot rests
//! ([`filter`], [`foot`]); in a hand, a step detector with a model of step length ([`hand`]). Formulas and sources:
//! `docs/MATH-pedestrian.md`.
//!
//! How the sensor is turned in its mount does not matter: everything is referred to gravity and to the direction in
//! which the walker goes. Frames: `n` navigation (z up, heading free), `b` the sensor.

pub mod check;
pub mod filter;
pub mod foot;
pub mod hand;
mod heading;
mod options;
mod recording;
pub mod stance;
pub mod still;

pub use options::{Mount, Options};
pub use recording::{Dropout, Recording, Sample};

use nalgebra::Matrix3;

use crate::error::Result;
use crate::pedestrian::{Step, Walk};

/// A step with how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct StepEvent {
    /// The step; its time is when the foot came to rest.
    pub step: Step,
    /// Until when the foot rested there, seconds.
    pub rests_until_s: f64,
    /// Covariance of (forward, left, turn): m², m rad, rad².
    pub covariance: Matrix3<f64>,
}

/// What dead reckoning made of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Pdr {
    /// What the sensor was taken to be fixed to.
    pub mount: Mount,
    /// The steps.
    pub steps: Vec<StepEvent>,
    /// Until when the walker stood before the first step, seconds.
    pub starts_s: f64,
    /// Gyroscope bias that was taken off at the start, sensor axes, rad/s; `None` where nothing was ever still.
    pub gyro_bias_radps: Option<[f64; 3]>,
    /// The still period which that bias is from, seconds.
    pub bias_from_s: Option<[f64; 2]>,
    /// Dropouts that were bridged.
    pub dropouts: Vec<Dropout>,
    /// Remarks that a person should see.
    pub remarks: Vec<String>,
}

impl Pdr {
    /// The steps as a walk.
    pub fn walk(&self, name: &str) -> Walk {
        Walk { name: name.to_owned(), steps: self.steps.iter().map(|s| s.step).collect() }
    }
}

/// Dead reckoning of a recording.
///
/// # Errors
/// [`crate::error::Error::Input`], its place `name`, if the recording is not fit for it (see [`check::prepare`]), options
/// are out of range, or no step is found.
pub fn reckon(name: &str, recording: &Recording, options: &Options) -> Result<Pdr> {
    options.validate()?;
    let prepared = check::prepare(name, recording)?;
    let mount = match options.mount {
        Some(mount) => mount,
        None => check::mount(name, &prepared.recording)?,
    };
    let mut pdr = match mount {
        Mount::Foot => foot::reckon(name, &prepared, options)?,
        Mount::Hand => hand::reckon(name, &prepared, options)?,
    };
    pdr.remarks.splice(0..0, prepared.remarks);
    pdr.dropouts = prepared.dropouts;
    Ok(pdr)
}
