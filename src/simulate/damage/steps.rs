//! What a damage does to the steps between scans or poses.

use std::ops::Range;

use rand_chacha::rand_core::Rng;
use rand_distr::{Distribution, StandardUniform};

use super::Kind;
use crate::geometry::Pose2;

/// Heading lost in a kick, degrees.
const KICK_DEG: f64 = 30.0;
/// What a slipping wheel counts too much, per metre.
const SLIP: f64 = 0.015;
/// Distance between the wheels of a robot of the public logs, metres, about.
const WHEEL_BASE_M: f64 = 0.5;
/// Heading error of a drifting odometry, degrees per metre: between these two, either way.
const BEND_DEG_PER_M: [f64; 2] = [0.2, 0.5];
/// Largest scale error of a drifting odometry.
const STRETCH: f64 = 0.02;

/// Sets the errors of the steps in `range`; what they add up to: heading in degrees, way in metres.
pub(super) fn spoil(
    kind: Kind,
    poses: &[Pose2],
    range: Range<usize>,
    errors: &mut [Option<Pose2>],
    random: &mut impl Rng,
) -> (f64, f64) {
    let mut uniform = || -> f64 { StandardUniform.sample(random) };
    let side = if uniform() < 0.5 { -1.0 } else { 1.0 };
    let (bend_rad_per_m, stretch) = match kind {
        Kind::Kick => {
            let turn_rad = side * KICK_DEG.to_radians();
            errors[range.start] = Some(Pose2::new(0.0, 0.0, turn_rad));
            return (side * KICK_DEG, 0.0);
        }
        // One of two wheels: the middle between them goes half as far too much.
        Kind::Slip => (side * SLIP / WHEEL_BASE_M, SLIP / 2.0),
        Kind::Drift => {
            let [low, high] = BEND_DEG_PER_M.map(f64::to_radians);
            (side * (low + (high - low) * uniform()), STRETCH * (2.0 * uniform() - 1.0))
        }
        Kind::Blind | Kind::Drop => return (0.0, 0.0),
    };
    let mut total = (0.0, 0.0);
    for k in range {
        let step = poses[k].between(poses[k + 1]);
        let way_m = step.translation().norm();
        let (turn_rad, more) = (bend_rad_per_m * way_m, 1.0 + stretch);
        let counted = Pose2::new(step.x_m * more, step.y_m * more, step.theta_rad + turn_rad);
        errors[k] = Some(step.between(counted));
        total = (total.0 + turn_rad.to_degrees(), total.1 + way_m * stretch);
    }
    total
}
