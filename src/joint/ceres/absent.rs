//! Builds without Ceres: the same functions, all of which say so.

use super::{Evaluation, Options, absence};
use crate::error::Result;
use crate::joint::problem::JointProblem;
use crate::solver::{self, Report};

/// Every term of a problem, its Jacobians by automatic differentiation.
///
/// # Errors
/// Always [`crate::error::Error::Input`]: this build has no Ceres; first that of a malformed problem.
pub fn evaluate(problem: &JointProblem) -> Result<Evaluation> {
    problem.validate()?;
    Err(absence())
}

/// Minimises the problem in place.
///
/// # Errors
/// As [`evaluate`].
pub fn solve(problem: &mut JointProblem, _stopping: &solver::Options, _options: &Options) -> Result<Report> {
    problem.validate()?;
    Err(absence())
}
