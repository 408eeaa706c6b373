//! A second look: every scan between two poses is matched again, to the walls around it as later poses saw them too.
//!
//! The chain matched a scan to what had been seen before it; the pose after it, and once the loops are closed the other
//! visits, know more.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::Options;
use super::scan_match::cloud;
use crate::error::{Error, Result};
use crate::geometry::{Information, Pose2};
use crate::map::{RawLog, RelativeFactor, ScanRecord, SlamMap};
use crate::scan_match::{Prior, Schedule, Surfel, SurfelMap, align, reach_m};

/// Poses whose walls count: the nearest, a radian counting as half a metre, …
const MOST_POSES: usize = 25;
/// … within this, metres.
const REACH_M: f64 = 2.5;
/// Points further from the pose are left out, metres.
const RADIUS_M: f64 = 25.0;
/// How well the scan's place is known beforehand: σ, metres and radians.
const START_SIGMA: (f64, f64) = (0.02, 0.01);
const SCHEDULE: Schedule = Schedule { coarse_m: 0.3, fine_m: 0.15, rounds: 8 };

/// Whose walls a scan is matched to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Visits {
    /// Those seen from the chain around it: right on a map whose loops are open.
    Own,
    /// Those of every visit: right once the loops are closed.
    All,
}

/// Path from the pose up to which a visit is the scan's own, metres.
const OWN_VISIT_M: f64 = 5.0;

/// Matches every scan of the log that is not itself a pose to the map; only the scans' offsets from their poses change.
/// `progress` is told the number of scans done.
///
/// # Errors
/// [`Error::Input`] if the log is not the one that the map was made from.
pub fn rematch(
    map: &mut SlamMap,
    log: &RawLog,
    visits: Visits,
    options: &Options,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<()> {
    rematch_until(map, log, visits, options, progress, &AtomicBool::new(false)).map(|_| ())
}

/// The same; false, and the map as it was, if `cancelled` becomes true on the way.
pub(super) fn rematch_until(
    map: &mut SlamMap,
    log: &RawLog,
    visits: Visits,
    options: &Options,
    progress: &(dyn Fn(usize) + Sync),
    cancelled: &AtomicBool,
) -> Result<bool> {
    let is_same = map.scans.len() == log.scans.len()
        && map.scans.iter().zip(&log.scans).all(|(a, b)| a.stamp_s == b.stamp_s);
    if !is_same {
        let message = format!(
            "found {} scans, expected the log that the map was made from, of {} scans",
            log.scans.len(),
            map.scans.len()
        );
        return Err(Error::input("log", message));
    }
    let done = AtomicUsize::new(0);
    let (steps, path_m) = (steps(map), map.path_lengths_m());
    let is_open =
        |parent: usize, k: usize| visits == Visits::All || (path_m[k] - path_m[parent]).abs() < OWN_VISIT_M;
    let mut indices: Vec<usize> = (0..map.scans.len()).collect();
    indices.sort_by_key(|&s| map.scans[s].parent);
    let groups: Vec<&[usize]> =
        indices.chunk_by(|&a, &b| map.scans[a].parent == map.scans[b].parent).collect();
    let matched: Vec<Vec<(usize, Pose2)>> = groups
        .par_iter()
        .map(|group| {
            let parent = map.scans[group[0]].parent;
            let between: Vec<usize> = group.iter().copied().filter(|&s| is_between(&map.scans[s])).collect();
            let mut offsets = Vec::with_capacity(between.len());
            if !between.is_empty() && !cancelled.load(Ordering::Relaxed) {
                let walls = walls(map, parent, |k| is_open(parent, k));
                offsets.extend(between.iter().map(|&s| {
                    let start = start(map, &steps, &map.scans[s]);
                    let (m, rad) = START_SIGMA;
                    let information = Information::from_sigmas(m, m, rad).matrix();
                    let prior = Prior { pose: start, information };
                    (s, align(&walls, &cloud(log, s, options), start, Some(&prior), SCHEDULE).pose)
                }));
            }
            progress(done.fetch_add(group.len(), Ordering::Relaxed) + group.len());
            offsets
        })
        .collect();
    if cancelled.load(Ordering::Relaxed) {
        return Ok(false);
    }
    for (scan, offset) in matched.into_iter().flatten() {
        map.scans[scan].parent_from_robot = offset;
    }
    Ok(true)
}

/// True if the scan is not the one that its pose was made at.
fn is_between(scan: &ScanRecord) -> bool {
    scan.parent_from_robot != Pose2::IDENTITY
}

/// The measured step from each pose to the next, where there is one.
fn steps(map: &SlamMap) -> Vec<Option<Pose2>> {
    let mut steps = vec![None; map.poses.len()];
    for RelativeFactor { i, j, i_from_j, .. } in &map.relative_factors {
        if *j == i + 1 {
            steps[*i] = Some(*i_from_j);
        }
    }
    steps
}

/// Where a scan is, seen from its pose, as that pose and the next say: each the more the nearer it is.
fn start(map: &SlamMap, steps: &[Option<Pose2>], scan: &ScanRecord) -> Pose2 {
    let (k, from_this) = (scan.parent, scan.parent_from_robot);
    let Some(step) = steps[k] else { return from_this };
    let from_next = step.between(from_this);
    let by_next = map.poses[k].between(map.poses[k + 1]).compose(from_next);
    let (behind, ahead) = (reach_m(Pose2::IDENTITY, from_this), reach_m(Pose2::IDENTITY, from_next));
    from_this.interpolate(by_next, behind / (behind + ahead).max(1e-9))
}

/// The walls around a pose as the poses near it saw them that are `open`, in its frame.
fn walls(map: &SlamMap, pose: usize, is_open: impl Fn(usize) -> bool) -> SurfelMap {
    let here = map.poses[pose];
    let reach = |k: usize| reach_m(here, map.poses[k]);
    let mut near: Vec<(f64, usize)> = (0..map.poses.len())
        .filter(|&k| is_open(k))
        .map(|k| (reach(k), k))
        .filter(|r| r.0 < REACH_M)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(MOST_POSES);
    let mut points = Vec::new();
    for (_, k) in near {
        let here_from_k = here.between(map.poses[k]);
        points.extend(map.observations.oriented(k).filter_map(|(point, normal)| {
            let mean = here_from_k.transform_point(point);
            let is_near = mean.norm_squared() < RADIUS_M * RADIUS_M;
            is_near.then(|| Surfel { mean, normal: here_from_k.rotate(normal) })
        }));
    }
    SurfelMap::new(points)
}
