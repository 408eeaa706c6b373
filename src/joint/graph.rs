//! Plain pose graphs: relative factors only, human factors left out.

use super::compiled::Compiled;
use super::initialise::{Initialisation, initialise};
use super::{Backend, Options, build, gauge, rust_backend, take_over};
use crate::error::Result;
use crate::map::SlamMap;
use crate::solver::{Report, Solver};

/// What [`optimize_graph`] did.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphReport {
    /// Σ eᵀΩe before: no ½, no loss.
    pub initial_chi2: f64,
    /// Σ eᵀΩe after.
    pub final_chi2: f64,
    /// Where the optimisation began.
    pub initialisation: Initialisation,
    /// The solve.
    pub solve: Report,
}

/// Optimises the poses of a map over its relative and automatic factors alone. Held poses stay where they are.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed map or options out of range. Not to converge is no error.
pub fn optimize_graph(map: &mut SlamMap, options: &Options) -> Result<GraphReport> {
    options.validate()?;
    map.validate("graph")?;
    let mut problem = build(map, &map.poses, &[], options);
    problem.validate()?;
    let mut solver = Solver::new(&problem, problem.poses.len(), &problem.held);
    let graph = Compiled::new(&problem);
    let mut x = problem.blocks();
    let initial_chi2 = graph.chi2(&x);
    let initialisation = initialise(&graph, &mut x, &mut solver);
    let (mut solve, final_chi2) = match options.backend {
        Backend::Rust => {
            let report = rust_backend::solve_with(&mut solver, &graph, &mut x, &options.solver);
            let chi2 = graph.chi2(&x);
            problem.set_blocks(&x);
            (report, chi2)
        }
        Backend::Ceres => {
            problem.set_blocks(&x);
            (options.backend.solve(&mut problem, options)?, problem.chi2())
        }
    };
    solve.warnings.extend(gauge::warning(&map.held_or_first(), &problem.held));
    take_over(&problem, &mut map.poses, &mut []);
    Ok(GraphReport { initial_chi2, final_chi2, initialisation, solve })
}

/// Σ eᵀΩe over all relative factors: no ½, no loss.
pub(super) fn chi2(map: &SlamMap) -> f64 {
    map.every_relative_factor().map(|f| f.chi2(map.poses[f.i], map.poses[f.j])).sum()
}
