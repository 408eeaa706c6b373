//! Where the time of `optimize` goes, stage by stage: measured, for docs/RESULTS.md.

use std::time::Instant;

use super::compiled::Compiled;
use super::initialise::initialise;
use super::{Options, build, rust_backend};
use crate::error::Result;
use crate::map::SlamMap;
use crate::solver::{self, Solver};

/// Stages of [`super::optimize_graph`] with our solver, ms: the fastest of several rounds, in fresh memory each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GraphProfile {
    /// From the map to the problem, its check, the terms made ready.
    pub build_ms: f64,
    /// Fill-reducing ordering, symbolic analysis, where everything goes.
    pub order_ms: f64,
    /// Linear start: two linearisations, factorisations and solves, two costs.
    pub start_ms: f64,
    /// Gauss–Newton and the last digits.
    pub iterate_ms: f64,
    /// Steps tried, and steps for the last digits.
    pub steps: (usize, usize),
    /// Factorisations of the whole, and solves with one that was kept.
    pub passes: (usize, usize),
    /// A single step.
    pub step: solver::Profile,
}

/// Solves a plain graph stage by stage, so many times; the map stays as it is.
///
/// # Errors
/// As [`super::optimize_graph`].
pub fn profile_graph(map: &SlamMap, options: &Options, rounds: usize) -> Result<GraphProfile> {
    let mut best: Option<GraphProfile> = None;
    for _ in 0..rounds.max(1) {
        let mut clock = Instant::now();
        let mut lap = || {
            let ms = clock.elapsed().as_secs_f64() * 1e3;
            clock = Instant::now();
            ms
        };
        let problem = build(map, &map.poses, &[], options);
        problem.validate()?;
        let graph = Compiled::new(&problem);
        let mut x = problem.blocks();
        let build_ms = lap();
        let mut solver = Solver::new(&problem, x.len(), &problem.held);
        let order_ms = lap();
        initialise(&graph, &mut x, &mut solver);
        let start_ms = lap();
        let report = rust_backend::solve_with(&mut solver, &graph, &mut x, &options.solver);
        let iterate_ms = lap();
        let passes = solver.passes();
        let steps = (report.iterations.len(), report.polish.steps);
        let step = match &best {
            Some(best) => best.step,
            None => solver.profile(&graph, &x, 10 * rounds),
        };
        let now = GraphProfile { build_ms, order_ms, start_ms, iterate_ms, steps, passes, step };
        best = Some(best.map_or(now, |best| GraphProfile {
            build_ms: best.build_ms.min(build_ms),
            order_ms: best.order_ms.min(order_ms),
            start_ms: best.start_ms.min(start_ms),
            iterate_ms: best.iterate_ms.min(iterate_ms),
            ..best
        }));
    }
    best.ok_or_else(|| crate::error::Error::Internal("no round was measured".into()))
}
