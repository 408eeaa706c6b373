//! How a walker goes along a route, and what the dead reckoning makes of it.
//!
//! Steps of 0.7 m every 0.6 s; a leg ends with a shorter step. The reckoned displacement of step k is
//! R(φ_k) d_k + noise; the heading error φ grows by a rate per metre, which itself may wander, and by a random walk.

use super::Route;
use crate::geometry::{Pose2, Vec2, angle_diff};
use crate::pedestrian::random::Key;
use crate::pedestrian::{Step, TruthPoint, Walk};

/// Length of a step, metres.
pub const STEP_M: f64 = 0.7;
/// Time from step to step, seconds.
pub const STEP_S: f64 = 0.6;
/// How long a walker stands at a marked point, seconds (the paper: about 3 s).
pub const PAUSE_S: f64 = 3.0;

/// How a dead reckoning drifts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Heading error per metre, radians; from `from_m` on.
    pub rate_rad_per_m: f64,
    /// Path length from which the rate applies, metres.
    pub from_m: f64,
    /// Heading error at the start, standard deviation, radians.
    pub start_rad: f64,
    /// Random walk of the heading error per step, radians.
    pub heading_rad: f64,
    /// White noise of a step per axis, metres.
    pub position_m: f64,
    /// Steps are measured this much too long, standard deviation, as a share.
    pub scale: f64,
}

impl Drift {
    /// The paper's walkers: without a rate, good steps (design note: 0.3°, 0.05° a step, 1 cm).
    pub const STEADY: Drift = Drift {
        rate_rad_per_m: 0.0,
        from_m: 0.0,
        start_rad: 0.3 * std::f64::consts::PI / 180.0,
        heading_rad: 0.05 * std::f64::consts::PI / 180.0,
        position_m: 0.01,
        scale: 0.0,
    };
}

/// The walk, as its dead reckoning has it, and the truth: at every marked point, and every `truth_every` steps.
pub fn walk(
    name: &str,
    route: &Route,
    drift: &Drift,
    truth_every: usize,
    key: Key,
) -> (Walk, Vec<TruthPoint>) {
    let (mut steps, mut truth) = (Vec::new(), Vec::new());
    let mut normals = (0..).map(|k| key.normal(k));
    let mut normal = || normals.next().unwrap_or(0.0);
    let start = route.start();
    let (mut here, mut heading_rad, mut reckoned_rad) = (start, start.theta_rad, start.theta_rad);
    let mut error_rad = drift.start_rad * normal();
    let scale = 1.0 + drift.scale * normal();
    let (mut time_s, mut walked_m) = (0.0, 0.0);
    let mut mark = |stamp_s: f64, at: Pose2| {
        truth.push(TruthPoint { walker: name.to_owned(), stamp_s, position: at.translation() });
    };
    let pauses = |vertex: usize| route.marked.contains(&vertex);
    if pauses(0) {
        mark(PAUSE_S / 2.0, here);
        time_s += PAUSE_S;
    }
    for (vertex, leg) in route.points.windows(2).enumerate().map(|(k, leg)| (k + 1, leg)) {
        let along = leg[1] - leg[0];
        let count = (along.norm() / STEP_M - 1e-6).ceil().max(1.0) as usize;
        for k in 1..=count {
            let target =
                if k == count { leg[1] } else { leg[0] + along * (k as f64 * STEP_M / along.norm()) };
            let moved = target - here.translation();
            error_rad += drift.heading_rad * normal();
            let drifting_m = (walked_m + moved.norm() - drift.from_m).clamp(0.0, moved.norm());
            error_rad += drift.rate_rad_per_m * drifting_m;
            walked_m += moved.norm();
            time_s += STEP_S;
            // The walker looks where the route goes next.
            let next = match route.points.get(vertex + 1) {
                Some(next) if k == count => *next - leg[1],
                _ => along,
            };
            heading_rad += angle_diff(next.y.atan2(next.x), heading_rad);
            let measured = Pose2::new(0.0, 0.0, error_rad).rotate(moved) * scale
                + Vec2::new(normal(), normal()) * drift.position_m;
            let body = Pose2::new(0.0, 0.0, reckoned_rad).inverse_rotate(measured);
            let new_reckoned_rad = heading_rad + error_rad;
            let turn_rad = new_reckoned_rad - reckoned_rad;
            reckoned_rad = new_reckoned_rad;
            steps.push(Step { time_s, forward_m: body.x, left_m: body.y, turn_rad });
            here = Pose2::new(target.x, target.y, heading_rad);
            if truth_every > 0 && steps.len().is_multiple_of(truth_every) && !(k == count && pauses(vertex)) {
                mark(time_s, here);
            }
        }
        if pauses(vertex) {
            mark(time_s + PAUSE_S / 2.0, here);
            time_s += PAUSE_S;
        }
    }
    (Walk { name: name.to_owned(), steps }, truth)
}
