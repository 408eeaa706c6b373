//! The whole pipeline on simulated maps with truth, and what the released implementation of the paper gets wrong.

mod accuracy;
mod contradictions;
mod faults;
mod invariance;
mod rejection;

use hitl_slam::geometry::Pose2;
use hitl_slam::map::{Correction, SlamMap, Trajectory};
use hitl_slam::metrics;
use hitl_slam::pipeline::{CorrectionReport, Corrector, Options};
use hitl_slam::simulate::{self, Scenario, Settings, Simulation};

/// A simulated run.
pub fn simulated(scenario: Scenario, seed: u64, drawing_noise_m: f64) -> Simulation {
    let settings = Settings { seed, drawing_noise_m, ..Settings::default() };
    simulate::run(scenario, &settings).expect("the scenario runs")
}

/// The map after all corrections, with their reports.
pub fn corrected(map: &SlamMap, corrections: &[Correction]) -> (SlamMap, Vec<CorrectionReport>) {
    let mut corrector = Corrector::new(map.clone(), Options::default()).expect("a map that can be corrected");
    let apply = |c: &Correction| corrector.apply(c).expect("strokes on the map");
    let reports = corrections.iter().map(apply).collect();
    (corrector.into_map(), reports)
}

/// ATE RMSE after SE(2) alignment, metres.
pub fn ate_m(map: &SlamMap, truth: &[Pose2]) -> f64 {
    let trajectory = |poses: &[Pose2]| Trajectory {
        stamps_s: (0..poses.len()).map(|k| k as f64).collect(),
        poses: poses.to_vec(),
    };
    let pairs: Vec<(usize, usize)> = (0..truth.len()).map(|k| (k, k)).collect();
    metrics::ate(&trajectory(&map.poses), &trajectory(truth), &pairs).expect("poses").rmse_m
}

/// Largest Mahalanobis distance of an edge from its factor, and largest translation error of an edge against truth.
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
