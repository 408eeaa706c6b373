//! Sparse LLᵀ by faer: fill-reducing ordering and pattern once, numbers as often as needed.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
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

/// A factorisation that is done, for any number of right-hand sides on any number of threads.
pub(super) struct Factored {
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
}

impl Cholesky {
    /// Factors A for good; `None` if it is not positive definite.
    pub fn into_factored(
        mut self,
        column_starts: &[usize],
        rows: &[usize],
        values: &[f64],
    ) -> Option<Factored> {
        let mut nothing = vec![0.0; column_starts.len() - 1];
        let is_definite = self.solve(column_starts, rows, values, &mut nothing);
        is_definite.then_some(Factored { symbolic: self.symbolic, factor: self.factor })
    }
}

impl Factored {
    /// Solves A X = B in place; B has `columns` columns, one after the other.
    pub fn solve(&self, b: &mut [f64], columns: usize) {
        let need = self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
        let mut work = MemBuffer::new(need);
        let llt = LltRef::new(&self.symbolic, &self.factor);
        let x = MatMut::from_column_major_slice_mut(b, self.symbolic.nrows(), columns);
        llt.solve_in_place_with_conj(Conj::No, x, Par::Seq, MemStack::new(&mut work));
    }
}

fn pattern<'a>(column_starts: &'a [usize], rows: &'a [usize]) -> SymbolicSparseColMatRef<'a, usize> {
    let n = column_starts.len() - 1;
    SymbolicSparseColMatRef::new_checked(n, n, column_starts, None, rows)
}
