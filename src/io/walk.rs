//! Walks and their truth as CSV (docs/FORMATS-walks.md).
//!
//! A walk: header `time_s,forward_m,left_m,turn_rad`, then one step a line; more columns may follow if their names end
//! in a unit. Truth: header `walker,time_s,x_m,y_m`. The name of a walker is its file's stem.

use std::io::{self, Write};
use std::path::Path;

use super::source::Lines;
use super::text::{Shortest, number, show};
use super::{Read, atomic};
use crate::error::{Error, Result};
use crate::geometry::Vec2;
use crate::inertial::StepEvent;
use crate::pedestrian::walk::LONGEST_STEP_M;
use crate::pedestrian::{Step, TruthPoint, Walk};

/// The columns that every walk has, in this order.
pub const WALK_COLUMNS: [&str; 4] = ["time_s", "forward_m", "left_m", "turn_rad"];
/// The columns of a truth file.
pub const TRUTH_COLUMNS: [&str; 4] = ["walker", "time_s", "x_m", "y_m"];
/// What a column's name may end in.
pub(super) const UNITS: [&str; 19] = [
    "s", "ms", "m", "mm", "m2", "rad", "rad2", "deg", "mps", "mps2", "radps", "degps", "hz", "pa", "hpa",
    "ut", "degc", "v", "count",
];

/// Reads a walk.
///
/// # Errors
/// [`Error::Input`] with the line if a column is unknown, a field is missing or not a finite number, time does not
/// ascend, a step is longer than 5 m, or there is no step.
pub fn read(path: &Path) -> Result<Read<Walk>> {
    let mut lines = Lines::open(path)?;
    let columns = header(&mut lines, &WALK_COLUMNS)?;
    let mut steps: Vec<Step> = Vec::new();
    while lines.advance()? {
        if lines.line().iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let fields = fields(&lines, columns.len())?;
        let mut values = Vec::with_capacity(columns.len());
        for (name, field) in columns.iter().zip(fields) {
            values.push(number(field).map_err(|m| lines.error(format_args!("{name}: {m}")))?);
        }
        let step = Step { time_s: values[0], forward_m: values[1], left_m: values[2], turn_rad: values[3] };
        if let Some(before) = steps.last().filter(|s| s.time_s >= step.time_s) {
            let message =
                format!("time_s: found {} after {}, expected a later time", step.time_s, before.time_s);
            return Err(lines.error(message));
        }
        if step.length_m() > LONGEST_STEP_M {
            let found = format!("found a step of {:.1} m", step.length_m());
            return Err(
                lines.error(format!("{found}, expected at most {LONGEST_STEP_M} m: are steps missing?"))
            );
        }
        steps.push(step);
    }
    if steps.is_empty() {
        return Err(lines.file_error("found no step, expected at least one line below the header"));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Read { value: Walk { name, steps }, warnings: lines.cut_off_remark().into_iter().collect() })
}

/// Reads several walks.
///
/// # Errors
/// As [`read`]; also if two walkers have the same name.
pub fn read_all(paths: &[impl AsRef<Path>]) -> Result<Read<Vec<Walk>>> {
    let mut all = Read { value: Vec::<Walk>::new(), warnings: Vec::new() };
    for path in paths {
        let path = path.as_ref();
        let read = read(path)?;
        if all.value.iter().any(|w| w.name == read.value.name) {
            let message = format!(
                "found a second walker with the name '{}', expected different file names",
                read.value.name
            );
            return Err(Error::input(path.display(), message));
        }
        all.value.push(read.value);
        all.warnings.extend(read.warnings);
    }
    Ok(all)
}

/// Reads true positions; lines of one walker must be in time order.
///
/// # Errors
/// [`Error::Input`] with the line, as [`read`].
pub fn read_truth(path: &Path) -> Result<Read<Vec<TruthPoint>>> {
    let mut lines = Lines::open(path)?;
    let columns = header(&mut lines, &TRUTH_COLUMNS)?;
    let mut points: Vec<TruthPoint> = Vec::new();
    while lines.advance()? {
        if lines.line().iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let fields = fields(&lines, columns.len())?;
        let mut values = [0.0; 3];
        for (value, (name, field)) in values.iter_mut().zip(columns.iter().zip(&fields).skip(1)) {
            *value = number(field).map_err(|m| lines.error(format_args!("{name}: {m}")))?;
        }
        let walker = String::from_utf8_lossy(fields[0]).trim().to_owned();
        let [stamp_s, x_m, y_m] = values;
        if let Some(before) =
            points.iter().rev().find(|p| p.walker == walker).filter(|p| p.stamp_s >= stamp_s)
        {
            let message = format!(
                "time_s: found {stamp_s} after {} of '{walker}', expected a later time",
                before.stamp_s
            );
            return Err(lines.error(message));
        }
        points.push(TruthPoint { walker, stamp_s, position: Vec2::new(x_m, y_m) });
    }
    if points.is_empty() {
        return Err(lines.file_error("found no point, expected at least one line below the header"));
    }
    Ok(Read { value: points, warnings: lines.cut_off_remark().into_iter().collect() })
}

/// Writes a walk.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written.
pub fn write(path: &Path, walk: &Walk) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "{}", WALK_COLUMNS.join(","))?;
        walk.steps.iter().try_for_each(|s| write_row(out, &[s.time_s, s.forward_m, s.left_m, s.turn_rad]))
    })
}

/// The columns after a walk's own in what [`write_events`] writes: until when the foot rested, and the covariance.
pub const EVENT_COLUMNS: [&str; 7] = [
    "rests_until_s",
    "var_forward_m2",
    "cov_forward_left_m2",
    "var_left_m2",
    "cov_forward_turn_m_rad",
    "cov_left_turn_m_rad",
    "var_turn_rad2",
];

/// Writes steps with how well each is known.
///
/// # Errors
/// As [`write()`].
pub fn write_events(path: &Path, events: &[StepEvent]) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "{},{}", WALK_COLUMNS.join(","), EVENT_COLUMNS.join(","))?;
        events.iter().try_for_each(|event| {
            let (s, c) = (&event.step, &event.covariance);
            let own = [s.time_s, s.forward_m, s.left_m, s.turn_rad, event.rests_until_s];
            let known = [c[(0, 0)], c[(0, 1)], c[(1, 1)], c[(0, 2)], c[(1, 2)], c[(2, 2)]];
            write_row(out, &[own.as_slice(), &known].concat())
        })
    })
}

/// Writes true positions.
///
/// # Errors
/// As [`write()`].
pub fn write_truth(path: &Path, truth: &[TruthPoint]) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "{}", TRUTH_COLUMNS.join(","))?;
        truth.iter().try_for_each(|p| {
            write!(out, "{},", p.walker)?;
            write_row(out, &[p.stamp_s, p.position.x, p.position.y])
        })
    })
}

fn write_row(out: &mut dyn Write, values: &[f64]) -> io::Result<()> {
    let row: Vec<String> = values.iter().map(|&v| Shortest(v).to_string()).collect();
    writeln!(out, "{}", row.join(","))
}

/// Checks the first line: the `expected` columns, then only such whose names end in a unit.
pub(super) fn header(lines: &mut Lines, expected: &[&str]) -> Result<Vec<String>> {
    if !lines.advance()? {
        return Err(
            lines.file_error(format_args!("found an empty file, expected the header {}", expected.join(",")))
        );
    }
    let text = String::from_utf8_lossy(lines.line()).trim_start_matches('\u{feff}').to_owned();
    let columns: Vec<String> = text.split(',').map(|c| c.trim().to_owned()).collect();
    if columns.len() < expected.len() || columns.iter().zip(expected).any(|(found, name)| found != name) {
        let found = show(text.as_bytes()).into_owned();
        return Err(lines.error(format_args!("found the header '{found}', expected {}", expected.join(","))));
    }
    let has_unit = |c: &&String| c.rsplit_once('_').is_some_and(|(_, unit)| UNITS.contains(&unit));
    if let Some(unknown) = columns[expected.len()..].iter().find(|c| !has_unit(c)) {
        let found = show(unknown.as_bytes()).into_owned();
        return Err(lines.error(format_args!(
            "found the column '{found}', expected further columns to be named with their unit, such as height_m"
        )));
    }
    Ok(columns)
}

pub(super) fn fields(lines: &Lines, expected: usize) -> Result<Vec<&[u8]>> {
    let fields: Vec<&[u8]> = lines.line().split(|&b| b == b',').collect();
    if fields.len() != expected {
        return Err(lines.error(format_args!("found {} fields, expected {expected}", fields.len())));
    }
    Ok(fields)
}
