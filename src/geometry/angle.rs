//! The only place that touches modulo 2π. Angles are radians in (−π, π].

use std::f64::consts::{PI, TAU};

/// The same direction as `angle_rad`, in (−π, π].
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad - TAU * (angle_rad / TAU).round();
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

/// `to − from`, the short way round: in (−π, π].
pub fn angle_diff(to_rad: f64, from_rad: f64) -> f64 {
    wrap_angle(to_rad - from_rad)
}
