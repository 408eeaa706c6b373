//! Inertial recordings (docs/FORMATS-walks.md). What a file is, is told from its content:
//!
//! - a table with a header: the canonical `time_s,acc_x_mps2,…,gyro_z_radps`, or any that names a time, three axes of an
//!   accelerometer and three of a gyroscope, with their units or without (`table.rs`);
//! - two text files beside each other, one per sensor, as some phone recorders write them: either of them, or their
//!   folder (`pair.rs`).

mod pair;
mod table;

use std::path::Path;

use super::Read;
use super::source::Lines;
use crate::error::Result;
use crate::inertial::Recording;

/// The columns of the canonical layout.
pub const COLUMNS: [&str; 7] =
    ["time_s", "acc_x_mps2", "acc_y_mps2", "acc_z_mps2", "gyro_x_radps", "gyro_y_radps", "gyro_z_radps"];

/// Reads a recording, in m/s² and rad/s.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line or field if it is none of the layouts, a number is missing or not finite,
/// or time does not ascend.
pub fn read(path: &Path) -> Result<Read<Recording>> {
    if path.is_dir() || pair::is_one_of_two(path)? {
        return pair::read(path);
    }
    table::read(Lines::open(path)?)
}
