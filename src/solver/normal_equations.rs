//! H = Σ ρ′ JᵀJ and g = Σ ρ′ Jᵀr, assembled straight into compressed columns of the lower triangle.

use nalgebra::{Matrix3, Vector3};

use super::cholesky::{Cholesky, Factored};
use super::{Block, Linearization, Problem};
use crate::error::Result;

/// Where a 3×3 block of H sits: its block row within its block column.
#[derive(Debug, Clone, Copy)]
struct Slot {
    column: usize,
    place: usize,
}

/// The normal equations of one problem structure. Held blocks do not appear in them (that is the gauge).
pub(super) struct NormalEquations {
    /// Unknown of each block, if it is free.
    unknown: Vec<Option<usize>>,
    /// Block columns: ascending block rows, the diagonal first.
    block_rows: Vec<Vec<usize>>,
    /// Off-diagonal slots: for each term in turn every pair of its blocks, (0, 1), (0, 2), … (1, 2), …; `None`
    /// where one of the two is held.
    slots: Vec<Option<Slot>>,
    /// Scalar entries of the diagonal that belong to padding: kept at one so that H stays regular.
    padding: Vec<usize>,
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    damped: Vec<f64>,
    /// g, 3 per unknown.
    pub gradient: Vec<f64>,
    cholesky: Cholesky,
}

impl NormalEquations {
    /// Analyses which blocks meet; `held` are the blocks that must not move.
    pub fn new(problem: &dyn Problem, blocks: usize, held: &[usize]) -> Result<Self> {
        let mut unknown: Vec<Option<usize>> = vec![None; blocks];
        let mut free = 0;
        for (block, slot) in unknown.iter_mut().enumerate() {
            if held.binary_search(&block).is_err() {
                *slot = Some(free);
                free += 1;
            }
        }
        let mut block_rows: Vec<Vec<usize>> = (0..free).map(|u| vec![u]).collect();
        let mut pairs = Vec::with_capacity(problem.terms());
        let mut touched = Vec::new();
        for term in 0..problem.terms() {
            touched.clear();
            problem.blocks_of(term, &mut touched);
            for (k, &a) in touched.iter().enumerate() {
                for &b in &touched[k + 1..] {
                    let pair = unknown[a].zip(unknown[b]).map(|(a, b)| (a.min(b), a.max(b)));
                    if let Some((column, row)) = pair {
                        block_rows[column].push(row);
                    }
                    pairs.push(pair);
                }
            }
        }
        for rows in &mut block_rows {
            rows.sort_unstable();
            rows.dedup();
        }
        let slot = |(column, row): (usize, usize)| {
            Some(Slot { column, place: block_rows[column].binary_search(&row).ok()? })
        };
        let slots = pairs.into_iter().map(|pair| pair.and_then(slot)).collect();
        let (column_starts, rows) = expand(&block_rows);
        let cholesky = Cholesky::new(&column_starts, &rows)?;
        let padding = (0..blocks)
            .filter_map(|block| Some((block, unknown[block]?)))
            .flat_map(|(block, u)| (problem.dimension(block)..3).map(move |k| 3 * u + k))
            .map(|scalar| column_starts[scalar])
            .collect();
        let values = vec![0.0; rows.len()];
        let damped = values.clone();
        Ok(NormalEquations {
            unknown,
            block_rows,
            slots,
            padding,
            column_starts,
            rows,
            values,
            damped,
            gradient: vec![0.0; 3 * free],
            cholesky,
        })
    }

    /// Number of free blocks.
    pub fn free_blocks(&self) -> usize {
        self.block_rows.len()
    }

    /// Fills H and g at x.
    pub fn assemble(&mut self, problem: &dyn Problem, x: &[Block]) {
        self.values.fill(0.0);
        self.gradient.fill(0.0);
        let mut slots = self.slots.iter().copied();
        let mut at = Linearization::default();
        let mut sums = Accumulator { values: &mut self.values, column_starts: &self.column_starts };
        for term in 0..problem.terms() {
            at.clear();
            problem.linearize(term, x, &mut at);
            let w = problem.loss_of(term).weight(at.residual.norm_squared());
            for (k, &(block, j)) in at.jacobians.iter().enumerate() {
                let jt = j.transpose() * w;
                let unknown = self.unknown[block];
                if let Some(u) = unknown {
                    sums.add(Slot { column: u, place: 0 }, &(jt * j));
                    let g: Vector3<f64> = jt * at.residual;
                    for row in 0..3 {
                        self.gradient[3 * u + row] += g[row];
                    }
                }
                for (other, j_other) in &at.jacobians[k + 1..] {
                    // The block below the diagonal: its row belongs to the larger unknown.
                    let Some(slot) = slots.next().flatten() else { continue };
                    let product = jt * j_other;
                    let swapped = unknown < self.unknown[*other];
                    sums.add(slot, &if swapped { product.transpose() } else { product });
                }
            }
        }
        for &diagonal in &self.padding {
            self.values[diagonal] = 1.0;
        }
    }

    /// δ with (H + λ D) δ = −g, or `None` if that matrix is not positive definite.
    ///
    /// D is the diagonal of H with the two position entries of each block replaced by their mean, so that the
    /// steps, and with them the result, do not depend on how the map is turned.
    pub fn step(&mut self, damping: f64) -> Option<Vec<f64>> {
        self.damped.copy_from_slice(&self.values);
        for block in 0..self.free_blocks() {
            let place = |k: usize| self.column_starts[3 * block + k];
            let d = [0, 1, 2].map(|k| self.values[place(k)]);
            let position = (d[0] + d[1]) / 2.0;
            for (k, scale) in [position, position, d[2]].into_iter().enumerate() {
                self.damped[place(k)] += damping * scale.max(1e-12);
            }
        }
        let mut delta: Vec<f64> = self.gradient.iter().map(|g| -g).collect();
        self.cholesky.solve(&self.column_starts, &self.rows, &self.damped, &mut delta).then_some(delta)
    }

    /// H as it stands, factored: all that covariances need. `None` if it is not positive definite.
    pub fn into_factored(self) -> Option<(Vec<Option<usize>>, Factored)> {
        let factored = self.cholesky.into_factored(&self.column_starts, &self.rows, &self.values)?;
        Some((self.unknown, factored))
    }

    /// x ⊕ δ: plain addition on every free block.
    pub fn moved(&self, x: &[Block], delta: &[f64]) -> Vec<Block> {
        let move_block = |(block, unknown): (&Block, &Option<usize>)| match unknown {
            Some(u) => [0, 1, 2].map(|k| block[k] + delta[3 * u + k]),
            None => *block,
        };
        x.iter().zip(&self.unknown).map(move_block).collect()
    }
}

/// The values of H while they are summed up.
struct Accumulator<'a> {
    values: &'a mut [f64],
    column_starts: &'a [usize],
}

impl Accumulator<'_> {
    fn add(&mut self, slot: Slot, block: &Matrix3<f64>) {
        for c in 0..3 {
            // Scalar column 3·column + c starts at its own diagonal entry: the diagonal block lacks its first c rows.
            let start = self.column_starts[3 * slot.column + c];
            if slot.place == 0 {
                for r in c..3 {
                    self.values[start + r - c] += block[(r, c)];
                }
            } else {
                let base = start + 3 * slot.place - c;
                for r in 0..3 {
                    self.values[base + r] += block[(r, c)];
                }
            }
        }
    }
}

/// Scalar compressed columns of a lower triangle of 3×3 blocks.
fn expand(block_rows: &[Vec<usize>]) -> (Vec<usize>, Vec<usize>) {
    let mut starts = vec![0];
    let mut rows = Vec::new();
    for blocks in block_rows {
        for c in 0..3 {
            let scalar_rows = blocks.iter().flat_map(|&b| 3 * b..3 * b + 3).skip(c);
            rows.extend(scalar_rows);
            starts.push(rows.len());
        }
    }
    (starts, rows)
}
