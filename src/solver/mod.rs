//! Generic sparse nonlinear least squares: min ½ Σₖ ρ(‖rₖ(x)‖²). Knows no poses, no maps.
//!
//! x is a list of blocks of three numbers; every term rₖ has at most three rows and depends on any number of blocks.
//! Levenberg–Marquardt on the normal equations H δ = −g, H = Σ ρ′ JᵀJ, g = Σ ρ′ Jᵀr, with a sparse Cholesky
//! factorisation whose ordering and pattern are computed once. Results do not depend on the machine's threads.

mod cholesky;
mod covariance;
mod gnc;
mod lm;
mod loss;
mod normal_equations;
mod polish;
mod report;

pub use covariance::Covariance;
pub use gnc::{Gnc, chi2_quantile_3};
pub use lm::minimize;
pub use loss::Loss;
pub use report::{Iteration, Polish, Report, Termination, Timings};

use nalgebra::{Matrix3, Vector3};

/// One block of x.
pub type Block = [f64; 3];

/// What to minimise.
pub trait Problem {
    /// Number of terms.
    fn terms(&self) -> usize;

    /// Appends the blocks that a term depends on, all different, in the order of [`Problem::linearize`].
    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>);

    /// How many numbers of a block are unknowns, 1 to 3; the rest is padding that never moves.
    fn dimension(&self, _block: usize) -> usize {
        3
    }

    /// The loss of a term.
    fn loss_of(&self, term: usize) -> Loss;

    /// r at x: 3×1, whitened; rows that a term does not have are zero.
    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64>;

    /// r at x with its Jacobians, into `at`, which comes cleared.
    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization);
}

/// A term at a point. One is reused for all terms, so that linearising allocates nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Linearization {
    /// r, whitened, 3×1.
    pub residual: Vector3<f64>,
    /// (block, ∂r/∂block): 3×3 each, rows as r, columns as the block; columns of padding are zero.
    pub jacobians: Vec<(usize, Matrix3<f64>)>,
}

impl Linearization {
    /// Ready for the next term.
    pub fn clear(&mut self) {
        self.residual = Vector3::zeros();
        self.jacobians.clear();
    }
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
