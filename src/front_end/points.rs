//! One sweep of the laser as points and normals in the robot frame.
//!
//! The normal of a return is that of the total-least-squares line through its neighbours: returns of the ±6 beams around
//! it that lie within max(0.2 m, five beam spacings), at most 0.8 m. It is unknown, (0, 0), if fewer than three
//! returns are left or they form no line: λ_min ≥ 0.15 λ_max. It points to the sensor.

use super::Options;
use crate::geometry::{Pose2, Vec2};
use crate::map::{LogScan, Observations};

const NEIGHBOUR_BEAMS: usize = 6;
const NEIGHBOUR_RADIUS_M: f64 = 0.2;
const NEIGHBOUR_SPACINGS: f64 = 5.0;
const LARGEST_RADIUS_M: f64 = 0.8;
const FEWEST_POINTS: usize = 3;
/// A square blob has 1, a wall at 1 cm noise over 0.2 m some 0.02.
const LARGEST_EIGENVALUE_RATIO: f64 = 0.15;
/// Share of the laser's maximum range from which on a reading is "no return": logs round it.
const SHARE_OF_MAX_RANGE: f64 = 0.999;

/// Appends the returns of a scan to the pose that is being filled.
pub fn observe(scan: &LogScan, robot_from_laser: Pose2, options: &Options, observations: &mut Observations) {
    let end_m = options.max_range_m.min(scan.max_range_m * SHARE_OF_MAX_RANGE);
    let returns: Vec<Option<Vec2>> = scan
        .ranges_m
        .iter()
        .enumerate()
        .map(|(beam, &range_m)| {
            let range_m = f64::from(range_m);
            let (sin, cos) = (scan.first_bearing_rad + beam as f64 * scan.bearing_step_rad).sin_cos();
            (range_m > options.min_range_m && range_m < end_m).then(|| Vec2::new(cos, sin) * range_m)
        })
        .collect();
    for (beam, p_in_laser) in returns.iter().enumerate() {
        let Some(p_in_laser) = *p_in_laser else { continue };
        let range_m = p_in_laser.norm();
        let spacing_m = range_m * scan.bearing_step_rad.abs();
        let radius_m = (NEIGHBOUR_SPACINGS * spacing_m).clamp(NEIGHBOUR_RADIUS_M, LARGEST_RADIUS_M);
        let around = beam.saturating_sub(NEIGHBOUR_BEAMS)..returns.len().min(beam + NEIGHBOUR_BEAMS + 1);
        let normal_in_laser = normal(p_in_laser, &returns[around], radius_m);
        observations.push(
            robot_from_laser.transform_point(p_in_laser),
            robot_from_laser.rotate(normal_in_laser),
            range_m,
        );
    }
}

/// The normal at `p` (sensor at the origin) from the returns around it, `p` among them.
fn normal(p: Vec2, around: &[Option<Vec2>], radius_m: f64) -> Vec2 {
    let near = || around.iter().flatten().map(|q| q - p).filter(|d| d.norm_squared() <= radius_m * radius_m);
    let count = near().count();
    if count < FEWEST_POINTS {
        return Vec2::zeros();
    }
    let mean = near().sum::<Vec2>() / count as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for d in near().map(|d| d - mean) {
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
    }
    let (middle, spread) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let (smallest, largest) = (middle - spread, middle + spread);
    if largest <= 0.0 || smallest >= LARGEST_EIGENVALUE_RATIO * largest {
        return Vec2::zeros();
    }
    let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    let normal = Vec2::new(-sin, cos);
    if normal.dot(&p) > 0.0 { -normal } else { normal }
}
