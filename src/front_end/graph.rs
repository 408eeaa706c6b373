//! The log's scans on the vertices and factors of another SLAM's graph.
//!
//! A vertex is the robot at one scan of the log: found by stamp where the vertices have stamps, else one to one in order
//! where there are as many of both. The other scans hang on the last vertex-scan before them, by odometry.

use super::{Skeleton, odometry_between, stamps};
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::{RawLog, ScanRecord, SlamMap, Trajectory};

pub(super) fn skeleton(
    log: &RawLog,
    graph: &SlamMap,
    stamps: Option<&Trajectory>,
    warnings: &mut Vec<String>,
) -> Result<Skeleton> {
    let scan_of_pose = scan_of_pose(log, graph, stamps)?;
    let Some(first) = scan_of_pose.iter().flatten().min().copied() else {
        let message =
            "found no vertex whose stamp is that of a scan, expected the graph of this log with its clock";
        return Err(Error::input("--graph", message));
    };
    let without = scan_of_pose.iter().filter(|s| s.is_none()).count();
    if without > 0 {
        let n = graph.poses.len();
        warnings
            .push(format!("--graph: {without} of {n} vertices match no scan of the log: they get no points"));
    }
    let mut pose_of_scan = vec![None; log.scans.len()];
    for (pose, scan) in scan_of_pose.iter().enumerate() {
        if let Some(scan) = *scan {
            pose_of_scan[scan] = Some(pose);
        }
    }
    // Scans before the first vertex hang on it too, backwards.
    let mut anchor = first;
    let mut scans = Vec::with_capacity(log.scans.len());
    for (index, scan) in log.scans.iter().enumerate() {
        if pose_of_scan[index].is_some() {
            anchor = index;
        }
        let parent_from_robot =
            if anchor == index { Pose2::IDENTITY } else { odometry_between(&log.scans[anchor], scan) };
        let parent = pose_of_scan[anchor].unwrap_or_default();
        scans.push(ScanRecord { stamp_s: scan.stamp_s, parent, parent_from_robot });
    }
    let own = stamps.map(|t| &t.stamps_s).or(graph.stamps_s.as_ref());
    let stamps_s = scan_of_pose.iter().enumerate().map(|(pose, scan)| match (scan, own) {
        (Some(scan), _) => log.scans[*scan].stamp_s,
        (None, own) => own.map_or(0.0, |s| s[pose]),
    });
    Ok(Skeleton {
        poses: graph.poses.clone(),
        stamps_s: stamps_s.collect(),
        vertex_ids: graph.vertex_ids.clone(),
        held: graph.held.clone(),
        relative_factors: graph.relative_factors.clone(),
        scan_of_pose,
        scans,
    })
}

fn scan_of_pose(log: &RawLog, graph: &SlamMap, stamps: Option<&Trajectory>) -> Result<Vec<Option<usize>>> {
    let (n, scans) = (graph.poses.len(), log.scans.len());
    if let Some(found) = stamps.map(|t| t.stamps_s.len()).filter(|&found| found != n) {
        let message = format!("found {found} stamps, expected one for each of the {n} vertices");
        return Err(Error::input("--graph", message));
    }
    match stamps.map(|t| &t.stamps_s).or(graph.stamps_s.as_ref()) {
        Some(wanted_s) => {
            let log_s: Vec<f64> = log.scans.iter().map(|s| s.stamp_s).collect();
            Ok(stamps::scans_at(wanted_s, &log_s))
        }
        None if n == scans => Ok((0..n).map(Some).collect()),
        None => {
            let message = format!(
                "found {n} vertices without stamps for {scans} scans, expected ROBOTLASER1 lines after the vertices, \
                 a TUM file with a line per vertex, or as many vertices as scans"
            );
            Err(Error::input("--graph", message))
        }
    }
}
