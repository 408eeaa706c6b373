//! How well each block is known: Σ = H⁻¹ at a minimum, column by column.

use nalgebra::Matrix3;

use super::cholesky::Factored;
use super::normal_equations::NormalEquations;
use super::{Block, Problem};
use crate::error::Result;

/// H at a point, factored. Every column of its inverse costs one pair of triangular solves.
pub struct Covariance {
    /// Unknown of each block, if it is free.
    unknown: Vec<Option<usize>>,
    factored: Factored,
}

impl Covariance {
    /// Factors H at x; `None` where something is not determined. `held` (ascending) are the blocks that do not move.
    ///
    /// # Errors
    /// [`crate::error::Error::Internal`] if the sparsity pattern cannot be analysed.
    pub fn new(problem: &dyn Problem, x: &[Block], held: &[usize]) -> Result<Option<Self>> {
        let mut equations = NormalEquations::new(problem, x.len(), held)?;
        equations.assemble(problem, x);
        Ok(equations.into_factored().map(|(unknown, factored)| Covariance { unknown, factored }))
    }

    /// Σ between `block` and each of `others`: 3×3, rows of the other, columns of the block. Held blocks have none.
    pub fn with(&self, block: usize, others: &[usize]) -> Vec<Matrix3<f64>> {
        let Some(column) = self.unknown[block] else { return vec![Matrix3::zeros(); others.len()] };
        let n = 3 * self.unknown.iter().flatten().count();
        let mut columns = vec![0.0; 3 * n];
        for k in 0..3 {
            columns[k * n + 3 * column + k] = 1.0;
        }
        self.factored.solve(&mut columns, 3);
        let entry = |&other: &usize| match self.unknown[other] {
            Some(row) => Matrix3::from_fn(|r, c| columns[c * n + 3 * row + r]),
            None => Matrix3::zeros(),
        };
        others.iter().map(entry).collect()
    }
}
