//! Where the time of a step goes, and what the machine would allow: measured, for docs/RESULTS.md.

use std::hint::black_box;
use std::time::Instant;

use super::kernels::downdate;
use super::simd::wide;
use super::{Block, Problem, Solver};

/// One pass each over a problem, ms: the fastest of several.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Profile {
    /// H and g.
    pub linearise_ms: f64,
    /// g alone.
    pub gradient_ms: f64,
    /// Factorisation, forward solve within.
    pub factor_ms: f64,
    /// Both triangular solves with a factor that is there.
    pub solve_ms: f64,
    /// Multiplications and additions of the factorisation, the zeros of merged supernodes among them.
    pub factor_flops: f64,
    /// Numbers that the factor takes, padding among them.
    pub factor_numbers: usize,
}

impl Solver {
    /// Factorisations so far, and solves with one that was kept.
    pub fn passes(&self) -> (usize, usize) {
        self.equations.factor.passes
    }

    /// Times each pass at x, so many times.
    pub fn profile(&mut self, problem: &dyn Problem, x: &[Block], rounds: usize) -> Profile {
        let equations = &mut self.equations;
        let mut profile = Profile {
            linearise_ms: fastest(rounds, || equations.assemble(problem, x)),
            gradient_ms: fastest(rounds, || equations.assemble_gradient(problem, x)),
            ..Profile::default()
        };
        equations.assemble(problem, x);
        profile.factor_ms = fastest(rounds, || equations.factor(problem, x, 0.0));
        equations.step();
        profile.solve_ms = fastest(rounds, || equations.step());
        for node in &equations.structure.supernodes {
            let (columns, below) = (3 * node.columns, 3 * (node.rows.1 - node.rows.0));
            let column = |k: usize| ((columns - k + below) as f64).powi(2);
            profile.factor_flops += (0..columns).map(column).sum::<f64>();
        }
        profile.factor_numbers = equations.structure.panel_len;
        profile
    }
}

/// 1e9 multiplications and additions a second of the update kernel alone, on numbers that stay in the first cache.
pub fn kernel_gflops() -> f64 {
    const ROWS: usize = 48;
    const COLUMNS: usize = 48;
    const CALLS: usize = 64;
    let panel = vec![1e-3; ROWS * COLUMNS];
    let mut update = vec![0.0; ROWS * ROWS];
    // The tiles on the diagonal are computed whole.
    let tiles = (0..ROWS).step_by(4).map(|j| 4 * (ROWS - j)).sum::<usize>();
    let ms = fastest(50, || {
        for _ in 0..CALLS {
            update_alone(black_box(&panel), ROWS, COLUMNS, black_box(&mut update));
        }
    });
    (CALLS * 2 * tiles * COLUMNS) as f64 / ms * 1e-6
}

wide! {
    fn update_alone(panel: &[f64], stride: usize, columns: usize, update: &mut [f64]) {
        downdate(panel, stride, 0, columns, update);
    }
}

fn fastest<T>(rounds: usize, mut job: impl FnMut() -> T) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..rounds.max(1) {
        let start = Instant::now();
        black_box(job());
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
    }
    best
}
