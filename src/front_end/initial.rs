//! The log's scans on another SLAM's trajectory.
//!
//! Scans that a line of the trajectory matches by stamp have its pose; keyframes are chosen among them by motion. The
//! others get theirs from the last matched scan before them, by odometry.

use super::{Options, Skeleton, chain, odometry_between, stamps};
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::{RawLog, ScanRecord, Trajectory};

pub(super) fn skeleton(
    log: &RawLog,
    trajectory: &Trajectory,
    options: &Options,
    warnings: &mut Vec<String>,
) -> Result<Skeleton> {
    let log_s: Vec<f64> = log.scans.iter().map(|s| s.stamp_s).collect();
    let mut given: Vec<Option<Pose2>> = vec![None; log.scans.len()];
    let mut unmatched = 0;
    for (line, scan) in stamps::scans_at(&trajectory.stamps_s, &log_s).into_iter().enumerate() {
        match scan {
            Some(scan) => given[scan] = Some(trajectory.poses[line]),
            None => unmatched += 1,
        }
    }
    let matched: Vec<(usize, Pose2)> =
        given.iter().enumerate().filter_map(|(scan, pose)| pose.map(|p| (scan, p))).collect();
    let Some(&first) = matched.first() else {
        let tolerance_s = stamps::tolerance_s(&log_s);
        let message = format!(
            "found no stamp within {tolerance_s} s of a scan, expected a trajectory of this log with its clock"
        );
        return Err(Error::input("--initial", message));
    };
    if unmatched > 0 {
        let n = trajectory.poses.len();
        warnings.push(format!("--initial: {unmatched} of {n} lines match no scan of the log: skipped"));
    }
    let keyframes = chain::keyframes(&matched, options);
    let mut skeleton = chain::skeleton_of(log, &keyframes, options);
    let mut parent = 0;
    // The matched scan that odometry is counted from; before the first one, backwards from it.
    let mut anchor = first;
    for (index, scan) in log.scans.iter().enumerate() {
        if keyframes.get(parent + 1).is_some_and(|&(keyframe, _)| keyframe == index) {
            parent += 1;
        }
        if let Some(pose) = given[index] {
            anchor = (index, pose);
        }
        let world_from_robot = match given[index] {
            Some(pose) => pose,
            None => anchor.1.compose(odometry_between(&log.scans[anchor.0], scan)),
        };
        let parent_from_robot = keyframes[parent].1.between(world_from_robot);
        skeleton.scans.push(ScanRecord { stamp_s: scan.stamp_s, parent, parent_from_robot });
    }
    Ok(skeleton)
}
