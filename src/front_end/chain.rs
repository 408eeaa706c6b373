//! Keyframes by motion: the chain of the log's own poses, thinned out.

use super::{Options, Skeleton};
use crate::geometry::{Pose2, angle_diff};
use crate::map::{LogScan, RawLog, RelativeFactor, ScanRecord};

/// A keyframe whenever the robot has moved or turned enough since the last one; the first scan is one. Scans hang on
/// the latest keyframe before them in the file, by the same poses.
pub(super) fn by_motion(log: &RawLog, pose_of: impl Fn(&LogScan) -> Pose2, options: &Options) -> Skeleton {
    let scans: Vec<(usize, Pose2)> = log.scans.iter().map(&pose_of).enumerate().collect();
    let keyframes = keyframes(&scans, options);
    let mut skeleton = skeleton_of(log, &keyframes, options);
    let mut parent = 0;
    for (index, &(_, pose)) in scans.iter().enumerate() {
        if keyframes.get(parent + 1).is_some_and(|&(scan, _)| scan == index) {
            parent += 1;
        }
        skeleton.scans.push(ScanRecord {
            stamp_s: log.scans[index].stamp_s,
            parent,
            parent_from_robot: keyframes[parent].1.between(pose),
        });
    }
    skeleton
}

/// Those of the (scan, pose) pairs that are a keyframe.
pub(super) fn keyframes(scans: &[(usize, Pose2)], options: &Options) -> Vec<(usize, Pose2)> {
    let mut keyframes: Vec<(usize, Pose2)> = Vec::new();
    for &(scan, pose) in scans {
        let is_far = keyframes.last().is_none_or(|(_, last)| {
            (pose.translation() - last.translation()).norm() >= options.keyframe_distance_m
                || angle_diff(pose.theta_rad, last.theta_rad).abs() >= options.keyframe_angle_rad
        });
        if is_far {
            keyframes.push((scan, pose));
        }
    }
    keyframes
}

/// Poses and the factors between consecutive ones; the scans are still to be hung.
pub(super) fn skeleton_of(log: &RawLog, keyframes: &[(usize, Pose2)], options: &Options) -> Skeleton {
    let factor = |i: usize| {
        let i_from_j = keyframes[i].1.between(keyframes[i + 1].1);
        let information = options.odometry_noise.information(i_from_j);
        RelativeFactor { i, j: i + 1, i_from_j, information }
    };
    Skeleton {
        poses: keyframes.iter().map(|k| k.1).collect(),
        stamps_s: keyframes.iter().map(|k| log.scans[k.0].stamp_s).collect(),
        scan_of_pose: keyframes.iter().map(|k| Some(k.0)).collect(),
        vertex_ids: None,
        held: Vec::new(),
        relative_factors: (0..keyframes.len().saturating_sub(1)).map(factor).collect(),
        scans: Vec::with_capacity(log.scans.len()),
    }
}
