//! Walks as a map: a pose is a window of steps, the footprints in it are its points.
//!
//! The pose stands where the window's first step began, heading as the dead reckoning had it there. Its points are the
//! footprints, its first one among them, each with a normal across the direction of walking. A corridor is walked there and
//! back, and both are one corridor: so normals do not turn with the walker, they look into one half of the world. The half is
//! turned by 22.5° against the walkers' own direction, so that no corridor of the building lies on its border.
//!
//! A relative factor's covariance is that of the window's steps under [`OdometryNoise`] (docs/MATH-pedestrian.md), first
//! order; the drift is taken to be drawn anew in every window. The first poses of several walks are tied by where the
//! walks began; nothing ties the end of one to the start of the next, although they are neighbours.
//!
//! Every step is a [`ScanRecord`], so that a map of walks gives back the walks.

use std::f64::consts::FRAC_PI_8;

use nalgebra::{Matrix3, Vector3};

use crate::error::{Error, Result};
use crate::geometry::{Information, Pose2, Vec2};
use crate::map::{Observations, RelativeFactor, ScanRecord, SlamMap};
use crate::pedestrian::{OdometryNoise, Start, Step, Walk, grid};

/// Standard deviations below which nothing is certain: metres, radians.
const LEAST_SIGMAS: (f64, f64) = (1e-3, 1e-4);

/// How walks become a map.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkOptions {
    /// Steps of a pose, ≥ 1.
    pub steps_per_pose: usize,
    /// Where the walks begin: one for all, or one each, in their order.
    pub starts: Vec<Start>,
    /// Errors of the dead reckoning.
    pub noise: OdometryNoise,
}

impl Default for WalkOptions {
    fn default() -> Self {
        WalkOptions { steps_per_pose: 5, starts: vec![Start::default()], noise: OdometryNoise::default() }
    }
}

impl WalkOptions {
    /// The defaults, with walks that begin there; none: at the origin.
    pub fn starting(poses: &[Pose2]) -> Self {
        let mut options = WalkOptions::default();
        if !poses.is_empty() {
            options.starts = poses.iter().map(|&pose| Start { pose, ..Start::default() }).collect();
        }
        options
    }
}

/// Builds the map; the walks follow each other in it.
///
/// # Errors
/// [`Error::Input`] if there is no walk, one has no step, or the starts are neither one nor one each.
pub fn map_of_walks(walks: &[Walk], options: &WalkOptions) -> Result<SlamMap> {
    if options.steps_per_pose == 0 {
        return Err(Error::input("steps per pose", "found 0, expected at least 1"));
    }
    if walks.is_empty() {
        return Err(Error::input("walks", "found none, expected at least one"));
    }
    if let Some(walk) = walks.iter().find(|w| w.steps.is_empty()) {
        return Err(Error::input(&walk.name, "found a walk without steps, expected at least one"));
    }
    let (found, wanted) = (options.starts.len(), walks.len());
    if found != 1 && found != wanted {
        return Err(Error::input(
            "starts",
            format!("found {found}, expected 1 or {wanted}, one for each walk"),
        ));
    }
    let starts: Vec<Start> = (0..wanted).map(|j| options.starts[j.min(found - 1)]).collect();
    let tracks: Vec<Vec<Pose2>> = walks.iter().zip(&starts).map(|(w, s)| w.track(s.pose)).collect();
    let half = one_half(&tracks, walks);

    let mut map = SlamMap {
        observations: Observations { starts: vec![0], ..Default::default() },
        ..SlamMap::default()
    };
    let mut stamps_s = Vec::new();
    for ((walk, track), start) in walks.iter().zip(&tracks).zip(&starts) {
        let first = map.poses.len();
        if first > 0 {
            map.relative_factors.push(between_starts(starts[0], *start, first)?);
        }
        add(&mut map, &mut stamps_s, walk, track, half, options)?;
    }
    map.stamps_s = Some(stamps_s);
    map.validate("walks")?;
    Ok(map)
}

/// The direction that all normals have a positive part of.
fn one_half(tracks: &[Vec<Pose2>], walks: &[Walk]) -> Vec2 {
    let lines: Vec<Vec<Vec2>> = tracks.iter().map(|t| t.iter().map(|p| p.translation()).collect()).collect();
    let typical = walks.iter().map(Walk::typical_length_m);
    let direction = grid::group_direction(lines.iter().map(Vec::as_slice).zip(typical));
    let (sin, cos) = (direction.map_or(0.0, |d| d.angle_rad) + FRAC_PI_8).sin_cos();
    Vec2::new(cos, sin)
}

/// The start of a walk as the first one's start sees it.
fn between_starts(a: Start, b: Start, j: usize) -> Result<RelativeFactor> {
    let at_least = |sigma: f64, least: f64| sigma.max(least);
    let position_m = at_least(a.position_sigma_m.hypot(b.position_sigma_m), LEAST_SIGMAS.0);
    let heading_rad = at_least(a.heading_sigma_rad.hypot(b.heading_sigma_rad), LEAST_SIGMAS.1);
    // A turn of the first start swings the second about it.
    let apart_m = (b.pose.translation() - a.pose.translation()).norm();
    let swung_m = position_m.hypot(apart_m * a.heading_sigma_rad);
    let information = Information::from_sigmas(swung_m, swung_m, heading_rad);
    Ok(RelativeFactor { i: 0, j, i_from_j: a.pose.between(b.pose), information })
}

/// Adds one walk.
fn add(
    map: &mut SlamMap,
    stamps_s: &mut Vec<f64>,
    walk: &Walk,
    track: &[Pose2],
    half: Vec2,
    options: &WalkOptions,
) -> Result<()> {
    let first = map.poses.len();
    let began_s = walk.steps[0].time_s - walk.typical_step_s();
    let stamp = |k: usize| if k == 0 { began_s } else { walk.steps[k - 1].time_s };
    for (number, window) in walk.steps.chunks(options.steps_per_pose).enumerate() {
        let from = number * options.steps_per_pose;
        let (here, pose) = (track[from], map.poses.len());
        if pose > first {
            let steps = &walk.steps[from - options.steps_per_pose..from];
            map.relative_factors.push(relative(steps, pose, &options.noise)?);
        }
        map.poses.push(here);
        stamps_s.push(stamp(from));
        // The walk's last footprint belongs to its last window.
        for k in from..=from + window.len() {
            let is_next = k == from + window.len() && k < walk.steps.len();
            if is_next {
                break;
            }
            let parent_from_robot = here.between(track[k]);
            map.scans.push(ScanRecord { stamp_s: stamp(k), parent: pose, parent_from_robot });
            let p = parent_from_robot.translation();
            map.observations.push(p, normal(here, track, k, half), p.norm());
        }
        map.observations.end_pose();
    }
    Ok(())
}

/// The normal at footprint k in the frame of `here`: across the chord from the one before to the one after.
fn normal(here: Pose2, track: &[Pose2], k: usize, half: Vec2) -> Vec2 {
    let (before, after) = (track[k.saturating_sub(1)], track[(k + 1).min(track.len() - 1)]);
    let chord = after.translation() - before.translation();
    if chord.norm() < 0.05 {
        return Vec2::zeros();
    }
    let across = Vec2::new(-chord.y, chord.x) / chord.norm();
    here.inverse_rotate(if across.dot(&half) < 0.0 { -across } else { across })
}

/// The factor that leads to pose j over the steps of the window before it.
fn relative(steps: &[Step], j: usize, noise: &OdometryNoise) -> Result<RelativeFactor> {
    let mut covariance = Matrix3::zeros();
    let mut z = Pose2::IDENTITY;
    // Drift and scale are the same in all steps of the window: their effect adds up before it is squared.
    let (mut by_drift, mut by_scale, mut shares) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for step in steps {
        let d = z.rotate(Vec2::new(step.forward_m, step.left_m));
        let moves = Matrix3::new(1.0, 0.0, -d.y, 0.0, 1.0, d.x, 0.0, 0.0, 1.0);
        let share = if step.is_standing() { 0.0 } else { step.length_m() / OdometryNoise::STEP_M };
        covariance[(2, 2)] += share * noise.heading_rad.powi(2);
        covariance = moves * covariance * moves.transpose();
        covariance[(0, 0)] += share * noise.position_m.powi(2);
        covariance[(1, 1)] += share * noise.position_m.powi(2);
        by_drift = moves * (by_drift + Vector3::new(0.0, 0.0, share * noise.drift_start_rad));
        by_scale = moves * by_scale + Vector3::new(d.x, d.y, 0.0) * noise.scale;
        shares += share;
        z = z.compose(Pose2::new(step.forward_m, step.left_m, step.turn_rad));
    }
    let wander_rad = noise.drift_rad * shares * (shares / 3.0).sqrt();
    covariance[(2, 2)] += wander_rad * wander_rad;
    covariance += by_drift * by_drift.transpose() + by_scale * by_scale.transpose();
    let least = Vector3::new(LEAST_SIGMAS.0, LEAST_SIGMAS.0, LEAST_SIGMAS.1);
    covariance += Matrix3::from_diagonal(&least.component_mul(&least));
    // The residual's axes are those of pose j as measured.
    let information =
        Information::from_covariance(covariance).map_err(Error::Internal)?.rotated(-z.theta_rad);
    Ok(RelativeFactor { i: j - 1, j, i_from_j: z, information })
}
