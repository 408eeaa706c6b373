//! How far two back ends are apart: term by term, and in their results.

use super::Place;
use crate::error::{Error, Result};
use crate::geometry::angle_diff;
use crate::joint::ceres;
use crate::joint::problem::JointProblem;
use crate::solver::{Linearization, Problem};

/// Below this cost (of squared standard deviations) a relative difference has no meaning: it is only rounding.
const NEGLIGIBLE_COST: f64 = 1e-6;

/// The largest differences of residuals and Jacobians, each with its place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Differences {
    /// |a − b| / max(1, |a|, |b|) of a residual.
    pub residual: (f64, Option<Place>),
    /// The same of an entry of a Jacobian.
    pub jacobian: (f64, Option<Place>),
}

impl Differences {
    /// Keeps the larger of each.
    pub fn worsen(&mut self, other: Differences) {
        keep_larger(&mut self.residual, other.residual.0, || other.residual.1);
        keep_larger(&mut self.jacobian, other.jacobian.0, || other.jacobian.1);
    }
}

/// Every residual and Jacobian of a problem where it stands, by both back ends.
///
/// # Errors
/// [`Error::Input`] for a malformed problem or a build without Ceres.
pub fn at(problem: &JointProblem) -> Result<Differences> {
    let theirs = ceres::evaluate(problem)?;
    let x = problem.blocks();
    let mut found = Differences::default();
    let mut residuals = theirs.residuals.chunks_exact(3);
    let mut jacobians = theirs.jacobians.chunks_exact(9);
    let mut ours = Linearization::default();
    for term in 0..problem.terms() {
        ours.clear();
        problem.linearize(term, &x, &mut ours);
        let place = |row: usize, block: Option<usize>, column: Option<usize>| {
            let (kind, index) = problem.kind_of(term)?;
            Some(Place { kind, index, row, block, column })
        };
        let residual = residuals.next().ok_or_else(too_short)?;
        for (row, (&ours, &theirs)) in ours.residual.iter().zip(residual).enumerate() {
            keep_larger(&mut found.residual, relative(ours, theirs), || place(row, None, None));
        }
        for (slot, (_, j)) in ours.jacobians.iter().enumerate() {
            let jacobian = jacobians.next().ok_or_else(too_short)?;
            for (k, &theirs) in jacobian.iter().enumerate() {
                let (row, column) = (k / 3, k % 3);
                let difference = relative(j[(row, column)], theirs);
                keep_larger(&mut found.jacobian, difference, || place(row, Some(slot), Some(column)));
            }
        }
    }
    if residuals.next().is_some() || jacobians.next().is_some() {
        return Err(Error::Internal("ceres: found more terms than the problem has".into()));
    }
    Ok(found)
}

/// Largest distance (metres) and angle (radians) between the poses of two results.
pub(super) fn poses(a: &JointProblem, b: &JointProblem) -> (f64, f64) {
    let pairs = || a.poses.iter().zip(&b.poses);
    let distance = |(p, q): (&[f64; 3], &[f64; 3])| (p[0] - q[0]).hypot(p[1] - q[1]);
    let angle = |(p, q): (&[f64; 3], &[f64; 3])| angle_diff(p[2], q[2]).abs();
    (pairs().map(distance).fold(0.0, larger), pairs().map(angle).fold(0.0, larger))
}

/// |a − b| over the larger of the two.
pub(super) fn costs(a: f64, b: f64) -> f64 {
    (a - b).abs() / larger(larger(a, b), NEGLIGIBLE_COST)
}

/// The larger of two; not a number if either is not, so that it can never pass for agreement.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn relative(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()).max(1.0) }
}

fn keep_larger(kept: &mut (f64, Option<Place>), difference: f64, place: impl FnOnce() -> Option<Place>) {
    if difference > kept.0 || (difference.is_nan() && !kept.0.is_nan()) || kept.1.is_none() {
        *kept = (difference, place());
    }
}

fn too_short() -> Error {
    Error::Internal("ceres: found fewer terms than the problem has".into())
}
