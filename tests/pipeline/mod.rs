//! The whole pipeline on simulated maps with truth, and what the released implementation of the paper gets wrong.

mod accuracy;
mod contradictions;
mod faults;
mod invariance;
mod rejection;

use hitl_slam::map::{Correction, SlamMap};
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
