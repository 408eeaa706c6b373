//! Builds with Ceres: validate, copy in, call, copy out.

use super::bridge::ffi;
use super::{Evaluation, Options, convert};
use crate::error::{Error, Result};
use crate::joint::problem::JointProblem;
use crate::solver::{self, Iteration, Polish, Problem, Report, Termination, Timings};

/// Ceres' own numbers of `ceres::TerminationType`, checked in C++.
const CONVERGENCE: u8 = 0;
const FAILURE: u8 = 2;

/// Every term of a problem, its Jacobians by automatic differentiation.
///
/// # Errors
/// [`Error::Input`] for a malformed problem; [`Error::Internal`] if Ceres cannot evaluate it.
pub fn evaluate(problem: &JointProblem) -> Result<Evaluation> {
    problem.validate()?;
    let found = ffi::evaluate(&convert::problem(problem)).map_err(fault)?;
    Ok(Evaluation {
        residuals: found.residuals,
        jacobians: found.jacobians,
        losses: found.losses.chunks_exact(2).map(|l| [l[0], l[1]]).collect(),
        cost: found.cost,
    })
}

/// Minimises the problem in place; it is left as it was if Ceres has no usable solution.
///
/// # Errors
/// [`Error::Input`] for a malformed problem; [`Error::Internal`] for options that Ceres refuses. Not to converge is no
/// error: the report says so.
pub fn solve(problem: &mut JointProblem, stopping: &solver::Options, options: &Options) -> Result<Report> {
    problem.validate()?;
    let x = problem.blocks();
    let initial_cost = solver::cost(problem, &x);
    if !initial_cost.is_finite() {
        return Ok(Report::new(initial_cost, Termination::NotFinite));
    }
    if problem.terms() == 0 || problem.held.len() >= x.len() {
        return Ok(Report::new(initial_cost, Termination::NothingToOptimize));
    }
    let size = x.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
    let chosen = convert::options(stopping, options, size);
    let solution = ffi::solve(&convert::problem(problem), &chosen).map_err(fault)?;
    let mut report = Report::new(solution.initial_cost, termination(&solution, stopping));
    report.final_cost = solution.final_cost;
    report.iterations = iterations(&solution.iterations);
    report.timings = Timings {
        order_ms: solution.preprocess_ms,
        iterate_ms: solution.minimize_ms,
        total_ms: solution.total_ms,
    };
    report.polish = Polish {
        steps: solution.polish_steps,
        last_step: solution.polish_last_step,
        settled: solution.polish_settled,
    };
    report.conclude_polish();
    report.warnings.extend(solution.log.iter().map(|line| format!("ceres: {line}")));
    if solution.usable {
        take(&mut problem.poses, &solution.poses);
        take(&mut problem.segments, &solution.segments);
        take(problem.ends.as_flattened_mut(), &solution.ends);
    } else {
        report.final_cost = report.initial_cost;
        report.warnings.push(format!("ceres: no usable solution: {}", solution.message));
    }
    Ok(report)
}

/// Rows as our own solver gives them: Ceres' gradient is that after a step, its row 0 is the start.
fn iterations(rows: &[ffi::Iteration]) -> Vec<Iteration> {
    let mut cost = rows.first().map_or(f64::NAN, |r| r.cost);
    let mut table = Vec::with_capacity(rows.len());
    for pair in rows.windows(2) {
        let (before, row) = (&pair[0], &pair[1]);
        if row.successful {
            cost = row.cost;
        }
        table.push(Iteration {
            cost,
            gradient_max: before.gradient_max,
            step_max: row.step_norm,
            damping: 1.0 / before.radius,
            accepted: row.successful,
        });
    }
    table
}

/// Ceres gives a class and a sentence; the sentence says which of its tolerances was met.
fn termination(solution: &ffi::Solution, stopping: &solver::Options) -> Termination {
    let says = |words| solution.message.contains(words);
    let accepted = solution.iterations.iter().skip(1).filter(|i| i.successful).count();
    match solution.termination {
        FAILURE => Termination::NoProgress,
        CONVERGENCE if says("Gradient tolerance") => Termination::ConvergedGradient,
        CONVERGENCE if says("Parameter tolerance") => Termination::ConvergedStep,
        CONVERGENCE if says("Function tolerance") => Termination::ConvergedCost,
        // "Minimum trust region radius reached": no step made the cost fall.
        CONVERGENCE => Termination::NoProgress,
        _ if accepted >= stopping.max_iterations => Termination::MaxIterations,
        _ => Termination::NoProgress,
    }
}

fn take<const N: usize>(blocks: &mut [[f64; N]], solved: &[f64]) {
    for (block, numbers) in blocks.iter_mut().zip(solved.chunks_exact(N)) {
        block.copy_from_slice(numbers);
    }
}

fn fault(exception: cxx::Exception) -> Error {
    Error::Internal(format!("ceres: {}", exception.what()))
}
