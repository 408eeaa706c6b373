//! A crisp chain from a raw log: every scan is matched to a local map of recent keyframes. No loop closure.
//!
//! The local map is in the frame of the newest keyframe, so that a match *is* the measurement of its relative factor.
//! The odometry step on the last matched pose is start and prior. Where the match looks wrong (few inliers, a step that no
//! robot makes, odometry and match far apart: wheels that slip, encoders that freeze) three starts are tried with a
//! brute-force search each: odometry, standing still, going on as before.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{Options, Skeleton, observe};
use crate::geometry::{Information, Pose2};
use crate::map::{Observations, RawLog, RelativeFactor, ScanRecord};
use crate::scan_match::{Cloud, Match, Prior, Schedule, Search, Surfel, SurfelMap, Window, align};

/// Scans that are made ready at once.
const BATCH: usize = 256;
/// Keyframes in the local map.
const WINDOW: usize = 25;
/// Keyframes further from the newest than this are left out, metres.
const WINDOW_RADIUS_M: f64 = 15.0;
/// Points further from the newest keyframe than this are left out, metres.
const MAP_RADIUS_M: f64 = 35.0;
/// Search radii of a scan that is where it is expected.
const TRACKING: Schedule = Schedule { coarse_m: 0.5, fine_m: 0.2, rounds: 12 };
/// The brute-force search of a recovery.
const RECOVERY: Window = Window {
    position_m: 0.6,
    heading_rad: 20.0 * PI / 180.0,
    position_step_m: 0.1,
    heading_step_rad: PI / 180.0,
};
/// A match is doubted below this share of inliers among the covered points …
const FEWEST_INLIERS: f64 = 0.65;
/// … or if less than this share is covered …
const LEAST_COVERED: f64 = 0.3;
/// … or if odometry moves further in one scan than this: metres, radians …
const LONGEST_STEP: (f64, f64) = (0.7, 0.4);
/// … or if match and odometry differ by more than this, radians.
const LARGEST_DISAGREEMENT_RAD: f64 = 0.12;

/// After a longer pause than this only the odometry says where the robot is by now, seconds.
const LONGEST_PAUSE_S: f64 = 2.0;

/// What a match cannot know of itself (the laser's bias, a door that moved): metres. With it the chain's predicted error
/// agrees with the relations of the public logs: squared errors over their prediction, per degree of freedom and by time
/// span, are 0.2 to 1.0 on Intel and 0.7 to 2.4 on ACES, whose relations are the coarser.
const MODEL_SIGMA_M: f64 = 0.003;
/// … and radians.
const MODEL_SIGMA_RAD: f64 = 0.0005;

/// Where the chain stands while it grows.
struct Tracker<'a> {
    log: &'a RawLog,
    options: &'a Options,
    keyframes: Vec<Keyframe>,
    factors: Vec<RelativeFactor>,
    scans: Vec<ScanRecord>,
    /// In the frame of the newest keyframe.
    map: SurfelMap,
    /// The last scan, and the scan before it, seen from the newest keyframe.
    last: Pose2,
    before_last: Pose2,
}

struct Keyframe {
    scan: usize,
    world_from_robot: Pose2,
    cloud: Cloud,
}

/// The chain; `progress` is told the number of scans done. `None` if `cancelled` becomes true on the way.
pub(super) fn skeleton(
    log: &RawLog,
    options: &Options,
    progress: &(dyn Fn(usize) + Sync),
    cancelled: &AtomicBool,
) -> Option<Skeleton> {
    let mut tracker = Tracker {
        log,
        options,
        keyframes: Vec::new(),
        factors: Vec::new(),
        scans: Vec::with_capacity(log.scans.len()),
        map: SurfelMap::new(Vec::new()),
        last: Pose2::IDENTITY,
        before_last: Pose2::IDENTITY,
    };
    // Matching is one scan after the other; meanwhile the next batch is made ready on the other cores.
    let clouds = |batch: Range<usize>| -> Vec<Cloud> {
        batch.into_par_iter().map(|scan| cloud(log, scan, options)).collect()
    };
    let batch = |start: usize| start.min(log.scans.len())..(start + BATCH).min(log.scans.len());
    let mut ready = clouds(batch(0));
    for start in (0..log.scans.len()).step_by(BATCH) {
        let (next, ()) = rayon::join(
            || clouds(batch(start + BATCH)),
            || {
                for (scan, cloud) in (start..).zip(ready) {
                    if cancelled.load(Ordering::Relaxed) {
                        return;
                    }
                    tracker.add(scan, cloud);
                    progress(scan + 1);
                }
            },
        );
        if cancelled.load(Ordering::Relaxed) {
            return None;
        }
        ready = next;
    }
    Some(Skeleton {
        poses: tracker.keyframes.iter().map(|k| k.world_from_robot).collect(),
        stamps_s: tracker.keyframes.iter().map(|k| log.scans[k.scan].stamp_s).collect(),
        scan_of_pose: tracker.keyframes.iter().map(|k| Some(k.scan)).collect(),
        vertex_ids: None,
        held: Vec::new(),
        relative_factors: tracker.factors,
        scans: tracker.scans,
    })
}

impl Tracker<'_> {
    fn start(&mut self, cloud: Cloud) {
        let world_from_robot = self.log.scans[0].odometry_from_robot;
        self.keyframes.push(Keyframe { scan: 0, world_from_robot, cloud });
        self.hang(0, Pose2::IDENTITY);
        self.rebuild();
    }

    fn add(&mut self, scan: usize, cloud: Cloud) {
        if scan == 0 {
            return self.start(cloud);
        }
        let step = super::odometry_between(&self.log.scans[scan - 1], &self.log.scans[scan]);
        let expected = self.last.compose(step);
        let prior = Prior { pose: expected, information: step_information(step) };
        let mut found = align(&self.map, &cloud, expected, Some(&prior), TRACKING);
        if is_doubtful(&found, expected, step) {
            let pause_s = self.log.scans[scan].stamp_s - self.log.scans[scan - 1].stamp_s;
            found = self.recover(&cloud, step, pause_s, found);
        }
        self.before_last = self.last;
        self.last = found.pose;
        let moved_m = found.pose.translation().norm();
        if moved_m >= self.options.keyframe_distance_m
            || found.pose.theta_rad.abs() >= self.options.keyframe_angle_rad
        {
            self.add_keyframe(scan, cloud, &found);
        } else {
            self.hang(scan, found.pose);
        }
    }

    /// Tries three starts (after a pause the odometry's alone: another corridor may look like the one before it) with a wide
    /// search each; the first match stays unless another fits clearly better.
    fn recover(&self, cloud: &Cloud, step: Pose2, pause_s: f64, first: Match) -> Match {
        let search = Search::new(&self.map);
        let going_on = self.last.compose(self.before_last.between(self.last));
        let starts = [(self.last.compose(step), 0.05), (self.last, 0.1), (going_on, 0.1)];
        let mut best = first;
        for (start, gain) in starts.into_iter().take(if pause_s > LONGEST_PAUSE_S { 1 } else { 3 }) {
            let found = search.best(&cloud.points, start, RECOVERY).pose;
            let weak = Matrix3::from_diagonal(&Vector3::new(25.0, 25.0, 100.0));
            let found =
                align(&self.map, cloud, found, Some(&Prior { pose: found, information: weak }), TRACKING);
            if found.inliers > best.inliers + gain {
                best = found;
            }
        }
        best
    }

    fn add_keyframe(&mut self, scan: usize, cloud: Cloud, found: &Match) {
        let i = self.keyframes.len() - 1;
        let world_from_robot = self.keyframes[i].world_from_robot.compose(found.pose);
        let start = self.keyframes[i].scan;
        let odometry = super::odometry_between(&self.log.scans[start], &self.log.scans[scan]);
        let information = factor_information(found, &self.options.odometry_noise.information(odometry));
        self.factors.push(RelativeFactor { i, j: i + 1, i_from_j: found.pose, information });
        self.keyframes.push(Keyframe { scan, world_from_robot, cloud });
        self.hang(scan, Pose2::IDENTITY);
        self.before_last = self.last.between(self.before_last);
        self.last = Pose2::IDENTITY;
        self.rebuild();
    }

    fn hang(&mut self, scan: usize, parent_from_robot: Pose2) {
        let parent = self.keyframes.len() - 1;
        self.scans.push(ScanRecord { stamp_s: self.log.scans[scan].stamp_s, parent, parent_from_robot });
    }

    /// The local map in the frame of the newest keyframe.
    fn rebuild(&mut self) {
        let newest = self.keyframes.len() - 1;
        let reference = self.keyframes[newest].world_from_robot;
        let mut points = Vec::new();
        for keyframe in &self.keyframes[(newest + 1).saturating_sub(WINDOW)..] {
            let map_from_robot = reference.between(keyframe.world_from_robot);
            if map_from_robot.translation().norm() > WINDOW_RADIUS_M {
                continue;
            }
            for (p, normal) in keyframe.cloud.points.iter().zip(&keyframe.cloud.normals) {
                let mean = map_from_robot.transform_point(*p);
                if normal.norm_squared() > 0.0 && mean.norm_squared() < MAP_RADIUS_M * MAP_RADIUS_M {
                    points.push(Surfel { mean, normal: map_from_robot.rotate(*normal) });
                }
            }
        }
        self.map = SurfelMap::new(points);
    }
}

/// A scan as the matcher takes it.
pub(super) fn cloud(log: &RawLog, scan: usize, options: &Options) -> Cloud {
    let mut seen = Observations::default();
    observe(&log.scans[scan], log.robot_from_laser, options, &mut seen);
    Cloud {
        points: (0..seen.len()).map(|i| seen.point(i)).collect(),
        normals: (0..seen.len()).map(|i| seen.normal(i)).collect(),
    }
}

fn is_doubtful(found: &Match, expected: Pose2, step: Pose2) -> bool {
    found.inliers < FEWEST_INLIERS * found.covered
        || found.covered < LEAST_COVERED
        || step.translation().norm() > LONGEST_STEP.0
        || step.theta_rad.abs() > LONGEST_STEP.1
        || expected.between(found.pose).theta_rad.abs() > LARGEST_DISAGREEMENT_RAD
}

/// How far odometry is trusted over one scan period: isotropic, so that the frame does not matter.
fn step_information(step: Pose2) -> Matrix3<f64> {
    let (moved_m, turned_rad) = (step.translation().norm(), step.theta_rad.abs());
    let position_m = 0.01 + 0.1 * moved_m + 0.02 * turned_rad;
    let heading_rad = 0.01 + 0.1 * turned_rad + 0.02 * moved_m;
    Information::from_sigmas(position_m, position_m, heading_rad).matrix()
}

/// Ω of a matched step in the axes of its residual: what the scan says, less what it cannot know, plus odometry (which
/// alone speaks along a corridor).
fn factor_information(found: &Match, odometry: &Information) -> Information {
    let said = (found.hessian + Matrix3::identity() * 1e-6).cholesky().map(|c| c.inverse());
    let Some(covariance) = said else { return *odometry };
    let floor =
        Matrix3::from_diagonal(&Vector3::new(MODEL_SIGMA_M, MODEL_SIGMA_M, MODEL_SIGMA_RAD).map(|s| s * s));
    let Ok(matched) = Information::from_covariance(covariance + floor) else { return *odometry };
    let in_residual_axes = matched.rotated(-found.pose.theta_rad);
    Information::new(in_residual_axes.matrix() + odometry.matrix()).unwrap_or(*odometry)
}
