//! Generic sparse nonlinear least squares: min ½ Σₖ ρ(‖rₖ(x)‖²). Knows no poses, no maps.
//!
//! x is a list of blocks of three numbers; every term rₖ has at most three rows and depends on two blocks at most.
//! Levenberg–Marquardt on the normal equations H δ = −g, H = Σ ρ′ JᵀJ, g = Σ ρ′ Jᵀr, with a sparse Cholesky
//! factorisation whose ordering and pattern are computed once. Results do not depend on the machine's threads.

mod cholesky;
mod lm;
mod loss;
mod normal_equations;
mod report;

pub use lm::minimize;
pub use loss::Loss;
pub use report::{Iteration, Report, Termination};

use nalgebra::{Matrix3, Vector3};

/// One block of x.
pub type Block = [f64; 3];

/// What to minimise.
pub trait Problem {
    /// Number of terms.
    fn terms(&self) -> usize;

    /// The two blocks that a term depends on; must differ.
    fn blocks_of(&self, term: usize) -> (usize, usize);

    /// The loss of a term.
    fn loss_of(&self, term: usize) -> Loss;

    /// r at x: 3×1, whitened; rows that a term does not have are zero.
    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64>;

    /// r at x with its Jacobians: 3×3 each, rows as r, columns as the block.
    fn linearize(&self, term: usize, x: &[Block]) -> Linearization;
}

/// A term at a point.
#[derive(Debug, Clone, Copy)]
pub struct Linearization {
    /// r, whitened, 3×1.
    pub residual: Vector3<f64>,
    /// ∂r/∂(first block), 3×3.
    pub j_first: Matrix3<f64>,
    /// ∂r/∂(second block), 3×3.
    pub j_second: Matrix3<f64>,
}

/// When to stop and how to damp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// At most so many accepted steps.
    pub max_iterations: usize,
    /// Converged when a step promises to lower the cost by less than this share of it.
    pub relative_decrease: f64,
    /// Converged when no entry of a step is larger (metres, radians).
    pub step: f64,
    /// Damping λ of the first step; H + λ·diag(H).
    pub initial_damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        // 1e-13 of the cost is where rounding of a sum of some 1e4 terms begins; 1e-9 m is far below any sensor.
        Options { max_iterations: 50, relative_decrease: 1e-13, step: 1e-9, initial_damping: 1e-9 }
    }
}

/// ½ Σ ρ(‖r‖²) at x.
pub fn cost(problem: &dyn Problem, x: &[Block]) -> f64 {
    let term_cost = |k: usize| problem.loss_of(k).rho(problem.residual(k, x).norm_squared());
    0.5 * (0..problem.terms()).map(term_cost).sum::<f64>()
}
