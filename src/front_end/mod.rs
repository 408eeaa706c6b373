//! From a raw log to a map: a chain of poses, relative factors between them, and what the laser saw from each.
//!
//! [`Chain`] says where the poses come from. Every scan of the log gets a [`ScanRecord`]: the pose it hangs on and its
//! offset from it, so that all scans move with the map. Poses are of the robot frame; the laser's place on the robot is
//! applied to the points. No loop closure here; [`rematch`] is for afterwards.

mod chain;
mod graph;
mod initial;
mod noise;
mod options;
mod points;
mod rematch;
mod scan_match;
mod stamps;
mod walks;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::io::{self, Source};
use crate::map::{LogScan, Observations, RawLog, RelativeFactor, ScanRecord, SlamMap, Trajectory};
pub use noise::OdometryNoise;
pub use options::Options;
pub use points::observe;
pub use rematch::{Visits, rematch};
pub use walks::{WalkOptions, map_of_walks};

/// Where the pose chain comes from.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Chain<'a> {
    /// The wheels: `LogScan::odometry_from_robot`.
    Odometry,
    /// Every scan matched to a local map of the ones before it, with the wheels as prior.
    ScanMatch {
        /// Told the number of scans done, for a progress bar.
        progress: &'a (dyn Fn(usize) + Sync),
    },
    /// The poses that the log gives for its scans, as they stand: `LogScan::world_from_robot`.
    LoggedPoses,
    /// Poses and factors, closures too, of another SLAM's graph.
    Graph {
        /// The graph. Its points, if any, are not used.
        graph: &'a SlamMap,
        /// The time of each vertex, in their order, where the graph itself has none.
        stamps: Option<&'a Trajectory>,
    },
    /// Another SLAM's trajectory, matched to the scans by stamp.
    Initial(&'a Trajectory),
}

/// Builds the map. The second value holds remarks for a person.
///
/// # Errors
/// [`Error::Input`] if an option is out of range, the log has no scan, or graph or trajectory do not fit the log.
pub fn build(log: &RawLog, chain: Chain<'_>, options: &Options) -> Result<(SlamMap, Vec<String>)> {
    options.validate()?;
    if log.scans.is_empty() {
        return Err(Error::input("log", "found no scan, expected at least one"));
    }
    let mut warnings = Vec::new();
    let skeleton = match chain {
        Chain::Odometry => chain::by_motion(log, |s| s.odometry_from_robot, options),
        Chain::ScanMatch { progress } => {
            let never = AtomicBool::new(false);
            let matched = scan_matched(log, options, progress, &never)?;
            return matched
                .map(|map| (map, warnings))
                .ok_or_else(|| Error::Internal("scan matching was cancelled by nobody".into()));
        }
        Chain::LoggedPoses => chain::by_motion(log, |s| s.world_from_robot, options),
        Chain::Graph { graph, stamps } => graph::skeleton(log, graph, stamps, &mut warnings)?,
        Chain::Initial(trajectory) => initial::skeleton(log, trajectory, options, &mut warnings)?,
    };
    let map = skeleton.with_points(log, options);
    map.validate("log")?;
    Ok((map, warnings))
}

/// The map of [`Chain::ScanMatch`]; `progress` is told the number of scans done, of a second look a second time. `None` if
/// `cancelled` becomes true on the way.
///
/// # Errors
/// As [`build`].
pub fn scan_matched(
    log: &RawLog,
    options: &Options,
    progress: &(dyn Fn(usize) + Sync),
    cancelled: &AtomicBool,
) -> Result<Option<SlamMap>> {
    options.validate()?;
    if log.scans.is_empty() {
        return Err(Error::input("log", "found no scan, expected at least one"));
    }
    let Some(skeleton) = scan_match::skeleton(log, options, progress, cancelled) else { return Ok(None) };
    let mut map = skeleton.with_points(log, options);
    if options.second_look
        && !rematch::rematch_until(&mut map, log, Visits::Own, options, progress, cancelled)?
    {
        return Ok(None);
    }
    map.validate("log")?;
    Ok(Some(map))
}

/// Any input file as a map: as it is, or from a raw log by its odometry, from a walk by its steps; a trajectory is a map without factors and points.
///
/// # Errors
/// As [`io::read_with`] and [`build`].
pub fn open(path: &Path, indefinite: io::Indefinite) -> Result<io::Read<SlamMap>> {
    let (_, io::Read { value, mut warnings }) = io::read_with(path, indefinite)?;
    let map = match value {
        Source::Map(map) => map,
        Source::Trajectory(trajectory) => SlamMap {
            observations: Observations::empty(trajectory.poses.len()),
            stamps_s: Some(trajectory.stamps_s),
            poses: trajectory.poses,
            ..SlamMap::default()
        },
        Source::Walks { walks, starts } => map_of_walks(&walks, &WalkOptions::starting(&starts))?,
        Source::Log(log) => {
            let (map, more) = build(&log, Chain::Odometry, &Options::default())?;
            warnings.extend(more);
            map
        }
    };
    Ok(io::Read { value: map, warnings })
}

/// A map without points, and which scan was made at which pose.
struct Skeleton {
    poses: Vec<Pose2>,
    stamps_s: Vec<f64>,
    /// The scan made at each pose; a vertex of a foreign graph may have none.
    scan_of_pose: Vec<Option<usize>>,
    vertex_ids: Option<Vec<i64>>,
    held: Vec<usize>,
    relative_factors: Vec<RelativeFactor>,
    scans: Vec<ScanRecord>,
}

impl Skeleton {
    fn with_points(self, log: &RawLog, options: &Options) -> SlamMap {
        let mut observations = Observations { starts: vec![0], ..Observations::default() };
        for scan in &self.scan_of_pose {
            if let Some(scan) = scan {
                observe(&log.scans[*scan], log.robot_from_laser, options, &mut observations);
            }
            observations.end_pose();
        }
        SlamMap {
            poses: self.poses,
            stamps_s: Some(self.stamps_s),
            vertex_ids: self.vertex_ids,
            held: self.held,
            relative_factors: self.relative_factors,
            observations,
            scans: self.scans,
            human_factors: Vec::new(),
            automatic_factors: Vec::new(),
            robot_from_laser: log.robot_from_laser,
        }
    }
}

/// `scan` as seen from an earlier scan, by odometry.
fn odometry_between(from: &LogScan, scan: &LogScan) -> Pose2 {
    from.odometry_from_robot.between(scan.odometry_from_robot)
}
