//! Turning a map so that one of its walls lies along an axis. Nothing bends: every pose turns about the first.

use std::f64::consts::FRAC_PI_2;

use crate::error::Result;
use crate::geometry::{Pose2, angle_diff};
use crate::interpret;
use crate::map::Stroke;
use crate::pipeline::Corrector;

/// The turn that lays the wall under `along` on the nearer axis: `world_from_map`.
///
/// # Errors
/// [`crate::error::Error::Input`] for a stroke that names a pose that the map does not have.
pub fn world_from_map(corrector: &Corrector, along: &Stroke) -> Result<Pose2> {
    let map = corrector.map();
    let ends = interpret::in_world(map, &map.poses, along)?;
    // A stroke beside every wall still has a direction.
    let direction_rad = match corrector.catch(ends) {
        Ok(caught) => caught.fit.segment.direction_rad,
        Err(_) => (ends[1].y - ends[0].y).atan2(ends[1].x - ends[0].x),
    };
    let axis_rad = (direction_rad / FRAC_PI_2).round() * FRAC_PI_2;
    let turn = Pose2::new(0.0, 0.0, angle_diff(axis_rad, direction_rad));
    let pivot = map.poses.first().map_or(Pose2::IDENTITY, |p| Pose2::new(p.x_m, p.y_m, 0.0));
    Ok(pivot.compose(turn).compose(pivot.inverse()))
}
