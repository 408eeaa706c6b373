//! Which hexagon grid: turned to the group's walking direction, or drawn anew.
//!
//! A hexagon map holds paths near the grid's axes more easily than others. On an axis that is a straight-corridor
//! prior and takes out drift; a leg that truly runs a few degrees off an axis would be bent onto it. Where
//! [`super::bend`] notices that, the run goes on with [`GridChoice::Regrid`](super::GridChoice), which prefers no
//! direction.

use std::f64::consts::FRAC_PI_2;

use super::hex::HexGrid;
use super::options::OdometryNoise;
use super::random::Key;
use crate::geometry::{Vec2, wrap_angle};

/// The direction is taken from this much of every walk, metres, or from the first round if that is shorter.
pub const ALIGN_WITHIN_M: f64 = 15.0;
/// Below this concentration there is no common direction.
pub const MIN_CONCENTRATION: f64 = 0.9;
/// Walks of at least this length tell their direction better, metres: along several legs drift can be told from it.
pub const LONG_M: f64 = 60.0;
/// Of a long walk, this much is looked at, metres.
const LOOKED_AT_M: f64 = 140.0;
/// White noise of the direction of a stride, radians.
const STRIDE_NOISE_RAD: f64 = 0.035;
/// Strides further off the axes than this are on their way round a corner, or oblique, radians.
const GATE_RAD: f64 = 0.26;

/// Where a group is heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupDirection {
    /// Direction modulo 90°, radians in (−π/4, π/4].
    pub angle_rad: f64,
    /// 1: all steps go along it or across; 0: they go anywhere.
    pub concentration: f64,
}

/// The common direction (modulo 90°) of tracks: arg Σ (|v|/3L)⁸ e^{4iθ} / 4 over the chords v of three steps of
/// typical length L; the power keeps out chords that span a corner. `None` if nobody moves.
pub fn group_direction<'a>(tracks: impl Iterator<Item = (&'a [Vec2], f64)>) -> Option<GroupDirection> {
    let (mut sum, mut weights) = (Vec2::zeros(), 0.0);
    for (track, typical_m) in tracks {
        for chord in track.windows(4) {
            let v = chord[3] - chord[0];
            let weight = (v.norm() / (3.0 * typical_m)).min(1.2).powi(8);
            let (s, c) = (4.0 * v.y.atan2(v.x)).sin_cos();
            sum += Vec2::new(c, s) * weight;
            weights += weight;
        }
    }
    let direction =
        GroupDirection { angle_rad: sum.y.atan2(sum.x) / 4.0, concentration: sum.norm() / weights };
    (weights > 0.0).then_some(direction)
}

/// The common direction (modulo 90°) of walks of at least [`LONG_M`], where the dead reckoning starts; without them
/// `None`.
///
/// Each stride of two steps measures the axes' direction plus the heading error of that moment. A Kalman filter over
/// (direction + heading error, drift) goes backwards through the walk, so that its last estimate is the one at the start,
/// where the heading is known. Its noise is that of the mapper.
pub fn long_direction<'a>(
    tracks: impl Iterator<Item = (&'a [Vec2], f64)>,
    noise: &OdometryNoise,
) -> Option<GroupDirection> {
    let (mut sum, mut count) = (Vec2::zeros(), 0.0);
    for (track, typical_m) in tracks {
        let strides: Vec<Vec2> =
            track.windows(3).step_by(2).map(|w| w[2] - w[0]).filter(|v| v.norm() > 1.7 * typical_m).collect();
        let stride_m = 2.0 * typical_m;
        if (strides.len() as f64) * stride_m < LONG_M {
            continue;
        }
        let looked_at = &strides[..strides.len().min((LOOKED_AT_M / stride_m) as usize)];
        let (angle_rad, fitting) = backwards(looked_at, stride_m / OdometryNoise::STEP_M, noise);
        let (s, c) = (4.0 * angle_rad).sin_cos();
        sum += Vec2::new(c, s) * fitting;
        count += 1.0;
    }
    (count > 0.0)
        .then(|| GroupDirection { angle_rad: sum.y.atan2(sum.x) / 4.0, concentration: sum.norm() / count })
}

/// Direction of the axes as seen at the start of these strides, and the share of them that run along one; `share` is a
/// stride's length in steps of the noise.
fn backwards(strides: &[Vec2], share: f64, noise: &OdometryNoise) -> (f64, f64) {
    let off_axis = |angle: f64| angle - (angle / FRAC_PI_2).round() * FRAC_PI_2;
    let square = |x: f64| x * x;
    let mut angle = strides.last().map_or(0.0, |v| v.y.atan2(v.x));
    let (mut drift, mut fitting) = (0.0, 0);
    let r = square(STRIDE_NOISE_RAD);
    // Covariance of (angle, drift).
    let (mut p_aa, mut p_ad, mut p_dd) = (r, 0.0, square(noise.drift_start_rad));
    for stride in strides.iter().rev() {
        angle -= share * drift;
        p_aa += square(share) * p_dd - 2.0 * share * p_ad + share * square(noise.heading_rad);
        p_ad -= share * p_dd;
        p_dd += share * square(noise.drift_rad);
        let error = off_axis(stride.y.atan2(stride.x) - angle);
        if error.abs() > GATE_RAD {
            continue;
        }
        fitting += 1;
        let (gain_angle, gain_drift) = (p_aa / (p_aa + r), p_ad / (p_aa + r));
        angle += gain_angle * error;
        drift += gain_drift * error;
        p_dd -= gain_drift * p_ad;
        p_ad *= 1.0 - gain_angle;
        p_aa *= 1.0 - gain_angle;
    }
    (off_axis(angle), f64::from(fitting) / strides.len().max(1) as f64)
}

/// A grid with a random angle and offset: the same for all walkers of an iteration.
pub fn random_grid(radius_m: f64, origin: Vec2, key: Key) -> HexGrid {
    let offset = Vec2::new(key.uniform(1), key.uniform(2)) * (2.0 * radius_m);
    let angle_rad = wrap_angle(key.uniform(0) * FRAC_PI_2 * (2.0 / 3.0));
    HexGrid { radius_m, angle_rad, origin: origin + offset }
}
