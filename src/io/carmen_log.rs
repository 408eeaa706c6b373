//! Writing CARMEN logs. Corrected ones: the laser's pose is the map's, the robot's pose stays the odometry's.
//!
//! From a raw log and a corrected trajectory ([`corrected`]) every range stays what it was. From a map alone
//! ([`of_map`]) the beams are put together from the returns, and the odometry is the chain of the map's own
//! relative factors, as far as it goes. Lines are FLASER where the beams fill the half circle that FLASER means, else
//! ROBOTLASER1. Beams without a return read [`NO_RETURN_M`]; a PARAM says so.

use std::f64::consts::{FRAC_PI_2, PI};
use std::io::{self, Write};
use std::path::Path;

use super::atomic;
use super::text::Shortest;
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::{LogScan, NO_RETURN_M, RawLog, SlamMap, Trajectory};

/// Readings at or beyond this are no return, metres.
const MAX_RANGE_M: f64 = 80.0;
/// Beams that a half circle may have; the first that fits is taken.
const BEAMS: [usize; 5] = [181, 361, 541, 721, 1441];
/// A return fits a beam if it is this close to it, in beam spacings.
const FITS: f64 = 0.1;

/// A log with every scan where the trajectory says; scans that it does not have (by stamp, exactly) are left out.
///
/// # Errors
/// [`Error::Input`] if no scan has a pose.
pub fn corrected(log: &RawLog, trajectory: &Trajectory) -> Result<RawLog> {
    let order = trajectory.order_by_stamp();
    let mut used = vec![false; order.len()];
    let pose_at = |stamp_s: f64, used: &mut Vec<bool>| {
        let from = order.partition_point(|&i| trajectory.stamps_s[i] < stamp_s);
        let same = (from..order.len()).take_while(|&k| trajectory.stamps_s[order[k]] == stamp_s);
        // Scans of one stamp take the poses of that stamp in turn.
        let free = same.into_iter().find(|&k| !used[k])?;
        used[free] = true;
        Some(trajectory.poses[order[free]])
    };
    let scans: Vec<LogScan> = log
        .scans
        .iter()
        .filter_map(|s| Some(LogScan { world_from_robot: pose_at(s.stamp_s, &mut used)?, ..s.clone() }))
        .collect();
    if scans.is_empty() {
        return Err(Error::input("log", "found no scan with a stamp of the map, expected the map's own log"));
    }
    Ok(RawLog { scans, ..log.clone() })
}

/// A log made from a map: one scan per pose.
pub fn of_map(map: &SlamMap) -> RawLog {
    let laser_from_robot = map.robot_from_laser.inverse();
    let polar = |k: usize| {
        let p = laser_from_robot.transform_point(map.observations.point(k));
        (p.y.atan2(p.x), p.norm())
    };
    let is_half = (0..map.observations.len()).all(|k| polar(k).0.abs() <= FRAC_PI_2 + 1e-3);
    let span = if is_half { PI } else { 2.0 * PI };
    let fits = |beams: usize| {
        let step = span / (beams - 1) as f64;
        let near = |k: &usize| {
            let at = (polar(*k).0 + span / 2.0) / step;
            (at - at.round()).abs() <= FITS
        };
        (0..map.observations.len()).filter(near).count() as f64 >= 0.99 * map.observations.len() as f64
    };
    let beams = BEAMS.map(|n| if is_half { n } else { 2 * n - 1 });
    let beams = beams.into_iter().find(|&n| fits(n)).unwrap_or(beams[BEAMS.len() - 1]);
    let step = span / (beams - 1) as f64;
    let odometry = odometry(map);
    let scan = |i: usize| {
        let mut ranges_m = vec![NO_RETURN_M; beams];
        for k in map.observations.range(i) {
            let (bearing, range) = polar(k);
            let beam = ((bearing + span / 2.0) / step).round().max(0.0) as usize;
            let slot = &mut ranges_m[beam.min(beams - 1)];
            *slot = slot.min(range as f32);
        }
        LogScan {
            stamp_s: map.stamps_s.as_ref().map_or(i as f64, |s| s[i]),
            odometry_from_robot: odometry[i],
            world_from_robot: map.poses[i],
            first_bearing_rad: -span / 2.0,
            bearing_step_rad: step,
            max_range_m: MAX_RANGE_M,
            ranges_m,
        }
    };
    RawLog { scans: (0..map.poses.len()).map(scan).collect(), robot_from_laser: map.robot_from_laser }
}

/// The chain of the relative factors between neighbours, from the first pose on; where one is missing, the map's own step.
fn odometry(map: &SlamMap) -> Vec<Pose2> {
    let mut steps = vec![None; map.poses.len()];
    for factor in map.relative_factors.iter().filter(|f| f.j == f.i + 1) {
        steps[factor.j].get_or_insert(factor.i_from_j);
    }
    let mut chain: Vec<Pose2> = map.poses.first().copied().into_iter().collect();
    for j in 1..map.poses.len() {
        let step = steps[j].unwrap_or_else(|| map.poses[j - 1].between(map.poses[j]));
        chain.push(chain[j - 1].compose(step));
    }
    chain
}

/// Writes a log.
///
/// # Errors
/// [`Error::Io`] if the file cannot be written.
pub fn write(path: &Path, log: &RawLog) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "# CARMEN log written by hitl-slam; robot poses are the odometry")?;
        writeln!(out, "PARAM robot_frontlaser_offset {}", Shortest(log.robot_from_laser.x_m))?;
        let max_range_m = log.scans.iter().map(|s| s.max_range_m).fold(f64::INFINITY, f64::min);
        if max_range_m.is_finite() {
            writeln!(out, "PARAM laser_max_range {}", Shortest(max_range_m))?;
        }
        log.scans.iter().try_for_each(|scan| line(out, scan, log.robot_from_laser))
    })
}

fn line(out: &mut dyn Write, scan: &LogScan, robot_from_laser: Pose2) -> io::Result<()> {
    let n = scan.ranges_m.len();
    let span = scan.bearing_step_rad * n.saturating_sub(1) as f64;
    let steps = if n % 2 == 1 { n.saturating_sub(1) } else { n };
    let is_half = (scan.first_bearing_rad + FRAC_PI_2).abs() < 1e-6
        && (scan.bearing_step_rad - PI / steps.max(1) as f64).abs() < 1e-9;
    if is_half {
        write!(out, "FLASER {n}")?;
    } else {
        let [first, span, step] = [scan.first_bearing_rad, span, scan.bearing_step_rad].map(Shortest);
        let max_range = if scan.max_range_m.is_finite() { scan.max_range_m } else { MAX_RANGE_M };
        write!(out, "ROBOTLASER1 0 {first} {span} {step} {} 0.01 0 {n}", Shortest(max_range))?;
    }
    for range in &scan.ranges_m {
        write!(out, " {range}")?;
    }
    let laser = scan.world_from_robot.compose(robot_from_laser).to_array();
    if !is_half {
        write!(out, " 0")?;
    }
    for value in laser.into_iter().chain(scan.odometry_from_robot.to_array()) {
        write!(out, " {}", Shortest(value))?;
    }
    if !is_half {
        write!(out, " 0 0 0 0 0")?;
    }
    let stamp = Shortest(scan.stamp_s);
    writeln!(out, " {stamp} hitl {stamp}")
}
