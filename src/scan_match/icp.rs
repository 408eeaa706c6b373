//! Point-to-line ICP with a prior: Gauss–Newton on Σ w·(n·(R p + t − μ))², each point against its nearest surfel.
//!
//! e = n·(q − μ), q = R p + t; ∂e/∂(x, y, θ) = [n_x, n_y, n_y r_x − n_x r_y] with r = R p. Robust weight
//! w = (c²/(c² + e²))²/σ² (Geman–McClure). Search radius and c are annealed from coarse to fine over the first rounds.

use nalgebra::{Matrix3, Vector3};

use super::{Cloud, SurfelMap};
use crate::geometry::{Pose2, Vec2, angle_diff};

/// σ of a point's distance to its surfel, metres.
const SIGMA_M: f64 = 0.03;
/// Normals of a point and its surfel agree to within acos of this.
const NORMAL_COSINE: f64 = 0.7;
/// Rounds from coarse to fine.
const ANNEALING_ROUNDS: f64 = 4.0;
/// Steps below these after annealing end the iteration: metres, radians.
const SETTLED: (f64, f64) = (1e-4, 1e-5);
/// A step is cut to at most this: metres, radians.
const LONGEST_STEP: (f64, f64) = (0.5, 0.3);
/// A point fits if it lies this close to its surfel's line, metres …
const INLIER_ACROSS_M: f64 = 0.08;
/// … and to the surfel itself, metres.
const INLIER_DISTANCE_M: f64 = 0.25;
/// A point is covered by the map if there is any surfel this near, metres.
const COVERED_M: f64 = 0.5;

/// What is believed about the pose before matching.
#[derive(Debug, Clone, Copy)]
pub struct Prior {
    /// `map_from_robot`.
    pub pose: Pose2,
    /// Ω, 3×3, additive in the axes of the map.
    pub information: Matrix3<f64>,
}

/// From where to where the search radius shrinks, and for how long to iterate.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    /// At first, metres.
    pub coarse_m: f64,
    /// In the end, metres.
    pub fine_m: f64,
    /// At most.
    pub rounds: usize,
}

/// A matched scan.
#[derive(Debug, Clone, Copy)]
pub struct Match {
    /// `map_from_robot`.
    pub pose: Pose2,
    /// Σ Jᵀw J without the prior: what the scan says about the pose, in the axes of the map.
    pub hessian: Matrix3<f64>,
    /// Share of the points that fit a surfel.
    pub inliers: f64,
    /// Share of the points that have any surfel near.
    pub covered: f64,
}

/// Refines `start` (`map_from_robot`).
pub fn align(
    map: &SurfelMap,
    cloud: &Cloud,
    start: Pose2,
    prior: Option<&Prior>,
    schedule: Schedule,
) -> Match {
    let mut pose = start;
    let mut hessian = Matrix3::zeros();
    for round in 0..schedule.rounds {
        let progress = (round as f64 / ANNEALING_ROUNDS).min(1.0);
        let radius_m = schedule.coarse_m * (schedule.fine_m / schedule.coarse_m).powf(progress);
        let loss_scale = 3.0 * SIGMA_M * 4_f64.powf(1.0 - progress);
        let mut gradient;
        (hessian, gradient) = linearize(map, cloud, pose, radius_m, loss_scale);
        let mut curvature = hessian + Matrix3::identity() * 1e-6;
        if let Some(prior) = prior {
            let off = Vector3::new(
                pose.x_m - prior.pose.x_m,
                pose.y_m - prior.pose.y_m,
                angle_diff(pose.theta_rad, prior.pose.theta_rad),
            );
            curvature += prior.information;
            gradient += prior.information * off;
        }
        let Some(factor) = curvature.cholesky() else { break };
        let step = factor.solve(&gradient);
        let (moved_m, turned_rad) = (step.xy().norm(), step.z.abs());
        let cut = (LONGEST_STEP.0 / moved_m).min(LONGEST_STEP.1 / turned_rad).min(1.0);
        pose = Pose2::new(pose.x_m - cut * step.x, pose.y_m - cut * step.y, pose.theta_rad - cut * step.z);
        if round as f64 > ANNEALING_ROUNDS && moved_m < SETTLED.0 && turned_rad < SETTLED.1 {
            break;
        }
    }
    let (inliers, covered) = fit(map, cloud, pose);
    Match { pose, hessian, inliers, covered }
}

fn linearize(
    map: &SurfelMap,
    cloud: &Cloud,
    pose: Pose2,
    radius_m: f64,
    loss_scale: f64,
) -> (Matrix3<f64>, Vector3<f64>) {
    let (sin, cos) = pose.theta_rad.sin_cos();
    let turn = |v: &Vec2| Vec2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y);
    let (mut hessian, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
    for (p, normal) in cloud.points.iter().zip(&cloud.normals) {
        let arm = turn(p);
        let q = arm + pose.translation();
        let Some(surfel) = map.nearest(q, turn(normal), radius_m, NORMAL_COSINE) else { continue };
        let n = surfel.normal;
        let e = n.dot(&(q - surfel.mean));
        let robust = loss_scale * loss_scale / (loss_scale * loss_scale + e * e);
        let w = robust * robust / (SIGMA_M * SIGMA_M);
        let j = Vector3::new(n.x, n.y, n.y * arm.x - n.x * arm.y);
        gradient += j * (w * e);
        hessian += j * j.transpose() * w;
    }
    (hessian, gradient)
}

fn fit(map: &SurfelMap, cloud: &Cloud, pose: Pose2) -> (f64, f64) {
    let (mut inliers, mut covered) = (0, 0);
    for (p, normal) in cloud.points.iter().zip(&cloud.normals) {
        let q = pose.transform_point(*p);
        if let Some(surfel) = map.nearest(q, pose.rotate(*normal), COVERED_M, NORMAL_COSINE) {
            covered += 1;
            let off = q - surfel.mean;
            if surfel.normal.dot(&off).abs() < INLIER_ACROSS_M && off.norm() < INLIER_DISTANCE_M {
                inliers += 1;
            }
        }
    }
    let share = |count: usize| count as f64 / cloud.points.len().max(1) as f64;
    (share(inliers), share(covered))
}
