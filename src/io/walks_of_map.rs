//! The walks that a map was made of, or a robot's trajectory as a walk.

use std::path::{Path, PathBuf};

use super::walk;
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::SlamMap;
use crate::pedestrian::{Step, Walk};

/// Nearer scans are one step, metres.
const SHORTEST_STEP_M: f64 = 0.3;
/// A larger turn is a step, radians.
const LARGEST_TURN_RAD: f64 = 0.5;
/// Longer gaps are walked in several steps, metres.
const GAP_M: f64 = 2.0;

/// Where walks go if they are written under `path`: `x.csv`, or `x-1.csv`, `x-2.csv`, … where there are several; or the
/// names that are given, in the folder of `path`.
fn places(path: &Path, names: &[String], count: usize) -> Result<Vec<PathBuf>> {
    if !names.is_empty() {
        if names.len() != count {
            let message = format!("found {} names, expected {count}: one for each walk", names.len());
            return Err(Error::input("walkers", message));
        }
        for (k, name) in names.iter().enumerate() {
            let message = if name.trim().is_empty() || name.contains(['/', '\\', '\0']) {
                format!("found the name {name:?}, expected one that a file can have: not empty, no slash")
            } else if names[..k].contains(name) {
                format!("found the name {name:?} twice, expected one for each walk")
            } else {
                continue;
            };
            return Err(Error::input("walkers", message));
        }
        return Ok(names.iter().map(|name| path.with_file_name(format!("{name}.csv"))).collect());
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(match count {
        1 => vec![path.to_path_buf()],
        _ => (1..=count).map(|k| path.with_file_name(format!("{stem}-{k}.csv"))).collect(),
    })
}

/// A walk that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Where.
    pub path: PathBuf,
    /// Where the walk begins.
    pub start: Pose2,
    /// Its steps.
    pub steps: usize,
}

/// Writes every walk of a map.
///
/// # Errors
/// [`Error::Input`] as [`walks`], or if the number of names is not that of the walks; [`Error::Io`].
pub fn write(path: &Path, map: &SlamMap, names: &[String]) -> Result<Vec<Written>> {
    let found = walks(map)?;
    let places = places(path, names, found.len())?;
    places.iter().try_for_each(|p| super::atomic::check(p))?;
    let write = |(path, (walk, start)): (PathBuf, (Walk, Pose2))| {
        walk::write(&path, &walk)?;
        Ok(Written { path, start, steps: walk.steps.len() })
    };
    places.into_iter().zip(found).map(write).collect()
}

/// The walks of a map, or a robot's trajectory as a walk: one per piece of the chain, neighbours without a factor between
/// them being the ends of two pieces. A step is taken where the walker has moved by 0.3 m or turned
/// by 0.5 rad; what is not later than the step before it is passed over. Also says where each begins.
///
/// # Errors
/// [`Error::Input`] if nobody moves.
pub fn walks(map: &SlamMap) -> Result<Vec<(Walk, Pose2)>> {
    let trajectory = map.trajectory();
    let walk = |(number, piece): (usize, Vec<usize>)| {
        let track: Vec<(f64, Pose2)> =
            piece.iter().map(|&k| (trajectory.stamps_s[k], trajectory.poses[k])).collect();
        walk_along(format!("walk {}", number + 1), &track)
    };
    pieces(map).into_iter().enumerate().map(walk).collect()
}

/// The first pose of every piece of the chain, ascending.
pub fn first_poses(map: &SlamMap) -> Vec<usize> {
    // A trajectory without factors is one walk.
    let mut joined = vec![map.relative_factors.is_empty(); map.poses.len()];
    for f in map.every_relative_factor().filter(|f| f.i.abs_diff(f.j) == 1) {
        joined[f.i.max(f.j)] = true;
    }
    (0..joined.len()).filter(|&pose| pose == 0 || !joined[pose]).collect()
}

/// The pieces of the chain, each as indices into [`SlamMap::trajectory`], in order.
pub fn pieces(map: &SlamMap) -> Vec<Vec<usize>> {
    let firsts = first_poses(map);
    let mut piece_of_pose = Vec::with_capacity(map.poses.len());
    for pose in 0..map.poses.len() {
        piece_of_pose.push(firsts.partition_point(|&first| first <= pose) - 1);
    }
    let mut pieces = vec![Vec::new(); firsts.len().max(1)];
    if map.scans.is_empty() {
        (0..map.poses.len()).for_each(|pose| pieces[piece_of_pose[pose]].push(pose));
    } else {
        map.scans.iter().enumerate().for_each(|(k, s)| pieces[piece_of_pose[s.parent]].push(k));
    }
    pieces
}

fn walk_along(name: String, track: &[(f64, Pose2)]) -> Result<(Walk, Pose2)> {
    let Some(&(mut then_s, start)) = track.first() else {
        return Err(Error::input(&name, "found no pose, expected at least two"));
    };
    let (mut here, mut steps) = (start, Vec::new());
    for (k, &(stamp_s, pose)) in track.iter().enumerate().skip(1) {
        let moved = here.between(pose);
        let length_m = moved.translation().norm();
        let is_step = length_m >= SHORTEST_STEP_M || moved.theta_rad.abs() >= LARGEST_TURN_RAD;
        if stamp_s <= then_s || !(is_step || k + 1 == track.len()) {
            continue;
        }
        let parts = (length_m / GAP_M).ceil().max(1.0);
        for part in 1..=parts as usize {
            let last = part == parts as usize;
            steps.push(Step {
                time_s: if last { stamp_s } else { then_s + (stamp_s - then_s) * part as f64 / parts },
                forward_m: moved.x_m / parts,
                left_m: moved.y_m / parts,
                turn_rad: if last { moved.theta_rad } else { 0.0 },
            });
        }
        (here, then_s) = (pose, stamp_s);
    }
    if steps.is_empty() {
        return Err(Error::input(&name, "found nobody who moves, expected at least one step"));
    }
    Ok((Walk { name, steps }, start))
}
