//! Paths that `hitl feetslam run` or `live` wrote (`paths.csv`), read back as walks: the weighted means, step by step.

use std::path::Path;

use super::Read;
use super::source::Lines;
use super::text::number;
use super::walk::fields;
use crate::error::Result;
use crate::geometry::Pose2;
use crate::pedestrian::{Step, Walk};

/// The columns, in their order.
pub const COLUMNS: [&str; 10] = [
    "walker",
    "time_s",
    "best_x_m",
    "best_y_m",
    "mean_x_m",
    "mean_y_m",
    "mean_heading_rad",
    "sigma_m",
    "pdr_x_m",
    "pdr_y_m",
];

/// Reads the paths: the walks, each from its first line on, and where that is.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line: a header other than [`COLUMNS`], a field that is no finite number, time
/// that does not ascend, or a walker of one line only.
pub fn read(path: &Path) -> Result<Read<(Vec<Walk>, Vec<Pose2>)>> {
    let mut lines = Lines::open(path)?;
    super::walk::header(&mut lines, &COLUMNS)?;
    let mut tracks: Vec<(String, Vec<(f64, Pose2)>)> = Vec::new();
    while lines.advance()? {
        if lines.line().iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let fields = fields(&lines, COLUMNS.len())?;
        let value =
            |k: usize| number(fields[k]).map_err(|m| lines.error(format_args!("{}: {m}", COLUMNS[k])));
        let (time_s, pose) = (value(1)?, Pose2::new(value(4)?, value(5)?, value(6)?));
        let name = String::from_utf8_lossy(fields[0]).trim().to_owned();
        let known = tracks.iter().position(|(n, _)| *n == name).unwrap_or_else(|| {
            tracks.push((name.clone(), Vec::new()));
            tracks.len() - 1
        });
        let track = &mut tracks[known].1;
        if let Some((before_s, _)) = track.last().filter(|(t, _)| *t >= time_s) {
            let message =
                format!("time_s: found {time_s} after {before_s} of '{name}', expected a later time");
            return Err(lines.error(message));
        }
        track.push((time_s, pose));
    }
    if tracks.is_empty() || tracks.iter().any(|(_, t)| t.len() < 2) {
        return Err(lines.file_error("found a walker without steps, expected at least two lines of each"));
    }
    let step = |pair: &[(f64, Pose2)]| {
        let moved = pair[0].1.between(pair[1].1);
        Step { time_s: pair[1].0, forward_m: moved.x_m, left_m: moved.y_m, turn_rad: moved.theta_rad }
    };
    let starts = tracks.iter().map(|(_, t)| t[0].1).collect();
    let walks =
        tracks.into_iter().map(|(name, t)| Walk { name, steps: t.windows(2).map(step).collect() }).collect();
    Ok(Read { value: (walks, starts), warnings: lines.cut_off_remark().into_iter().collect() })
}
