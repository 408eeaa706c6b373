//! Simulated runs, corrected and measured.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use hitl_slam::geometry::Pose2;
use hitl_slam::map::{Correction, SlamMap, Trajectory};
use hitl_slam::metrics;
use hitl_slam::pipeline::{CorrectionReport, Corrector, Options};
use hitl_slam::simulate::{self, Scenario, Settings, Simulation};

use crate::page::Result;

pub fn simulated(scenario: Scenario, seed: u64, drawing_noise_m: f64) -> Result<Simulation> {
    Ok(simulate::run(scenario, &Settings { seed, drawing_noise_m, ..Settings::default() })?)
}

/// The map after all corrections, with their reports.
pub fn corrected(
    map: &SlamMap,
    corrections: &[Correction],
    options: Options,
) -> Result<(SlamMap, Vec<CorrectionReport>)> {
    let mut corrector = Corrector::new(map.clone(), options)?;
    let mut reports = Vec::with_capacity(corrections.len());
    for correction in corrections {
        reports.push(corrector.apply(correction)?);
    }
    Ok((corrector.into_map(), reports))
}

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

/// `work` for every job, on all cores; results in the order of the jobs.
pub fn parallel<J: Sync, R: Send>(jobs: &[J], work: impl Fn(&J) -> Result<R> + Sync) -> Result<Vec<R>> {
    let next = AtomicUsize::new(0);
    let worker = || -> Result<Vec<(usize, R)>> {
        let mut done = Vec::new();
        while let Some((k, job)) =
            Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|k| Some((k, jobs.get(k)?)))
        {
            done.push((k, work(job)?));
        }
        Ok(done)
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let mut all = thread::scope(|scope| -> Result<Vec<(usize, R)>> {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(worker)).collect();
        let mut all = Vec::with_capacity(jobs.len());
        for worker in workers {
            all.extend(worker.join().map_err(|_| "a worker panicked")??);
        }
        Ok(all)
    })?;
    all.sort_by_key(|(k, _)| *k);
    Ok(all.into_iter().map(|(_, result)| result).collect())
}
