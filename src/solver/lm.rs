//! Levenberg–Marquardt, as prose: a step counts only if the true cost falls.

use std::time::Instant;

use super::normal_equations::NormalEquations;
use super::polish::polish;
use super::{Block, Iteration, Options, Problem, Report, Termination, cost};
use crate::error::Result;

/// λ below which the step is Gauss–Newton for all that doubles can tell.
const NEGLIGIBLE_DAMPING: f64 = 1e-15;
/// λ above which the step is so short that more damping cannot help.
const HOPELESS_DAMPING: f64 = 1e12;

/// Minimises the problem from `x`; `held` (ascending) are blocks that must not move.
/// `x` holds the best point found, whatever the termination.
///
/// # Errors
/// [`crate::error::Error::Internal`] if the sparsity pattern cannot be analysed.
pub fn minimize(
    problem: &dyn Problem,
    x: &mut Vec<Block>,
    held: &[usize],
    options: &Options,
) -> Result<Report> {
    let start = Instant::now();
    let mut report = Report::new(cost(problem, x), Termination::NotFinite);
    if !report.initial_cost.is_finite() {
        return Ok(report);
    }
    if problem.terms() == 0 || held.len() >= x.len() {
        report.termination = Termination::NothingToOptimize;
        return Ok(report);
    }
    let order = Instant::now();
    let mut equations = NormalEquations::new(problem, x.len(), held)?;
    report.timings.order_ms = milliseconds(order);
    let iterate = Instant::now();
    let mut damping = options.initial_damping;
    report.termination = loop {
        if report.accepted_steps() >= options.max_iterations {
            break Termination::MaxIterations;
        }
        equations.assemble(problem, x);
        match descend(problem, x, &mut equations, &mut damping, options, &mut report) {
            Some(termination) => break termination,
            None => continue,
        }
    };
    if report.termination != Termination::MaxIterations {
        report.polish = polish(problem, x, &mut equations, options, &mut report.final_cost);
        report.conclude_polish();
    }
    report.timings.iterate_ms = milliseconds(iterate);
    report.timings.total_ms = milliseconds(start);
    Ok(report)
}

/// Tries steps of growing damping until one lowers the cost; `Some` when it is time to stop.
fn descend(
    problem: &dyn Problem,
    x: &mut Vec<Block>,
    equations: &mut NormalEquations,
    damping: &mut f64,
    options: &Options,
    report: &mut Report,
) -> Option<Termination> {
    let gradient_max = equations.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    let mut factor = 10.0;
    loop {
        let Some(delta) = equations.step(*damping) else {
            raise(damping, &mut factor);
            if *damping > HOPELESS_DAMPING {
                return Some(Termination::NoProgress);
            }
            continue;
        };
        let step_max = delta.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
        // Of the linear model, at negligible damping: ½ δᵀ(−g).
        let promised = -0.5 * delta.iter().zip(&equations.gradient).map(|(d, g)| d * g).sum::<f64>();
        let rounding = promised <= options.relative_decrease * report.final_cost.max(f64::MIN_POSITIVE);
        if rounding || step_max <= options.step {
            return Some(if rounding { Termination::ConvergedCost } else { Termination::ConvergedStep });
        }
        let candidate = equations.moved(x, &delta);
        let candidate_cost = cost(problem, &candidate);
        let accepted = candidate_cost < report.final_cost;
        if accepted {
            *x = candidate;
            report.final_cost = candidate_cost;
        }
        report.iterations.push(Iteration {
            cost: report.final_cost,
            gradient_max,
            step_max,
            damping: *damping,
            accepted,
        });
        if accepted {
            *damping = (*damping / 10.0).max(NEGLIGIBLE_DAMPING);
            return None;
        }
        raise(damping, &mut factor);
        if *damping > HOPELESS_DAMPING {
            return Some(Termination::NoProgress);
        }
    }
}

/// λ after a refused step: times 10, times 100 after the next, and so on. A single jump would land so far above a weak
/// direction's scale that a handful of short steps are needed to come back.
fn raise(damping: &mut f64, factor: &mut f64) {
    *damping *= *factor;
    *factor *= 10.0;
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
