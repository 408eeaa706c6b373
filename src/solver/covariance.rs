//! Covariances H⁻¹ without inverting H: the blocks on the pattern of L by the recursion of Takahashi (Takahashi, Fagan & Chin
//! 1973; Erisman & Tinney 1975), supernode by supernode from the root down; any other block by a solve.

use nalgebra::{Matrix3, Vector3};

use super::factor::Factor;
use super::normal_equations::NormalEquations;
use super::structure::{NONE, Structure, Supernode};
use super::{Block, Problem, Solver};

impl Solver {
    /// Marginal covariance of every block, 3×3, where the problem stands at `x`: the diagonal blocks of (Σ ρ′ JᵀJ)⁻¹. Zero for
    /// held blocks. Of a block that nothing determines it means nothing.
    pub fn marginal_covariances(&mut self, problem: &dyn Problem, x: &[Block]) -> Vec<Matrix3<f64>> {
        self.equations.assemble(problem, x);
        self.equations.factor(problem, x, 0.0);
        self.equations.marginals(x.len())
    }
}

/// H at a point, factored: any column of its inverse costs one pair of triangular solves.
#[derive(Debug, Clone)]
pub struct Covariance {
    equations: NormalEquations,
}

impl Covariance {
    /// Factors H at x; `None` where something is not determined. `held` (ascending) are the blocks that do not move.
    pub fn new(problem: &dyn Problem, x: &[Block], held: &[usize]) -> Option<Self> {
        let mut equations = NormalEquations::default();
        equations.analyse(problem, x.len(), held);
        equations.assemble(problem, x);
        equations.factor(problem, x, 0.0);
        equations.undetermined().is_empty().then_some(Covariance { equations })
    }

    /// Σ between `block` and each of `others`: 3×3, rows of the other, columns of the block. Zero where one is held.
    pub fn with(&mut self, block: usize, others: &[usize]) -> Vec<Matrix3<f64>> {
        self.equations.covariance_columns(block, others)
    }
}

impl NormalEquations {
    fn marginals(&self, blocks: usize) -> Vec<Matrix3<f64>> {
        let by_column = self.factor.diagonal_of_inverse(&self.structure);
        (0..blocks).map(|b| self.column(b).map_or(Matrix3::zeros(), |c| by_column[c])).collect()
    }

    /// Rows `rows` of the three columns of H⁻¹ that belong to `block`.
    fn covariance_columns(&mut self, block: usize, rows: &[usize]) -> Vec<Matrix3<f64>> {
        let mut result = vec![Matrix3::zeros(); rows.len()];
        let Some(column) = self.column(block) else { return result };
        for k in 0..3 {
            let mut x = vec![0.0; 3 * self.structure.supernode_of.len()];
            x[3 * column + k] = 1.0;
            self.factor.solve(&self.structure, &mut x);
            for (result, &row) in result.iter_mut().zip(rows) {
                if let Some(row) = self.column(row) {
                    result.set_column(k, &Vector3::new(x[3 * row], x[3 * row + 1], x[3 * row + 2]));
                }
            }
        }
        result
    }
}

/// Rows of a supernode's front that are not padding, as indices into its panel's rows.
fn front_rows(node: &Supernode) -> Vec<usize> {
    let below = node.rows.1 - node.rows.0;
    (0..3 * node.columns).chain(node.own..node.own + 3 * below).collect()
}

impl Factor {
    /// The diagonal blocks of (LLᵀ)⁻¹, by block column.
    fn diagonal_of_inverse(&self, structure: &Structure) -> Vec<Matrix3<f64>> {
        let mut diagonal = vec![Matrix3::zeros(); structure.supernode_of.len()];
        // The inverse on the rows of a supernode, dense, as long as a child needs it.
        let mut fronts: Vec<Vec<f64>> = vec![Vec::new(); structure.supernodes.len()];
        let mut waiting: Vec<usize> =
            structure.supernodes.iter().map(|s| s.children.1 - s.children.0).collect();
        for (s, node) in structure.supernodes.iter().enumerate().rev() {
            let columns = 3 * node.columns;
            let rows = front_rows(node);
            let size = rows.len();
            let mut z = vec![0.0; size * size];
            if node.parent != NONE {
                let parent = node.parent as usize;
                let above = &structure.supernodes[parent];
                gather(
                    &mut z,
                    size,
                    columns,
                    &structure.places[node.rows.0..node.rows.1],
                    above,
                    &fronts[parent],
                );
                waiting[parent] -= 1;
                if waiting[parent] == 0 {
                    fronts[parent] = Vec::new();
                }
            }
            self.invert_front(node, &rows, &mut z);
            for k in 0..node.columns {
                diagonal[node.first + k] = Matrix3::from_fn(|r, c| z[(3 * k + r) * size + 3 * k + c]);
            }
            if waiting[s] > 0 {
                fronts[s] = z;
            }
        }
        diagonal
    }

    /// Completes the inverse on a front whose part below the columns, Z_RR, is known. With G = B·L₁₁⁻¹: Z_RJ = −Z_RR·G and
    /// Z_JJ = L₁₁⁻ᵀL₁₁⁻¹ − Gᵀ·Z_RJ.
    fn invert_front(&self, node: &Supernode, rows: &[usize], z: &mut [f64]) {
        let (columns, size) = (3 * node.columns, rows.len());
        // The columns of L on the front, then G and L₁₁⁻¹ in place: X = [L₁₁; B]·L₁₁⁻¹ with the inverse where [I] would be.
        let panel = &self.panel(node)[..node.stride() * columns];
        let l = |row: usize, column: usize| panel[column * node.stride() + rows[row]];
        let mut inverse = vec![0.0; columns * columns];
        for c in 0..columns {
            inverse[c * columns + c] = l(c, c);
            for r in c + 1..columns {
                let sum: f64 = (c..r).map(|k| l(r, k) * inverse[c * columns + k]).sum();
                inverse[c * columns + r] = -sum * l(r, r);
            }
        }
        let mut g = vec![0.0; size * columns];
        for c in 0..columns {
            for k in c..columns {
                let v = inverse[c * columns + k];
                for r in columns..size {
                    g[c * size + r] += l(r, k) * v;
                }
            }
        }
        for c in 0..columns {
            for k in columns..size {
                let v = g[c * size + k];
                for r in columns..size {
                    z[c * size + r] -= z[k * size + r] * v;
                }
            }
            for r in columns..size {
                z[r * size + c] = z[c * size + r];
            }
        }
        for c in 0..columns {
            for r in 0..=c {
                let own: f64 =
                    (c..columns).map(|k| inverse[c * columns + k] * inverse[r * columns + k]).sum();
                let rest: f64 = (columns..size).map(|k| g[r * size + k] * z[c * size + k]).sum();
                z[c * size + r] = own - rest;
                z[r * size + c] = own - rest;
            }
        }
    }
}

/// Copies Z_RR of a child out of its parent's front.
fn gather(z: &mut [f64], size: usize, columns: usize, places: &[u32], above: &Supernode, front: &[f64]) {
    let above_size = 3 * (above.columns + above.rows.1 - above.rows.0);
    // `places` count padded rows.
    let padding = above.own - 3 * above.columns;
    let at = |place: u32| {
        let place = place as usize;
        if place < above.own { place } else { place - padding }
    };
    for (j, &column) in places.iter().enumerate() {
        for (i, &row) in places.iter().enumerate() {
            for c in 0..3 {
                let from = (at(column) + c) * above_size + at(row);
                let to = (columns + 3 * j + c) * size + columns + 3 * i;
                z[to..to + 3].copy_from_slice(&front[from..from + 3]);
            }
        }
    }
}
