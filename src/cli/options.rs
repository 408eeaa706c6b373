//! Checks of options, so that a message names the flag as it was typed.

use hitl_slam::error::{Error, Result};
use hitl_slam::geometry::Pose2;

/// A start as `x_m,y_m,heading_deg`.
///
/// # Errors
/// [`Error::Input`] at `--start`, if it is not three finite numbers.
pub fn start_pose(text: &str) -> Result<Pose2> {
    let numbers: Vec<f64> =
        text.split(',').filter_map(|f| f.trim().parse().ok()).filter(|v: &f64| v.is_finite()).collect();
    match numbers.as_slice() {
        &[x_m, y_m, heading_deg] => Ok(Pose2::new(x_m, y_m, heading_deg.to_radians())),
        _ => Err(Error::input("--start", format_args!("found '{text}', expected x_m,y_m,heading_deg"))),
    }
}

/// A finite number > 0.
///
/// # Errors
/// [`Error::Input`] at the flag.
pub fn positive(flag: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::input(flag, format_args!("found {value}, expected a number > 0")))
}

/// A whole number of 1 or more.
///
/// # Errors
/// [`Error::Input`] at the flag.
pub fn at_least_one(flag: &str, value: usize) -> Result<()> {
    if value > 0 {
        return Ok(());
    }
    Err(Error::input(flag, "found 0, expected 1 or more"))
}
