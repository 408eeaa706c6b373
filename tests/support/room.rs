//! A robot that drives twice round a rectangular room with drifting odometry, and strokes that repair it.

use std::f64::consts::{FRAC_PI_2, TAU};

use hitl_slam::geometry::{Information, Pose2, Vec2};
use hitl_slam::map::{Correction, Mode, Observations, RelativeFactor, SlamMap, Stroke};

use super::dice::Dice;

/// Half the room's width and height, metres.
const HALF_M: [f64; 2] = [6.0, 4.0];
/// Steps of one round.
const ROUND: usize = 60;
const RANGE_M: f64 = 3.5;

/// The map as odometry leaves it.
pub fn map(seed: u64) -> SlamMap {
    let dice = &mut Dice::new(seed);
    let truth: Vec<Pose2> = (0..2 * ROUND).map(on_round).collect();
    let mut map =
        SlamMap { poses: vec![truth[0]], observations: Observations::default(), ..Default::default() };
    for i in 1..truth.len() {
        let step = truth[i - 1].between(truth[i]);
        let i_from_j = Pose2::new(
            step.x_m + dice.normal(0.01),
            step.y_m + dice.normal(0.005),
            step.theta_rad + 0.002 + dice.normal(0.003),
        );
        map.poses.push(map.poses[i - 1].compose(i_from_j));
        let information = Information::from_sigmas(0.02, 0.02, 0.005);
        map.relative_factors.push(RelativeFactor { i: i - 1, j: i, i_from_j, information });
    }
    for pose in &truth {
        for k in 0..360 {
            let angle = TAU * k as f64 / 360.0;
            if let Some((range, normal)) = cast(*pose, angle) {
                let range = range + dice.normal(0.01);
                let point = Vec2::new(angle.cos(), angle.sin()) * range;
                map.observations.push(point, pose.inverse_rotate(normal), range);
            }
        }
        map.observations.end_pose();
    }
    map
}

/// The four walls, each as seen in the first and in the second round; modes as given.
pub fn corrections(modes: [Mode; 4]) -> Vec<Correction> {
    let mut corrections = Vec::new();
    for (wall, mode) in modes.into_iter().enumerate() {
        let first = wall * ROUND / 4 + ROUND / 8;
        let strokes = [(wall, first), (wall, first + ROUND)]
            .map(|(wall, pose)| Stroke::Pose { pose, points: stroke_on(wall, on_round(pose)) });
        corrections.push(Correction {
            id: format!("c{wall}"),
            mode,
            a: strokes[0],
            b: strokes[1],
            weight: 1.0,
            enabled: true,
        });
    }
    corrections
}

/// A stroke on the right half of a wall, robot frame: the robot keeps each wall to its right in turn.
fn stroke_on(wall: usize, pose: Pose2) -> [Vec2; 2] {
    let (turn, distance) = (wall as f64 * FRAC_PI_2, HALF_M[(wall + 1) % 2]);
    let wall_frame = Pose2::new(0.0, 0.0, turn);
    [-1.0, 1.0].map(|along| {
        let centre = wall_frame.inverse().transform_point(pose.translation()).x;
        let in_world = wall_frame.transform_point(Vec2::new(centre + along, -distance));
        pose.inverse().transform_point(in_world)
    })
}

/// Step k along a rectangle 2 m inside the walls, counter-clockwise from the middle of the south side's start.
fn on_round(k: usize) -> Pose2 {
    let quarter = ROUND / 4;
    let (side, along) = ((k / quarter) % 4, (k % quarter) as f64 / quarter as f64);
    let [w, h] = HALF_M.map(|m| m - 2.0);
    let (half, out) = if side % 2 == 0 { (w, h) } else { (h, w) };
    let at = Pose2::new(0.0, 0.0, side as f64 * FRAC_PI_2)
        .transform_point(Vec2::new((2.0 * along - 1.0) * half, -out));
    Pose2::new(at.x, at.y, side as f64 * FRAC_PI_2)
}

/// Range and world normal of the wall that a beam hits.
fn cast(pose: Pose2, angle: f64) -> Option<(f64, Vec2)> {
    let d = pose.rotate(Vec2::new(angle.cos(), angle.sin()));
    let mut nearest: Option<(f64, Vec2)> = None;
    for (axis, half) in HALF_M.into_iter().enumerate() {
        for sign in [-1.0, 1.0] {
            let range = (sign * half - pose.translation()[axis]) / d[axis];
            if range > 0.0 && range < nearest.map_or(RANGE_M, |n| n.0) {
                let mut normal = Vec2::zeros();
                normal[axis] = -sign;
                nearest = Some((range, normal));
            }
        }
    }
    nearest
}
