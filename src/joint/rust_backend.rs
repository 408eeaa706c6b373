//! The joint problem on our own solver.

use super::problem::JointProblem;
use crate::error::Result;
use crate::solver::{self, Options, Report};

/// Minimises the problem in place.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed problem.
pub fn solve(problem: &mut JointProblem, options: &Options) -> Result<Report> {
    problem.validate()?;
    let mut x = problem.blocks();
    let report = solver::minimize(problem, &mut x, &problem.held, options)?;
    problem.set_blocks(&x);
    Ok(report)
}
