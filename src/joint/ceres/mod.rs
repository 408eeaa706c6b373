//! The joint problem on Ceres Solver, by automatic differentiation (`cpp/`).
//!
//! The same in every build: where Ceres was not there when the program was built, every call says so. Problems are
//! validated before Ceres sees them, since it aborts the process on some malformed ones. Nothing is printed: what
//! Ceres logs comes back in [`crate::solver::Report::warnings`].

#[cfg(ceres_linked)]
mod bridge;
#[cfg(ceres_linked)]
mod convert;
#[cfg(ceres_linked)]
mod linked;
#[cfg(ceres_linked)]
pub use linked::{evaluate, solve};

#[cfg(not(ceres_linked))]
mod absent;
#[cfg(not(ceres_linked))]
pub use absent::{evaluate, solve};

use crate::error::Error;

/// True if this build has Ceres.
pub const LINKED: bool = cfg!(ceres_linked);

/// How Ceres chooses its steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TrustRegion {
    /// Levenberg–Marquardt.
    #[default]
    LevenbergMarquardt,
    /// Powell's dogleg.
    Dogleg,
    /// Dogleg over the whole plane of gradient and Gauss–Newton step.
    SubspaceDogleg,
}

/// How Ceres solves its linear systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LinearSolver {
    /// Sparse normal equations, SuiteSparse's Cholesky.
    #[default]
    SparseNormalCholesky,
    /// Sparse normal equations, Eigen's Cholesky.
    SparseNormalCholeskyEigen,
    /// Dense normal equations: for small problems.
    DenseNormalCholesky,
    /// Dense QR: slow and steady, for small problems.
    DenseQr,
}

/// Choices that only Ceres has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// How it chooses its steps.
    pub trust_region: TrustRegion,
    /// How it solves its linear systems.
    pub linear_solver: LinearSolver,
}

/// Every term of a problem where it stands, as the C++ code sees it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Evaluation {
    /// r of every term in turn: three numbers each, rows that a term does not have zero. Whitened, before the loss.
    pub residuals: Vec<f64>,
    /// ∂r/∂block of every term and each of its blocks in turn: 3×3, row-major, columns that a block lacks zero.
    pub jacobians: Vec<f64>,
    /// ρ(s) and ρ′(s) of every term at s = ‖r‖².
    pub losses: Vec<[f64; 2]>,
    /// ½ Σ ρ by `ceres::Problem::Evaluate`.
    pub cost: f64,
}

/// The error of every build without Ceres.
pub(super) fn absence() -> Error {
    Error::input(
        "solver",
        format!(
            "found ceres, expected one of this program's back ends: {}. On Debian or Ubuntu: apt install libceres-dev, then build again with the default features",
            super::BACK_ENDS
        ),
    )
}
