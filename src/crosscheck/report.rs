//! What a cross-check found, as data. The fields of [`Totals`] are those of docs/FORMATS.md.

use super::compare::larger;
use crate::joint::Formulation;
use crate::joint::problem::TermKind;
use crate::solver;

/// The differences of one correction, or the largest of all with the sums of times and iterations.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Totals {
    /// |a − b| / max(1, |a|, |b|).
    pub max_residual_difference: f64,
    /// The same for every entry of a Jacobian.
    pub max_jacobian_difference: f64,
    /// Between the two results, metres.
    pub max_pose_difference_m: f64,
    /// Between the two results, radians.
    pub max_angle_difference_rad: f64,
    /// |a − b| over the larger final cost (over 1e-6 if both are smaller).
    pub relative_cost_difference: f64,
    /// Wall-clock time of the Rust solve.
    pub rust_ms: f64,
    /// Wall-clock time of the Ceres solve, with its copies.
    pub ceres_ms: f64,
    /// Steps tried.
    pub rust_iterations: usize,
    /// Steps tried.
    pub ceres_iterations: usize,
}

/// Where a number sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Place {
    /// Kind of the term.
    pub kind: TermKind,
    /// Which of its kind, from 0.
    pub index: usize,
    /// Row of the residual, from 0.
    pub row: usize,
    /// For Jacobians: which of the term's blocks, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub block: Option<usize>,
    /// For Jacobians: column within the block.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
}

/// One correction on both back ends.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Check {
    /// The correction's name.
    pub id: String,
    /// The numbers.
    #[serde(flatten)]
    pub totals: Totals,
    /// True if they are within the contract's limits.
    pub agree: bool,
    /// Why the correction was not applied, and so not compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rejected: Option<String>,
    /// Where the largest difference of residuals sits.
    pub worst_residual: Option<Place>,
    /// Where the largest difference of Jacobians sits.
    pub worst_jacobian: Option<Place>,
    /// The Rust solve.
    #[serde(skip)]
    pub rust: Option<solver::Report>,
    /// The Ceres solve.
    #[serde(skip)]
    pub ceres: Option<solver::Report>,
}

impl Check {
    /// A correction that never came to a solve: there is nothing to disagree on.
    pub(super) fn rejected(id: &str, reason: Option<String>) -> Self {
        Check {
            id: id.into(),
            totals: Totals::default(),
            agree: true,
            rejected: reason.or_else(|| Some("rejected".into())),
            worst_residual: None,
            worst_jacobian: None,
            rust: None,
            ceres: None,
        }
    }
}

/// All corrections.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CrossCheck {
    /// True if every correction agrees.
    pub agree: bool,
    /// Which objective.
    pub formulation: Formulation,
    /// Over all corrections.
    pub total: Totals,
    /// One by one.
    pub corrections: Vec<Check>,
}

impl CrossCheck {
    pub(super) fn new(formulation: Formulation, corrections: Vec<Check>) -> Self {
        let total = corrections.iter().fold(Totals::default(), |sum, check| sum.with(&check.totals));
        CrossCheck { agree: corrections.iter().all(|c| c.agree), formulation, total, corrections }
    }
}

impl Totals {
    /// The larger of all differences, the sum of times and iterations.
    fn with(self, t: &Totals) -> Totals {
        Totals {
            max_residual_difference: larger(self.max_residual_difference, t.max_residual_difference),
            max_jacobian_difference: larger(self.max_jacobian_difference, t.max_jacobian_difference),
            max_pose_difference_m: larger(self.max_pose_difference_m, t.max_pose_difference_m),
            max_angle_difference_rad: larger(self.max_angle_difference_rad, t.max_angle_difference_rad),
            relative_cost_difference: larger(self.relative_cost_difference, t.relative_cost_difference),
            rust_ms: self.rust_ms + t.rust_ms,
            ceres_ms: self.ceres_ms + t.ceres_ms,
            rust_iterations: self.rust_iterations + t.rust_iterations,
            ceres_iterations: self.ceres_iterations + t.ceres_iterations,
        }
    }
}
