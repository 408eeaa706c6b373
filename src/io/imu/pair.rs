//! Two text files, one per sensor: some lines of prose that say the unit, the line
//! `elapsed-time-system elapsed-time-sensor x y z`, then a reading a line.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use crate::error::{Error, Result};
use crate::inertial::{Recording, Sample};
use crate::io::Read;
use crate::io::source::Lines;
use crate::io::text;

const HEADER: &[u8] = b"elapsed-time-system elapsed-time-sensor x y z";
const NAMES: [&str; 5] = ["elapsed-time-system", "elapsed-time-sensor", "x", "y", "z"];
/// The header comes within the first lines.
const PROSE_LINES: usize = 20;
/// Readings further apart are not bridged here, seconds.
const APART_S: f64 = 0.05;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sensor {
    Accelerometer,
    Gyroscope,
}

/// One sensor's readings.
struct Readings {
    /// System's clock, sensor's clock, seconds.
    times_s: Vec<[f64; 2]>,
    values: Vec<Vector3<f64>>,
}

/// True if a file is one of two that belong together.
pub fn is_one_of_two(path: &Path) -> Result<bool> {
    Ok(sensor(path)?.is_some())
}

/// Reads both; `path` is either of them, or their folder. The gyroscope's clock counts; the accelerometer is interpolated.
pub fn read(path: &Path) -> Result<Read<Recording>> {
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new(".")) };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|e| e.map(|e| e.path())).collect())
        .map_err(|e| Error::io(folder, e))?;
    files.retain(|f| f.is_file());
    files.sort();
    let find = |wanted: Sensor, name: &str| -> Result<PathBuf> {
        if path.is_file() && sensor(path)? == Some(wanted) {
            return Ok(path.to_path_buf());
        }
        // What cannot be read as text is not one of the two.
        let mut found = files.iter().filter(|f| sensor(f).ok().flatten() == Some(wanted));
        match (found.next(), found.next()) {
            (Some(file), None) => Ok(file.clone()),
            (None, _) => Err(Error::input(
                folder.display(),
                format_args!("found no {name} readings, expected one file of them beside the other"),
            )),
            _ => Err(Error::input(
                folder.display(),
                format_args!("found several files of {name} readings, expected one"),
            )),
        }
    };
    let (force, rate) =
        (find(Sensor::Accelerometer, "accelerometer")?, find(Sensor::Gyroscope, "gyroscope")?);
    let mut warnings = Vec::new();
    let (force, rate) = (readings(&force, &mut warnings)?, readings(&rate, &mut warnings)?);
    let mut lags: Vec<f64> = rate.times_s.iter().map(|[system, sensor]| system - sensor).collect();
    lags.sort_unstable_by(f64::total_cmp);
    let lag_s = lags[lags.len() / 2];
    let mut samples = Vec::with_capacity(rate.values.len());
    let mut next = 0;
    for (&[_, time_s], &rate_radps) in rate.times_s.iter().zip(&rate.values) {
        while force.times_s.get(next).is_some_and(|t| t[1] < time_s) {
            next += 1;
        }
        let (Some(before), Some(after)) = (next.checked_sub(1), force.times_s.get(next)) else { continue };
        let from_s = force.times_s[before][1];
        if after[1] - from_s > APART_S {
            continue;
        }
        let share = (time_s - from_s) / (after[1] - from_s);
        let force_mps2 = force.values[before].lerp(&force.values[next], share);
        samples.push(Sample { time_s: time_s + lag_s, force_mps2, rate_radps });
    }
    if samples.is_empty() {
        return Err(Error::input(
            folder.display(),
            "found sensors without a time in common, expected one recording",
        ));
    }
    Ok(Read { value: Recording { samples }, warnings })
}

/// Whose readings a file holds, if it is of this layout.
fn sensor(path: &Path) -> Result<Option<Sensor>> {
    let mut lines = Lines::open(path)?;
    let mut unit = None;
    for _ in 0..PROSE_LINES {
        if !lines.advance()? {
            return Ok(None);
        }
        let line = lines.line();
        if line.trim_ascii() == HEADER {
            return Ok(unit);
        }
        let says = |words: &[u8]| line.windows(words.len()).any(|w| w == words);
        if says(b"(m/s^2)") {
            unit = Some(Sensor::Accelerometer);
        } else if says(b"radians/second") {
            unit = Some(Sensor::Gyroscope);
        }
    }
    Ok(None)
}

fn readings(path: &Path, warnings: &mut Vec<String>) -> Result<Readings> {
    let mut lines = Lines::open(path)?;
    while lines.advance()? && lines.line().trim_ascii() != HEADER {}
    let mut all = Readings { times_s: Vec::new(), values: Vec::new() };
    let mut repeated = 0;
    while lines.advance()? {
        let Some([system, sensor, x, y, z]) = text::row(lines.line(), &NAMES).map_err(|m| lines.error(m))?
        else {
            continue;
        };
        match all.times_s.last() {
            // Readings within a millisecond have the same time: the first one stands for them.
            Some(before) if before[1] == sensor => {
                repeated += 1;
                continue;
            }
            Some(before) if before[1] > sensor => {
                let message =
                    format!("elapsed-time-sensor: found {sensor} after {}, expected a later time", before[1]);
                return Err(lines.error(message));
            }
            _ => (),
        }
        all.times_s.push([system, sensor]);
        all.values.push(Vector3::new(x, y, z));
    }
    warnings.extend(lines.cut_off_remark());
    if repeated > 0 {
        warnings
            .push(format!("{}: {repeated} readings have the time of the one before: left out", lines.file()));
    }
    if all.values.is_empty() {
        return Err(lines.file_error("found no reading, expected at least one"));
    }
    Ok(all)
}
