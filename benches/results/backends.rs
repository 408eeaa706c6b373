//! Time of both solvers on the same problems, one after the other in one run.

use hitl_slam::crosscheck;
use hitl_slam::joint::Backend;
use hitl_slam::pipeline::Options;
use hitl_slam::simulate::Scenario;

use crate::page::{Claim, Result, Section};
use crate::runs;
use crate::stats::Sample;

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Time of both solvers", name: "backends", ..Section::default() };
    if !Backend::Ceres.available() {
        section.body = "skipped: built without Ceres\n".into();
        return Ok(section);
    }
    section.body = "Joint optimisation of one correction, ms: median (smallest–largest) over all corrections of seed 1, repeated; both \
                    solvers take turns on the same problem, one thread each. In Ceres' time are its copies and its preprocessing, in both the \
                    last Gauss–Newton steps (docs/MATH.md, Solver). Iterations: steps tried, mean.\n\n\
                    | | samples | Rust | Ceres | Ceres/Rust | iterations, Rust | iterations, Ceres |\n|---|---|---|---|---|---|---|\n"
        .into();
    for (scenario, repetitions, bound, why) in [
        (Scenario::Loop, 20, 1.0, "Ceres, same problems, same run"),
        (Scenario::Campus, 12, 0.05, "issue: 20 times faster than our Ceres back end"),
    ] {
        let s = runs::simulated(scenario, 1, 0.02)?;
        let mut checks = Vec::new();
        for _ in 0..repetitions {
            checks.extend(crosscheck::run(s.map.clone(), &s.corrections, &Options::default())?.corrections);
        }
        let rust = Sample::of(checks.iter().map(|c| c.totals.rust_ms));
        let ceres = Sample::of(checks.iter().map(|c| c.totals.ceres_ms));
        let ratio = Sample::of(checks.iter().map(|c| c.totals.ceres_ms / c.totals.rust_ms));
        let iterations = |count: fn(&crosscheck::Totals) -> usize| {
            Sample::of(checks.iter().map(|c| count(&c.totals) as f64)).mean()
        };
        let poses = s.map.poses.len();
        section.body += &format!(
            "| {poses} poses | {} | {} | {} | {} | {:.1} | {:.1} |\n",
            checks.len(),
            rust.with_range(2),
            ceres.with_range(2),
            ratio.with_range(2),
            iterations(|t| t.rust_iterations),
            iterations(|t| t.ceres_iterations),
        );
        section.claims.push(Claim {
            what: format!("{poses} poses: our time of a joint optimisation, share of Ceres' (median)"),
            measured: 1.0 / ratio.median(),
            bound,
            unit: "",
            decimals: 3,
            why,
        });
        let apart = checks.iter().map(|c| c.totals.relative_cost_difference).fold(0.0, f64::max);
        section.claims.push(Claim {
            what: format!("{poses} poses: final costs of the two on these problems differ by"),
            measured: apart,
            bound: 1e-8,
            unit: "",
            decimals: 0,
            why: "issue",
        });
    }
    Ok(section)
}
