//! One table: a header, then a sample a line, commas between.

use nalgebra::Vector3;

use super::COLUMNS;
use crate::error::Result;
use crate::inertial::{Recording, Sample};
use crate::io::Read;
use crate::io::source::Lines;
use crate::io::text::{number, show};

const STANDARD_GRAVITY_MPS2: f64 = 9.80665;

/// What an accelerometer's or gyroscope's numbers are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    /// m/s² or rad/s.
    Si,
    /// g or °/s.
    Common,
    /// Not said: told from the numbers.
    Unsaid,
}

/// Where a header has what.
struct Layout {
    /// Time, accelerometer, gyroscope.
    columns: [usize; 7],
    units: [Unit; 2],
    /// Columns that say whether a neighbour is valid (1) or not.
    valid: Vec<usize>,
    count: usize,
}

/// Reads a table from its first line on.
pub fn read(mut lines: Lines) -> Result<Read<Recording>> {
    let expected = COLUMNS.join(",");
    if !lines.advance()? {
        return Err(lines.file_error(format_args!("found an empty file, expected the header {expected}")));
    }
    let Some(layout) = layout(&String::from_utf8_lossy(lines.line())) else {
        let found = show(lines.line()).into_owned();
        return Err(lines.error(format_args!("found the header '{found}', expected {expected}, or a time, three axes of an accelerometer and of a gyroscope")));
    };
    let mut samples: Vec<Sample> = Vec::new();
    let (mut repeated, mut invalid) = (0, 0);
    while lines.advance()? {
        if lines.line().iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let fields: Vec<&[u8]> = lines.line().split(|&b| b == b',').collect();
        if fields.len() != layout.count {
            return Err(lines.error(format_args!(
                "found {} fields, expected {}",
                fields.len(),
                layout.count
            )));
        }
        let mut v = [0.0; 7];
        for ((value, &column), name) in v.iter_mut().zip(&layout.columns).zip(COLUMNS) {
            *value = number(fields[column]).map_err(|m| lines.error(format_args!("{name}: {m}")))?;
        }
        if layout.valid.iter().any(|&k| fields[k].trim_ascii() != b"1") {
            invalid += 1;
            continue;
        }
        let sample = Sample {
            time_s: v[0],
            force_mps2: Vector3::new(v[1], v[2], v[3]),
            rate_radps: Vector3::new(v[4], v[5], v[6]),
        };
        match samples.last() {
            Some(before) if *before == sample => repeated += 1,
            Some(before) if before.time_s >= sample.time_s => {
                let (time, before) = (sample.time_s, before.time_s);
                return Err(
                    lines.error(format_args!("time_s: found {time} after {before}, expected a later time"))
                );
            }
            _ => samples.push(sample),
        }
    }
    let mut warnings: Vec<String> = lines.cut_off_remark().into_iter().collect();
    for (count, what) in [(repeated, "repeat the line before"), (invalid, "are marked as not valid")] {
        if count > 0 {
            warnings.push(format!("{}: {count} lines {what}: left out", lines.file()));
        }
    }
    if samples.is_empty() {
        return Err(lines.file_error("found no sample, expected at least one line below the header"));
    }
    let mut recording = Recording { samples };
    to_si(&mut recording, layout.units, lines.file(), &mut warnings);
    Ok(Read { value: recording, warnings })
}

/// The columns of a header, if it has all seven.
fn layout(header: &str) -> Option<Layout> {
    let names: Vec<String> = header
        .trim_start_matches('\u{feff}')
        .split(',')
        // "inertial-6253.76535:scaledAccelX" and "…:estCompensatedAccelX:valid"
        .map(|name| name.trim().to_lowercase())
        .collect();
    let is_flag = |name: &str| name.ends_with(":valid");
    let stem = |name: &str| name.rsplit(':').next().unwrap_or_default().to_owned();
    let one = |fits: &dyn Fn(&str) -> bool| {
        let mut found = (0..names.len()).filter(|&k| !is_flag(&names[k]) && fits(&stem(&names[k])));
        found.next().filter(|_| found.next().is_none())
    };
    let sensor = |words: [&str; 2], axis: &str| {
        one(&|name| {
            let bare = name.split(" (").next().unwrap_or(name);
            let bare = bare.strip_suffix("_mps2").or(bare.strip_suffix("_radps")).unwrap_or(bare);
            let bare = bare.strip_suffix("_degps").or(bare.strip_suffix("_g")).unwrap_or(bare);
            words.iter().any(|word| bare.contains(word)) && bare.ends_with(axis)
        })
    };
    let mut columns = [one(&|name| ["time_s", "time", "time (s)"].contains(&name))?; 7];
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        columns[1 + k] = sensor(["acc", "accel"], axis)?;
        columns[4 + k] = sensor(["gyro", "angularrate"], axis)?;
    }
    let unit = |column: usize| {
        let name = stem(&names[column]);
        match name {
            n if ["_mps2", "(m/s^2)", "(m/s²)", "_radps", "(rad/s)"].iter().any(|u| n.ends_with(u)) => {
                Unit::Si
            }
            n if ["_g", "(g)", "_degps", "(deg/s)"].iter().any(|u| n.ends_with(u)) => Unit::Common,
            _ => Unit::Unsaid,
        }
    };
    let units = [unit(columns[1]), unit(columns[4])];
    if [2, 3].iter().any(|&k| unit(columns[k]) != units[0])
        || [5, 6].iter().any(|&k| unit(columns[k]) != units[1])
    {
        return None;
    }
    let wanted = |name: &str| columns[1..].iter().any(|&c| names[c] == name);
    let valid = (0..names.len()).filter(|&k| names[k].strip_suffix(":valid").is_some_and(wanted)).collect();
    Some(Layout { columns, units, valid, count: names.len() })
}

/// To m/s² and rad/s. Where the header says nothing, the numbers tell: gravity is 9.8 or 1 long, and nobody turns at
/// 40 rad/s.
fn to_si(recording: &mut Recording, units: [Unit; 2], file: &str, warnings: &mut Vec<String>) {
    let length = recording.gravity_length();
    let in_g = units[0] == Unit::Unsaid && (0.8..1.2).contains(&length);
    if in_g {
        warnings.push(format!("{file}: the accelerometer's unit is not said; gravity of {length:.3} says g"));
    }
    let fast = recording.rate_quantile_radps(0.99);
    let in_deg = units[1] == Unit::Unsaid && fast > 40.0;
    if in_deg {
        warnings.push(format!(
            "{file}: the gyroscope's unit is not said; turns of {fast:.0} say degrees per second"
        ));
    }
    for sample in &mut recording.samples {
        if in_g || units[0] == Unit::Common {
            sample.force_mps2 *= STANDARD_GRAVITY_MPS2;
        }
        if in_deg || units[1] == Unit::Common {
            sample.rate_radps *= 1f64.to_radians();
        }
    }
}
