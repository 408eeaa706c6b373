//! How certain the poses are: marginal covariances of the joint problem where it stands.

use nalgebra::Matrix3;

use super::compiled::Compiled;
use super::problem::JointProblem;
use super::{Options, build};
use crate::error::Result;
use crate::map::SlamMap;
use crate::solver::Solver;

/// Covariance of every pose, 3×3, order (x, y, θ), in world axes, given the held poses: the diagonal blocks of the inverse
/// of the Gauss–Newton Hessian. Zero for held poses. Meant at a minimum.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed problem.
pub fn marginal_covariances(problem: &JointProblem) -> Result<Vec<Matrix3<f64>>> {
    problem.validate()?;
    let x = problem.blocks();
    let mut solver = Solver::new(problem, x.len(), &problem.held);
    let mut covariances = solver.marginal_covariances(&Compiled::new(problem), &x);
    covariances.truncate(problem.poses.len());
    Ok(covariances)
}

/// The same for a map as it stands, with its human factors.
///
/// # Errors
/// As [`marginal_covariances`].
pub fn map_covariances(map: &SlamMap, options: &Options) -> Result<Vec<Matrix3<f64>>> {
    marginal_covariances(&build(map, &map.poses, &map.human_factors, options))
}

/// 1σ radius of a pose's position: the larger half-axis of its ellipse, metres.
pub fn position_sigma_m(covariance: &Matrix3<f64>) -> f64 {
    let (a, b, d) = (covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]);
    ((a + d) / 2.0 + ((a - d) / 2.0).hypot(b)).max(0.0).sqrt()
}
