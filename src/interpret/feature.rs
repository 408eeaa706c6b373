//! From a fitted stroke to a feature: S, X and the references that keep it in place.

use std::cmp::Reverse;
use std::ops::{RangeBounds, RangeInclusive};

use super::Options;
use super::em::{self, Candidate, Fit, REACH_SIGMAS};
use crate::geometry::{Pose2, Segment, Vec2, angle_diff};
use crate::map::{Feature, Observations, Sighting};

/// Sightings at most this many poses apart belong to one visit.
pub(super) const VISIT_GAP: usize = 20;
/// A visit counts if it saw at least this share of what the best visit saw.
const VISIT_SHARE: f64 = 0.1;

/// How far each pose sees, metres: lets a stroke skip poses that cannot have points near it.
#[derive(Debug, Clone)]
pub struct Reach {
    reach_m: Vec<f64>,
    min_points: usize,
}

impl Reach {
    /// Measures a map's observations once.
    pub fn new(observations: &Observations) -> Self {
        let poses = observations.starts.len().saturating_sub(1);
        let furthest = |pose: usize| {
            observations
                .range(pose)
                .map(|p| observations.point(p).norm_squared())
                .fold(0.0_f64, f64::max)
                .sqrt()
        };
        let mut counts: Vec<usize> =
            (0..poses).map(|p| observations.range(p).len()).filter(|&count| count > 0).collect();
        counts.sort_unstable();
        let median = counts.get(counts.len() / 2).copied().unwrap_or(0);
        Reach { reach_m: (0..poses).map(furthest).collect(), min_points: default_min_points(median) }
    }

    /// T_p that follows from the scans' density.
    pub fn min_points(&self) -> usize {
        self.min_points
    }
}

/// T_p: the paper's 6 at about one return each half degree (360 a scan), in proportion, between 3 and 12.
fn default_min_points(median_points_per_pose: usize) -> usize {
    ((6 * median_points_per_pose + 180) / 360).clamp(3, 12)
}

/// What a stroke caught.
#[derive(Debug, Clone, PartialEq)]
pub struct Caught {
    /// The wall it was snapped to.
    pub fit: Fit,
    /// S: observation indices, ascending.
    pub points: Vec<u32>,
    /// X with the number of points of S that each pose saw, ascending.
    pub poses: Vec<(usize, usize)>,
}

/// Reads one stroke given by its ends in the world frame.
///
/// # Errors
/// The reason, for a person, why the stroke catches nothing.
pub fn catch(
    observations: &Observations,
    poses: &[Pose2],
    reach: &Reach,
    ends: [Vec2; 2],
    options: &Options,
) -> Result<Caught, String> {
    let drawn = Segment::from_ends(ends[0], ends[1]);
    let sigma_m = options.drawing_sigma_m;
    if 2.0 * drawn.half_length_m <= sigma_m {
        return Err(format!("it is shorter than the drawing accuracy of {sigma_m} m"));
    }
    let min_points = options.min_points.unwrap_or(reach.min_points);
    let candidates = candidates(observations, poses, reach, &drawn, REACH_SIGMAS * options.drawing_sigma_m);
    let Some(fit) = em::fit(&drawn, &candidates, options) else {
        return Err(format!("no wall within {:.2} m of it", 3.0 * sigma_m));
    };
    let selected: Vec<&Candidate> = em::select(&fit.segment, &candidates, options.drawing_sigma_m).collect();
    let sightings: Vec<&[&Candidate]> =
        selected.chunk_by(|a, b| a.pose == b.pose).filter(|seen| seen.len() >= min_points).collect();
    let mut points = Vec::new();
    let mut seen_from = Vec::new();
    for seen in supported_visits(&sightings).into_iter().flatten() {
        seen_from.push((seen[0].pose, seen.len()));
        points.extend(seen.iter().map(|c| c.index));
    }
    if points.is_empty() {
        let message =
            format!("too few points: {} caught, none of its poses saw {min_points} of them", selected.len());
        return Err(message);
    }
    Ok(Caught { fit, points, poses: seen_from })
}

/// The visits (runs of poses) that saw a fair share of what the best of them saw. A visit that merely grazes the
/// stroke saw some other wall that happens to cross it on the bent map: a handful of such points is enough to tie
/// two places of a campus together that have nothing to do with each other.
fn supported_visits<'a>(sightings: &'a [&'a [&'a Candidate]]) -> Vec<&'a [&'a [&'a Candidate]]> {
    let visits: Vec<_> = sightings.chunk_by(|a, b| b[0].pose - a[0].pose <= VISIT_GAP).collect();
    let support = |visit: &[&[&Candidate]]| visit.iter().map(|seen| seen.len()).sum::<usize>();
    let best = visits.iter().map(|v| support(v)).max().unwrap_or(0);
    visits.into_iter().filter(|v| support(v) as f64 >= VISIT_SHARE * best as f64).collect()
}

/// Points within `margin_m` of the stroke's box, in the order of the map.
fn candidates(
    observations: &Observations,
    poses: &[Pose2],
    reach: &Reach,
    drawn: &Segment,
    margin_m: f64,
) -> Vec<Candidate> {
    let mut found = Vec::new();
    for (pose, &world_from_robot) in poses.iter().enumerate() {
        let to_centre = (drawn.centre - world_from_robot.translation()).norm();
        if to_centre > reach.reach_m[pose] + drawn.half_length_m + margin_m {
            continue;
        }
        let in_robot = drawn.transformed(world_from_robot.inverse());
        let (direction, normal) = (in_robot.direction(), in_robot.normal());
        let (along0, across0) = (in_robot.centre.dot(&direction), in_robot.centre.dot(&normal));
        for index in observations.range(pose) {
            let p = observations.point(index);
            let near = (p.dot(&normal) - across0).abs() <= margin_m
                && (p.dot(&direction) - along0).abs() <= drawn.half_length_m + margin_m;
            if near {
                found.push(Candidate {
                    index: index as u32,
                    pose,
                    point: world_from_robot.transform_point(p),
                    normal: world_from_robot.rotate(observations.normal(index)),
                });
            }
        }
    }
    found
}

/// The feature as it enters the map: `segment` is the fitted one, its direction already aligned with its partner's.
/// `own_side` are the poses on its side of the cut ([`super::split`]); if there are none, all count. Of the visits
/// there, one ties the segment along its wall: the one that holds `anchor`, the pose that the stroke was drawn from,
/// else the one that saw most. Where another visit is along the same wall is what nobody said.
pub fn make_feature(
    segment: Segment,
    caught: &Caught,
    own_side: impl RangeBounds<usize>,
    anchor: Option<usize>,
    observations: &Observations,
    poses: &[Pose2],
) -> Feature {
    let mut feature = Feature { segment, points: caught.points.clone(), sightings: Vec::new() };
    let tied = tying_visit(&caught.poses, own_side, anchor);
    let mut rest = &caught.points[..];
    for &(pose, count) in &caught.poses {
        let (mine, others) = rest.split_at(count);
        rest = others;
        let mean = mine.iter().map(|&p| observations.point(p as usize)).sum::<Vec2>() / count as f64;
        let world_from_robot = poses[pose];
        feature.sightings.push(Sighting {
            pose,
            tied: tied.contains(&pose),
            along_m: segment.along_across(world_from_robot.transform_point(mean)).0,
            bearing_rad: angle_diff(segment.direction_rad, world_from_robot.theta_rad),
        });
    }
    feature
}

/// First and last pose of the visit that ties.
fn tying_visit(
    seen_from: &[(usize, usize)],
    own_side: impl RangeBounds<usize>,
    anchor: Option<usize>,
) -> RangeInclusive<usize> {
    let own: Vec<(usize, usize)> = seen_from.iter().copied().filter(|s| own_side.contains(&s.0)).collect();
    let usable = if own.is_empty() { seen_from } else { &own };
    let visits = usable.chunk_by(|a, b| b.0 - a.0 <= VISIT_GAP);
    let ends = |visit: &[(usize, usize)]| visit[0].0..=visit[visit.len() - 1].0;
    let support = |visit: &[(usize, usize)]| visit.iter().map(|s| s.1).sum::<usize>();
    let drawn_on = |visit: &[(usize, usize)]| anchor.is_some_and(|pose| ends(visit).contains(&pose));
    let best = visits.max_by_key(|v| (drawn_on(v), support(v), Reverse(v[0].0)));
    best.map_or(0..=0, ends)
}
