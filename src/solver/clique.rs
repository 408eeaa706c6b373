//! One supernode of a problem that grows: its panel, what it hands up, and how both are made.

use super::kernels::{backward_panel, downdate, factor_panel, forward_panel};
use super::simd::wide;
use super::{Block, PairQuadratic};

pub(super) const NONE: u32 = u32::MAX;

/// A supernode that owns its numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct Clique {
    /// Blocks, in elimination order.
    pub columns: Vec<u32>,
    /// Blocks below, in elimination order when it was made.
    pub rows: Vec<u32>,
    pub parent: u32,
    pub children: Vec<u32>,
    /// On its way out of the tree.
    pub taken: bool,
    /// Not solved yet.
    pub fresh: bool,
    /// Columns of L, the diagonal inverted; rows padded as in [`super::structure::Supernode`].
    panel: Vec<f64>,
    /// What is left of H on the rows below.
    update: Vec<f64>,
    /// L⁻¹ times the right side: the columns' part, and what is left on the rows below.
    solved: Vec<f64>,
}

impl Clique {
    /// Without its numbers, without a parent.
    pub fn new(columns: Vec<u32>, rows: Vec<u32>, children: Vec<u32>) -> Self {
        Clique { columns, rows, children, parent: NONE, ..Clique::default() }
    }

    fn own(&self) -> usize {
        (3 * self.columns.len()).next_multiple_of(4)
    }

    fn below(&self) -> usize {
        (3 * self.rows.len()).next_multiple_of(4)
    }

    fn stride(&self) -> usize {
        self.own() + self.below()
    }
}

/// Scratch for the supernode at work.
#[derive(Debug, Clone, Default)]
pub(super) struct Front {
    /// Scalar row in the front of every block that is in it, else [`NONE`].
    row_of: Vec<u32>,
    diagonal: Vec<f64>,
    places: Vec<u32>,
    w: Vec<f64>,
}

impl Front {
    /// Makes an empty front for a supernode among so many blocks.
    pub fn open(&mut self, clique: &mut Clique, blocks: usize) {
        self.row_of.resize(blocks, NONE);
        let (own, below) = (clique.own(), clique.below());
        for (k, &b) in clique.columns.iter().enumerate() {
            self.row_of[b as usize] = 3 * k as u32;
        }
        for (k, &b) in clique.rows.iter().enumerate() {
            self.row_of[b as usize] = (own + 3 * k) as u32;
        }
        clique.panel = vec![0.0; (own + below) * 3 * clique.columns.len()];
        clique.update = vec![0.0; below * below];
        clique.solved = vec![0.0; own + below];
        self.diagonal.clear();
        self.diagonal.resize(3 * clique.columns.len(), 0.0);
    }

    /// Adds a term of column `k` if no earlier column or supernode has it.
    pub fn add_term(&mut self, clique: &mut Clique, k: usize, term: &PairQuadratic, held: &[bool]) {
        let column = clique.columns[k] as usize;
        let stride = clique.stride();
        let side = usize::from(term.blocks[0] != column);
        let other = term.blocks[1 - side];
        for (d, at) in [0, 3, 5].into_iter().enumerate() {
            self.diagonal[3 * k + d] += term.own[side][at];
        }
        let single = other == column;
        let row = self.row_of[other];
        if !single && !held[other] && (row == NONE || row < 3 * k as u32) {
            return;
        }
        let at = 3 * k;
        add_own(&mut clique.panel[at * stride + at..], stride, &term.own[side]);
        subtract(&mut clique.solved[at..], &term.gradient[side]);
        if single || held[other] {
            return;
        }
        let row = row as usize;
        // The block at (other, column): JᵒᵗʰᵉʳᵀJᶜᵒˡᵘᵐⁿ; `cross` is J₀ᵀJ₁, column-major.
        for c in 0..3 {
            for r in 0..3 {
                let value = if side == 0 { term.cross[3 * r + c] } else { term.cross[3 * c + r] };
                clique.panel[(at + c) * stride + row + r] += value;
            }
        }
        let own = clique.own();
        if row < own {
            add_own(&mut clique.panel[row * stride + row..], stride, &term.own[1 - side]);
        } else {
            let below = clique.below();
            add_own(&mut clique.update[(row - own) * (below + 1)..], below, &term.own[1 - side]);
        }
        subtract(&mut clique.solved[row..], &term.gradient[1 - side]);
    }

    /// Adds what a child hands up; its rows may come in another order than here.
    pub fn add_child(&mut self, clique: &mut Clique, child: &Clique) {
        self.places.clear();
        self.places.extend(child.rows.iter().map(|&b| self.row_of[b as usize]));
        let (own, stride, below) = (clique.own(), clique.stride(), clique.below());
        let (child_own, order) = (child.own(), child.below());
        for (j, &to) in self.places.iter().enumerate() {
            for d in 0..3 {
                clique.solved[to as usize + d] += child.solved[child_own + 3 * j + d];
            }
            for (i, &other) in self.places.iter().enumerate().skip(j) {
                let (column, row) = (to.min(other) as usize, to.max(other) as usize);
                let (target, stride) = if column < own {
                    (&mut clique.panel[column * stride + row..], stride)
                } else {
                    (&mut clique.update[(column - own) * below + row - own..], below)
                };
                let from = &child.update[3 * j * order + 3 * i..];
                for c in 0..3 {
                    for r in 0..3 {
                        let value = if to <= other { from[c * order + r] } else { from[r * order + c] };
                        target[c * stride + r] += value;
                    }
                }
            }
        }
    }

    /// Factors the front, and solves for the right side as far as it goes.
    pub fn factor(&mut self, clique: &mut Clique) {
        let stride = clique.stride();
        for (k, d) in self.diagonal.iter_mut().enumerate() {
            if *d == 0.0 {
                // No term knows this number: it stays where it is.
                *d = 1.0;
                clique.panel[k * (stride + 1)] += 1.0;
            }
        }
        factor_front(clique, &self.diagonal);
        for &b in clique.columns.iter().chain(&clique.rows) {
            self.row_of[b as usize] = NONE;
        }
    }

    /// The solution of the columns, given that of the rows below.
    pub fn solve(&mut self, clique: &Clique, delta: &[Block]) -> &[f64] {
        let own = clique.own();
        self.w.clear();
        self.w.resize(clique.stride(), 0.0);
        for (k, &b) in clique.rows.iter().enumerate() {
            self.w[own + 3 * k..own + 3 * k + 3].copy_from_slice(&delta[b as usize]);
        }
        solve_front(clique, &mut self.w);
        &self.w[..3 * clique.columns.len()]
    }
}

wide! {
    fn solve_front(clique: &Clique, w: &mut [f64]) {
        backward_panel(&clique.panel, clique.stride(), 3 * clique.columns.len(), &clique.solved, w);
    }
}

wide! {
    fn factor_front(clique: &mut Clique, diagonal: &[f64]) {
        let (stride, own, columns) = (clique.stride(), clique.own(), 3 * clique.columns.len());
        factor_panel(&mut clique.panel, stride, columns, diagonal, |_| {});
        downdate(&clique.panel, stride, own, columns, &mut clique.update);
        forward_panel(&clique.panel, stride, columns, &mut clique.solved);
    }
}

/// Adds the lower triangle of a symmetric block given by its upper triangle, row by row.
fn add_own(target: &mut [f64], stride: usize, own: &[f64; 6]) {
    let [xx, xy, xt, yy, yt, tt] = *own;
    for (at, value) in [(0, xx), (1, xy), (2, xt), (stride + 1, yy), (stride + 2, yt), (2 * stride + 2, tt)] {
        target[at] += value;
    }
}

fn subtract(target: &mut [f64], gradient: &Block) {
    for (t, g) in target.iter_mut().zip(gradient) {
        *t -= g;
    }
}
