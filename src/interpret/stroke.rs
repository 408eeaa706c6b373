//! Where a stroke lies in the world, whichever frame it was given in.

use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2};
use crate::map::{Correction, SlamMap, Stroke};

/// Checks that every stroke of every correction can be placed on the map.
///
/// # Errors
/// [`Error::Input`] at `corrections: id` for a pose or stamp out of range.
pub fn check(map: &SlamMap, corrections: &[Correction]) -> Result<()> {
    for correction in corrections {
        for (name, stroke) in [("a", &correction.a), ("b", &correction.b)] {
            let place = format!("correction {}: {name}", correction.id);
            match *stroke {
                Stroke::World(_) => {}
                Stroke::Pose { pose, .. } if pose < map.poses.len() => {}
                Stroke::Pose { pose, .. } => {
                    let message = format!("found pose {pose}, expected one below {}", map.poses.len());
                    return Err(Error::input(place, message));
                }
                Stroke::Stamp { stamp_s, .. } => {
                    pose_at(map, &map.poses, stamp_s).map_err(|message| Error::input(place, message))?;
                }
            }
        }
    }
    Ok(())
}

/// The pose that a stroke was drawn from, or the last one at or before its stamp; `None` for a stroke in the world.
pub fn anchor(map: &SlamMap, stroke: &Stroke) -> Option<usize> {
    match *stroke {
        Stroke::World(_) => None,
        Stroke::Pose { pose, .. } => Some(pose),
        Stroke::Stamp { stamp_s, .. } => {
            let stamps = map.stamps_s.as_ref()?;
            let before = (0..stamps.len()).filter(|&k| stamps[k] <= stamp_s);
            before.max_by(|&i, &j| stamps[i].total_cmp(&stamps[j]))
        }
    }
}

/// The ends of a stroke in the world of `poses`.
///
/// # Errors
/// [`Error::Input`] as [`check`].
pub fn in_world(map: &SlamMap, poses: &[Pose2], stroke: &Stroke) -> Result<[Vec2; 2]> {
    let (world_from_robot, points) = match *stroke {
        Stroke::World(points) => return Ok(points),
        Stroke::Pose { pose, points } => match poses.get(pose) {
            Some(&p) => (p, points),
            None => {
                return Err(Error::input(
                    "stroke",
                    format!("found pose {pose}, expected one below {}", poses.len()),
                ));
            }
        },
        Stroke::Stamp { stamp_s, points } => {
            (pose_at(map, poses, stamp_s).map_err(|message| Error::input("stroke", message))?, points)
        }
    };
    Ok(points.map(|p| world_from_robot.transform_point(p)))
}

/// The robot at a stamp: that scan's pose if there is one, else between its neighbours in time.
fn pose_at(map: &SlamMap, poses: &[Pose2], stamp_s: f64) -> std::result::Result<Pose2, String> {
    if map.scans.is_empty() && map.stamps_s.is_none() {
        return Err("found a stamp, but the map has none; expected a pose index".into());
    }
    let stamps: Vec<f64> = match &map.stamps_s {
        _ if !map.scans.is_empty() => map.scans.iter().map(|s| s.stamp_s).collect(),
        Some(stamps) => stamps.clone(),
        None => Vec::new(),
    };
    let pose_of = |k: usize| match map.scans.get(k) {
        Some(scan) => poses[scan.parent].compose(scan.parent_from_robot),
        None => poses[k],
    };
    // Stamps need not increase: the neighbours are the nearest in time on either side.
    let before = (0..stamps.len())
        .filter(|&k| stamps[k] <= stamp_s)
        .max_by(|&i, &j| stamps[i].total_cmp(&stamps[j]).then(j.cmp(&i)));
    let after =
        (0..stamps.len()).filter(|&k| stamps[k] >= stamp_s).min_by(|&i, &j| stamps[i].total_cmp(&stamps[j]));
    match (before, after) {
        (Some(i), Some(j)) if stamps[i] < stamps[j] => {
            let share = (stamp_s - stamps[i]) / (stamps[j] - stamps[i]);
            Ok(pose_of(i).interpolate(pose_of(j), share))
        }
        (Some(i), Some(_)) => Ok(pose_of(i)),
        _ => {
            let (first, last) =
                stamps.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &s| (a.min(s), b.max(s)));
            Err(format!("found stamp {stamp_s}, expected one of the log's, {first} to {last}"))
        }
    }
}
