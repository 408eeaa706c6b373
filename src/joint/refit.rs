//! A segment follows its poses: before a solve, P is put where its fixed S now lies.

use crate::geometry::{Pose2, Segment, Vec2};
use crate::map::{Feature, Observations};

/// The feature's segment at `poses`: direction and place along the wall by the references kept in its sightings,
/// place across by its points' mean; of the poses on its own side of the chain. Exact after a rigid motion; else a start for the solver.
pub fn refit(feature: &Feature, observations: &Observations, poses: &[Pose2]) -> Segment {
    let mut direction = Vec2::zeros();
    let mut mean = Vec2::zeros();
    let mut means = Vec::with_capacity(feature.sightings.len());
    for (sighting, points) in feature.points_by_sighting(observations).filter(|(s, _)| s.tied) {
        let pose = poses[sighting.pose];
        let count = points.len() as f64;
        let (sin, cos) = (pose.theta_rad + sighting.bearing_rad).sin_cos();
        direction += Vec2::new(cos, sin) * count;
        let in_robot = points.iter().map(|&p| observations.point(p as usize)).sum::<Vec2>() / count;
        let in_world = pose.transform_point(in_robot);
        mean += in_world * count;
        means.push((in_world, sighting.along_m, count));
    }
    let total: f64 = means.iter().map(|m| m.2).sum();
    mean /= total;
    let segment = Segment {
        centre: mean,
        direction_rad: direction.y.atan2(direction.x),
        half_length_m: feature.segment.half_length_m,
    };
    let slide =
        means.iter().map(|&(p, along_m, count)| (segment.along_across(p).0 - along_m) * count).sum::<f64>();
    Segment { centre: mean + segment.direction() * (slide / total), ..segment }
}
