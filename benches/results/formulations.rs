//! The paper's residuals to the letter against the smooth form of the same objective.

use hitl_slam::joint::{Backend, Formulation};
use hitl_slam::map::SlamMap;
use hitl_slam::pipeline::{CorrectionReport, Options};
use hitl_slam::simulate::Scenario;

use crate::page::{Claim, Result, Section};
use crate::runs;
use crate::stats::Sample;

const SEEDS: u64 = 20;

/// A map after all corrections.
struct Outcome {
    ate_m: f64,
    iterations: Vec<f64>,
    not_converged: usize,
    /// Length after over length as interpreted, of every feature.
    stretch: Vec<f64>,
}

fn outcome(map: &SlamMap, reports: &[CorrectionReport], interpreted_m: &[f64], ate_m: f64) -> Outcome {
    let solves = || reports.iter().filter_map(|r| r.solve.as_ref());
    Outcome {
        ate_m,
        iterations: solves().map(|s| s.iterations.len() as f64).collect(),
        not_converged: solves().filter(|s| !s.termination.converged()).count(),
        stretch: lengths_m(map).iter().zip(interpreted_m).map(|(after, before)| after / before).collect(),
    }
}

fn lengths_m(map: &SlamMap) -> Vec<f64> {
    let features = map.human_factors.iter().flat_map(|f| [&f.a, &f.b]);
    features.map(|f| 2.0 * f.segment.half_length_m).collect()
}

pub fn section() -> Result<Section> {
    let mut section =
        Section { title: "The paper's residuals to the letter", name: "paper", ..Section::default() };
    let mut cases = vec![
        ("`smooth`, Rust", Formulation::Smooth, Backend::Rust),
        ("`paper`, Rust", Formulation::Paper, Backend::Rust),
    ];
    if Backend::Ceres.available() {
        cases.push(("`paper`, Ceres", Formulation::Paper, Backend::Ceres));
    }
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    let by_seed = runs::parallel(&seeds, |&seed| {
        let s = runs::simulated(Scenario::Loop, seed, 0.02)?;
        // `smooth` keeps every segment as long as EM found it.
        let mut interpreted_m = Vec::new();
        let mut outcomes = Vec::new();
        for &(_, formulation, backend) in &cases {
            let mut options = Options::default();
            options.joint.formulation = formulation;
            options.joint.backend = backend;
            let (map, reports) = runs::corrected(&s.map, &s.corrections, options)?;
            if formulation == Formulation::Smooth {
                interpreted_m = lengths_m(&map);
            }
            outcomes.push(outcome(&map, &reports, &interpreted_m, runs::ate_m(&map.poses, &s.truth)));
        }
        Ok((runs::ate_m(&s.map.poses, &s.truth), Sample::of(interpreted_m).mean(), outcomes))
    })?;
    let before = Sample::of(by_seed.iter().map(|(ate_m, _, _)| *ate_m));
    let drawn = Sample::of(by_seed.iter().map(|(_, length_m, _)| *length_m));
    section.body = format!(
        "`loop`, 2 cm, seeds 1–{SEEDS}, three corrections each; ATE before: {} m. Lengths: of a segment after all corrections, as a share \
         of what EM found (mean {:.2} m), median (smallest–largest).\n\n\
         | | iterations of a solve, median (range) | not converged | segment lengths after/before | ATE, m, mean ± 95 % (worst) |\n\
         |---|---|---|---|---|\n",
        before.with_interval(3),
        drawn.mean(),
    );
    let mut ate = Vec::new();
    for (k, (name, ..)) in cases.iter().enumerate() {
        let of_case = || by_seed.iter().map(|(_, _, outcomes)| &outcomes[k]);
        let iterations = Sample::of(of_case().flat_map(|o| o.iterations.clone()));
        let stretch = Sample::of(of_case().flat_map(|o| o.stretch.clone()));
        let errors = Sample::of(of_case().map(|o| o.ate_m));
        section.body += &format!(
            "| {name} | {} | {} of {} | {} | {} ({:.3}) |\n",
            iterations.with_range(0),
            of_case().map(|o| o.not_converged).sum::<usize>(),
            iterations.0.len(),
            stretch.with_range(2),
            errors.with_interval(3),
            errors.largest(),
        );
        ate.push(errors.mean());
    }
    section.body += "\nWhy: R_a is one residual for all points of a feature, so that Gauss–Newton knows its curvature along one direction only, and near \
                     its zero, where the root bends sharply, the linear model of that one holds over tiny steps: both solvers are damped and \
                     still descending after 50 steps (on seed 1 also after 500). The ends of a segment are free, so that segments stretch along their \
                     walls, where it costs next to nothing, and how much of a correction reaches the map depends on where the solver stopped.\n";
    section.claims.push(Claim {
        what: "loop, 2 cm: mean ATE, smooth".into(),
        measured: ate[0],
        bound: ate[1],
        unit: "m",
        decimals: 3,
        why: "the paper's residuals to the letter, same runs",
    });
    Ok(section)
}
