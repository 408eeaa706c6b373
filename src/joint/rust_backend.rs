//! The joint problem on our own solver.

use super::compiled::Compiled;
use super::memory::{Kept, Memory};
use super::problem::JointProblem;
use crate::error::Result;
use crate::solver::{Block, Options, Report, Solver};

/// Minimises the problem in place.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed problem.
pub fn solve(memory: &Memory, problem: &mut JointProblem, options: &Options) -> Result<Report> {
    problem.validate()?;
    let mut kept = memory.take();
    let Kept { solver, relatives, x } = &mut kept;
    problem.blocks_into(x);
    solver.analyse(problem, x.len(), &problem.held);
    let report = solve_with(solver, &Compiled::new_in(problem, relatives), x, options);
    problem.set_blocks(x);
    memory.keep(kept);
    Ok(report)
}

/// Minimises a valid problem from x with a solver made for its structure.
pub(super) fn solve_with(
    solver: &mut Solver,
    problem: &Compiled,
    x: &mut Vec<Block>,
    options: &Options,
) -> Report {
    let mut report = solver.minimize(problem, x, options);
    report.warnings.extend(undetermined(problem.problem(), &report.undetermined));
    report
}

/// Says which poses nothing determines.
fn undetermined(problem: &JointProblem, blocks: &[usize]) -> Option<String> {
    let poses: Vec<usize> = blocks.iter().copied().filter(|&b| b < problem.poses.len()).collect();
    let list: Vec<String> = poses.iter().take(8).map(usize::to_string).collect();
    let more = if poses.len() > list.len() { ", …" } else { "" };
    (!poses.is_empty())
        .then(|| format!("nothing determines pose {}{more}: left about where it was", list.join(", ")))
}
