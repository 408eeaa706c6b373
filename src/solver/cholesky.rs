//! Sparse LLᵀ by faer: fill-reducing ordering and pattern once, numbers as often as needed.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::error::{Error, Result};

/// A factorisation of one sparsity pattern, lower triangle, compressed columns.
pub(super) struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    work: MemBuffer,
}

impl Cholesky {
    /// Analyses the pattern of an n×n matrix.
    pub fn new(column_starts: &[usize], rows: &[usize]) -> Result<Self> {
        let failed = |e| Error::Internal(format!("sparse Cholesky: analysis failed: {e:?}"));
        // Chains with few loops: supernodes win at every size measured (docs/DECISIONS.md).
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(
            pattern(column_starts, rows),
            Side::Lower,
            SymmetricOrdering::Amd,
            params,
        )
        .map_err(failed)?;
        let need =
            symbolic
                .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
                .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let factor = vec![0.0; symbolic.len_val()];
        Ok(Cholesky { symbolic, factor, work: MemBuffer::new(need) })
    }

    /// Solves A x = b in place; false if A is not positive definite.
    pub fn solve(&mut self, column_starts: &[usize], rows: &[usize], values: &[f64], b: &mut [f64]) -> bool {
        let a = SparseColMatRef::new(pattern(column_starts, rows), values);
        let factored = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            a,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.work),
            Default::default(),
        );
        let Ok(llt) = factored else { return false };
        let n = b.len();
        let x = MatMut::from_column_major_slice_mut(b, n, 1);
        llt.solve_in_place_with_conj(Conj::No, x, Par::Seq, MemStack::new(&mut self.work));
        b.iter().all(|v| v.is_finite())
    }
}

fn pattern<'a>(column_starts: &'a [usize], rows: &'a [usize]) -> SymbolicSparseColMatRef<'a, usize> {
    let n = column_starts.len() - 1;
    SymbolicSparseColMatRef::new_checked(n, n, column_starts, None, rows)
}
