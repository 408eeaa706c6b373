//! How far poses are from the truth; benches/results measures with the same.

use hitl_slam::geometry::Pose2;
use hitl_slam::map::{SlamMap, Trajectory};
use hitl_slam::metrics;

/// ATE RMSE after SE(2) alignment, metres.
pub fn ate_m(poses: &[Pose2], truth: &[Pose2]) -> f64 {
    let trajectory = |poses: &[Pose2]| Trajectory {
        stamps_s: (0..poses.len()).map(|k| k as f64).collect(),
        poses: poses.to_vec(),
    };
    let pairs: Vec<(usize, usize)> = (0..truth.len()).map(|k| (k, k)).collect();
    metrics::ate(&trajectory(poses), &trajectory(truth), &pairs).map_or(f64::NAN, |a| a.rmse_m)
}

/// Largest Mahalanobis distance of an edge from its factor; largest translation error of an edge against truth, metres.
pub fn worst_edges(map: &SlamMap, truth: &[Pose2]) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for f in &map.relative_factors {
        worst.0 = worst.0.max(f.chi2(map.poses[f.i], map.poses[f.j]).sqrt());
        let error = truth[f.i].between(truth[f.j]).between(map.poses[f.i].between(map.poses[f.j]));
        worst.1 = worst.1.max(error.translation().norm());
    }
    worst
}

/// Largest distance between the positions of two lists of poses, metres.
pub fn largest_distance_m(a: &[Pose2], b: &[Pose2]) -> f64 {
    a.iter().zip(b).map(|(p, q)| (p.translation() - q.translation()).norm()).fold(0.0, f64::max)
}
