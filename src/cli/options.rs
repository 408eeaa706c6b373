//! Checks of options, so that a message names the flag as it was typed.

use hitl_slam::error::{Error, Result};

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
