//! CARMEN logs: one message a line, the first word says which (docs/FORMATS.md, "CARMEN log").
//!
//! ```text
//! FLASER n r[0..n) laser_x laser_y laser_theta robot_x robot_y robot_theta stamp host logger_stamp
//! ROBOTLASER1 type start_angle fov angle_step max_range accuracy remission_mode n r[0..n) m remission[0..m)
//!     laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward side turn_axis stamp host logger_stamp
//! PARAM name value …
//! ```
//! Metres, radians, seconds. The robot pose is the odometry. Scans stay in the order of the file.
//! Where the laser sits on the robot is what all lines agree on, or the PARAM where they do not.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use super::Read;
use super::source::Lines;
use super::text::{fields, integer, number, numbers, show};
use crate::error::Result;
use crate::geometry::{Pose2, angle_diff};
use crate::map::{LogScan, RawLog};

/// Offsets of the lines count as one constant if they agree to this; logs are written to 1e-6 or six digits.
const OFFSET_SPREAD_M: f64 = 0.01;
const OFFSET_SPREAD_RAD: f64 = 0.5 * PI / 180.0;
/// Share of the lines that must agree: one glitch in a log must not turn a constant into a variable.
const OFFSET_AGREEING: f64 = 0.95;

const POSES: [&str; 6] = ["laser x", "laser y", "laser theta", "robot x", "robot y", "robot theta"];

/// Messages of the CARMEN family that hold nothing a map is made of.
const OTHER_TAGS: [&str; 14] = [
    "SYNC",
    "RLASER",
    "TRUEPOS",
    "NEFF",
    "RAWLASER1",
    "RAWLASER2",
    "RAWLASER3",
    "RAWLASER4",
    "ROBOTLASER2",
    "REMISSIONFLASER",
    "REMISSIONRLASER",
    "LASER3",
    "LASER4",
    "MARKER",
];

/// True if `tag` begins a line of a CARMEN log.
pub(crate) fn is_tag(tag: &str) -> bool {
    ["FLASER", "ROBOTLASER1", "ODOM", "PARAM"].contains(&tag)
        || OTHER_TAGS.contains(&tag)
        || tag.starts_with("NMEA-")
}

/// Reads a log.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line, if a line is cut off or garbled or there is no scan.
pub fn read(path: &Path) -> Result<Read<RawLog>> {
    let mut lines = Lines::open(path)?;
    let mut warnings = Vec::new();
    let mut unknown = BTreeSet::new();
    let mut params = Params::default();
    // Until the laser's place is known, `world_from_robot` holds the pose of the laser.
    let mut scans: Vec<LogScan> = Vec::new();
    let mut kind: Option<&str> = None;
    while lines.advance()? {
        let mut words = fields(lines.line());
        let Some(tag) = words.next() else { continue };
        match tag {
            b"FLASER" | b"ROBOTLASER1" => {
                let name = if tag == b"FLASER" { "FLASER" } else { "ROBOTLASER1" };
                if *kind.get_or_insert(name) != name {
                    if unknown.insert(name.to_string()) {
                        let first = kind.unwrap_or_default();
                        warnings.push(lines.remark(format_args!(
                            "{name} lines are skipped: the log's first scan is a {first} line, and loggers write both for one scan"
                        )));
                    }
                    continue;
                }
                let scan = if name == "FLASER" { flaser(lines.line()) } else { robot_laser(lines.line()) };
                scans.push(scan.map_err(|m| lines.error(format_args!("{name}: {m}")))?);
            }
            b"ODOM" => {
                let names = ["x", "y", "theta", "tv", "rv", "acceleration", "stamp"];
                numbers(&mut words, &names).map_err(|m| lines.error(format_args!("ODOM: {m}")))?;
            }
            b"PARAM" => params.take(words).map_err(|m| lines.error(format_args!("PARAM: {m}")))?,
            _ if tag.starts_with(b"#") => {}
            _ => {
                let plain = |b: &u8| b.is_ascii_uppercase() || b.is_ascii_digit() || b"_-:".contains(b);
                if !tag[0].is_ascii_uppercase() || !tag.iter().all(plain) {
                    let message =
                        format!("found a line that begins with '{}', expected a CARMEN message", show(tag));
                    return Err(lines.error(message));
                }
                let tag = show(tag).into_owned();
                if !is_tag(&tag) && !unknown.contains(&tag) {
                    warnings.push(lines.remark(format_args!("unknown message {tag}: skipped")));
                    unknown.insert(tag);
                }
            }
        }
    }
    warnings.extend(lines.cut_off_remark());
    if scans.is_empty() {
        return Err(lines.file_error("found no scan, expected FLASER or ROBOTLASER1 lines"));
    }
    let robot_from_laser = laser_offset(&scans, params.laser_offset_m, lines.file(), &mut warnings);
    let laser_from_robot = robot_from_laser.inverse();
    for scan in &mut scans {
        scan.world_from_robot = scan.world_from_robot.compose(laser_from_robot);
        if let Some(max_range_m) = params.max_range_m {
            scan.max_range_m = scan.max_range_m.min(max_range_m);
        }
    }
    Ok(Read { value: RawLog { scans, robot_from_laser }, warnings })
}

#[derive(Default)]
struct Params {
    laser_offset_m: Option<f64>,
    max_range_m: Option<f64>,
}

impl Params {
    fn take<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]>) -> std::result::Result<(), String> {
        let name = words.next().ok_or("found no name, expected a name and a value")?;
        let Ok(name) = std::str::from_utf8(name) else { return Ok(()) };
        // robot_front_laser_max is left alone: it bounds what the planner looks at, not what the laser saw.
        let max_range =
            name.starts_with("laser") && (name.contains("max_range") || name.ends_with("laser_max"));
        if name == "robot_frontlaser_offset" || max_range {
            let value = words.next().ok_or_else(|| format!("{name}: found no value, expected a number"))?;
            let value = number(value).map_err(|m| format!("{name}: {m}"))?;
            if !max_range {
                self.laser_offset_m = Some(value);
            } else if value > 0.0 {
                self.max_range_m = Some(value);
            }
        }
        Ok(())
    }
}

/// A FLASER line: the field of view is 180°, and the number of ranges says how it is divided.
fn flaser(line: &[u8]) -> std::result::Result<LogScan, String> {
    let mut words = fields(line).skip(1);
    let n = count(words.next(), "ranges")?;
    let found = words.clone().count();
    if found != n.saturating_add(9) {
        let ranges = found.saturating_sub(9);
        return Err(format!(
            "expected {n} ranges, found {ranges} before the poses, stamp, host and logger stamp"
        ));
    }
    let ranges_m = ranges(&mut words, n)?;
    let [lx, ly, lt, rx, ry, rt] = numbers(&mut words, &POSES)?;
    let [stamp_s] = numbers(&mut words, &["stamp"])?;
    // 180 and 360 ranges: the beam at +90° is left out; 181 and 361: it is there.
    let steps = if n % 2 == 1 { n - 1 } else { n };
    Ok(LogScan {
        stamp_s,
        odometry_from_robot: Pose2::new(rx, ry, rt),
        world_from_robot: Pose2::new(lx, ly, lt),
        first_bearing_rad: -FRAC_PI_2,
        bearing_step_rad: PI / steps.max(1) as f64,
        max_range_m: f64::INFINITY,
        ranges_m,
    })
}

/// A ROBOTLASER1 line. `world_from_robot` of the result is the pose of the *laser*.
pub(crate) fn robot_laser(line: &[u8]) -> std::result::Result<LogScan, String> {
    let mut words = fields(line).skip(1);
    let names =
        ["laser type", "start angle", "field of view", "angular resolution", "maximum range", "accuracy"];
    let [_, first_bearing_rad, fov_rad, step_rad, max_range_m, _] = numbers(&mut words, &names)?;
    numbers(&mut words, &["remission mode"])?;
    let n = count(words.next(), "ranges")?;
    let rest = words.clone().count();
    if rest < n {
        return Err(format!("expected {n} ranges, found {rest}"));
    }
    let ranges_m = ranges(&mut words, n)?;
    let remissions = count(words.next(), "remissions")?;
    let rest = words.clone().count();
    if rest != remissions.saturating_add(14) {
        let found = rest.saturating_sub(remissions.min(rest));
        return Err(format!("expected 14 fields after {remissions} remissions, found {found}"));
    }
    for _ in 0..remissions {
        numbers(&mut words, &["remission"])?;
    }
    let [lx, ly, lt, rx, ry, rt] = numbers(&mut words, &POSES)?;
    let names = ["tv", "rv", "forward safety distance", "side safety distance", "turn axis", "stamp"];
    let [.., stamp_s] = numbers(&mut words, &names)?;
    let bearing_step_rad =
        if step_rad > 0.0 { step_rad } else { fov_rad / n.saturating_sub(1).max(1) as f64 };
    if bearing_step_rad <= 0.0 {
        return Err(format!("angular resolution: found {step_rad}, expected a number > 0"));
    }
    Ok(LogScan {
        stamp_s,
        odometry_from_robot: Pose2::new(rx, ry, rt),
        world_from_robot: Pose2::new(lx, ly, lt),
        first_bearing_rad,
        bearing_step_rad,
        max_range_m: if max_range_m > 0.0 { max_range_m } else { f64::INFINITY },
        ranges_m,
    })
}

fn count(word: Option<&[u8]>, what: &str) -> std::result::Result<usize, String> {
    let word = word.ok_or_else(|| format!("found the end of the line, expected the number of {what}"))?;
    let n = integer(word).map_err(|m| format!("number of {what}: {m}"))?;
    usize::try_from(n).map_err(|_| format!("number of {what}: found {n}, expected 0 or more"))
}

/// The next `n` words as ranges; the caller has checked that there are as many.
fn ranges<'a>(words: &mut impl Iterator<Item = &'a [u8]>, n: usize) -> std::result::Result<Vec<f32>, String> {
    let mut ranges_m = Vec::with_capacity(n);
    for (k, word) in words.take(n).enumerate() {
        let range_m = number(word).map_err(|m| format!("range {k}: {m}"))?;
        if range_m < 0.0 || !(range_m as f32).is_finite() {
            return Err(format!("range {k}: found {range_m}, expected metres, 0 or more"));
        }
        ranges_m.push(range_m as f32);
    }
    Ok(ranges_m)
}

/// Where the laser sits: what the lines agree on, else the PARAM, else nothing.
fn laser_offset(scans: &[LogScan], param_m: Option<f64>, file: &str, warnings: &mut Vec<String>) -> Pose2 {
    let offsets: Vec<Pose2> =
        scans.iter().map(|s| s.odometry_from_robot.between(s.world_from_robot)).collect();
    // The median turn is taken about the first line's, so that a laser that looks back (±π) is no special case.
    let reference = offsets[0].theta_rad;
    let median = |value: &dyn Fn(&Pose2) -> f64| {
        let mut values: Vec<f64> = offsets.iter().map(value).collect();
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let middle = Pose2::new(
        median(&|o| o.x_m),
        median(&|o| o.y_m),
        reference + median(&|o| angle_diff(o.theta_rad, reference)),
    );
    let agrees = |o: &&Pose2| {
        (o.translation() - middle.translation()).norm() <= OFFSET_SPREAD_M
            && angle_diff(o.theta_rad, middle.theta_rad).abs() <= OFFSET_SPREAD_RAD
    };
    if offsets.iter().filter(agrees).count() as f64 >= OFFSET_AGREEING * offsets.len() as f64 {
        return middle;
    }
    if param_m.is_none() {
        warnings.push(format!(
            "{file}: laser and robot poses have no constant offset and there is no PARAM robot_frontlaser_offset: the laser is taken to sit at the robot's origin"
        ));
    }
    Pose2::new(param_m.unwrap_or(0.0), 0.0, 0.0)
}
