//! Simulated runs, corrected and measured.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use hitl_slam::map::{Correction, SlamMap};
use hitl_slam::pipeline::{CorrectionReport, Corrector, Options};
use hitl_slam::simulate::{self, Scenario, Settings, Simulation};

pub use crate::against_truth::{ate_m, largest_distance_m, worst_edges};
use crate::page::Result;

/// Real logs with hand-checked relations: name, log, relations.
pub const REAL_LOGS: [(&str, &str, &str); 2] = [
    ("Intel", "../shared/data/radish_raw/intel.clf.bz2", "../shared/data/radish_raw/intel.relations"),
    ("ACES", "data/aces.clf.bz2", "data/aces.relations"),
];

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
