//! Generic sparse nonlinear least squares: min ½ Σₖ ρ(‖rₖ(x)‖²). Knows no poses, no maps.
//!
//! x is a list of blocks of three numbers; every term rₖ has at most three rows and depends on any number of blocks.
//! Gauss–Newton, damped where need be, on the normal equations H δ = −g, H = Σ ρ′ JᵀJ, g = Σ ρ′ Jᵀr, with a multifrontal
//! Cholesky factorisation in 3×3 blocks whose ordering and pattern are computed once. Results depend neither on the
//! machine's threads nor on its vector units.

mod clique;
mod covariance;
mod factor;
mod gnc;
mod incremental;
mod kernels;
mod lm;
mod loss;
mod normal_equations;
mod ordering;
mod pages;
mod polish;
mod profile;
mod report;
mod resolve;
mod simd;
mod step;
mod structure;

pub use covariance::Covariance;
pub use gnc::{Gnc, chi2_quantile_3};
pub use incremental::{Incremental, Laziness};
pub use lm::{Solver, minimize};
pub use loss::Loss;
pub(crate) use pages::make_room;
pub use profile::{Profile, kernel_gflops};
pub use report::{Iteration, Polish, Report, Termination, Timings};
pub use resolve::Resolver;
pub(crate) use simd::wide;

use nalgebra::{Matrix3, Vector3};

/// One block of x.
pub type Block = [f64; 3];

/// What to minimise.
pub trait Problem {
    /// Number of terms.
    fn terms(&self) -> usize;

    /// Appends the blocks that a term depends on, all different, in the order of [`Problem::linearize`].
    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>);

    /// The loss of a term.
    fn loss_of(&self, term: usize) -> Loss;

    /// r at x: 3×1, whitened; rows that a term does not have are zero.
    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64>;

    /// r at x with its Jacobians, into `at`, which comes cleared. A number of a block that no term has a slope along is
    /// padding and never moves.
    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization);

    /// What many terms need of x, worked out once: (cos, sin) of the third number of its blocks, or nothing.
    fn turns(&self, _x: &[Block], _turns: &mut Vec<[f64; 2]>) {}

    /// The same as [`Problem::linearize`] for a term on two blocks that knows its quadratic form at less cost than from
    /// Jacobians; false if it does not. `turns`: what [`Problem::turns`] gives, or empty. Leaves the loss to the solver.
    fn pair_quadratic(
        &self,
        _term: usize,
        _x: &[Block],
        _turns: &[[f64; 2]],
        _at: &mut PairQuadratic,
    ) -> bool {
        false
    }

    /// The same without JᵀJ.
    fn pair_gradient(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        self.pair_quadratic(term, x, turns, at)
    }
}

/// ‖r‖² of a term on two blocks, its gradient (½ of it) and JᵀJ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PairQuadratic {
    /// The two blocks.
    pub blocks: [usize; 2],
    /// ‖r‖².
    pub squared_norm: f64,
    /// J₀ᵀr and J₁ᵀr.
    pub gradient: [[f64; 3]; 2],
    /// J₀ᵀJ₀ and J₁ᵀJ₁: upper triangle, row by row.
    pub own: [[f64; 6]; 2],
    /// J₀ᵀJ₁, column-major.
    pub cross: [f64; 9],
}

impl PairQuadratic {
    /// Multiplies the cost.
    pub fn scale(&mut self, weight: f64) {
        let all =
            self.gradient.iter_mut().flatten().chain(self.own.iter_mut().flatten()).chain(&mut self.cross);
        all.chain([&mut self.squared_norm]).for_each(|v| *v *= weight);
    }

    /// Of a term on one block (which then stands twice) or two.
    fn from_jacobians(at: &Linearization) -> Self {
        let own = |j: &Matrix3<f64>| {
            let h = j.transpose() * j;
            [h[(0, 0)], h[(0, 1)], h[(0, 2)], h[(1, 1)], h[(1, 2)], h[(2, 2)]]
        };
        let gradient = |j: &Matrix3<f64>| {
            let g = j.transpose() * at.residual;
            [g[0], g[1], g[2]]
        };
        let mut pair = PairQuadratic { squared_norm: at.residual.norm_squared(), ..Default::default() };
        for (side, (block, j)) in at.jacobians.iter().take(2).enumerate() {
            pair.blocks[side] = *block;
            pair.gradient[side] = gradient(j);
            pair.own[side] = own(j);
        }
        match &at.jacobians[..] {
            [(_, a), (_, b), ..] => {
                let cross = a.transpose() * b;
                pair.cross = std::array::from_fn(|k| cross[(k % 3, k / 3)]);
            }
            [(block, _)] => pair.blocks[1] = *block,
            [] => {}
        }
        pair
    }
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
