//! Numeric multifrontal Cholesky H = LLᵀ and its triangular solves, in panels of 3×3 blocks.

use super::kernels::{backward_panel, downdate, factor_panel, forward_panel};
use super::pages;
use super::simd::wide;
use super::structure::{Structure, Supernode};

/// H: lower triangle, block columns in elimination order, the diagonal block first; 3×3 blocks, column-major.
#[derive(Debug, Clone, Default)]
pub(super) struct BlockMatrix {
    /// Where the blocks of each block column start; one more at the end.
    pub starts: Vec<u32>,
    /// Block row of every block, ascending within a column.
    pub rows: Vec<u32>,
    /// Where the block goes within its supernode's panel: scalar index of its first entry.
    pub places: Vec<u32>,
    /// Nine numbers a block.
    pub values: Vec<[f64; 9]>,
}

/// Scalar columns of a supernode, padded rows of its own and below.
type Shape = (usize, usize, usize);

/// So many rows of a right side are worked on where the compiler may keep them in registers.
const SMALL: usize = 24;

/// Runs a body with the shape of a supernode, compiled anew for each of the commonest: chains are made of these, and with
/// sizes that the compiler knows, loops cost no more than their arithmetic. The same operations in the same order for all.
macro_rules! by_shape {
    ($node:expr, $shape:ident => $body:expr) => {
        by_shape!($node, $shape => $body; (3, 4, 4) (3, 4, 8) (3, 4, 12) (6, 8, 4) (6, 8, 8) (9, 12, 4) (9, 12, 8)
            (12, 12, 4) (12, 12, 8) (12, 12, 12))
    };
    ($node:expr, $shape:ident => $body:expr; $(($columns:literal, $own:literal, $below:literal))*) => {
        match (3 * $node.columns, $node.own, $node.below) {
            $(($columns, $own, $below) => {
                let $shape = ($columns, $own, $below);
                $body
            })*
            $shape => $body,
        }
    };
}

/// A numeric factor.
#[derive(Debug, Clone, Default)]
pub(super) struct Factor {
    panels: Vec<f64>,
    updates: Vec<f64>,
    scratch: Vec<f64>,
    /// Scalar columns whose pivot was replaced, ascending.
    pub damped: Vec<usize>,
    /// How often it was computed as a whole, and how often a right side was solved for with it, since it was made.
    pub passes: (usize, usize),
}

impl Factor {
    /// Memory for a structure, of which nothing is factored yet. What there is and is enough stays.
    pub fn fit(&mut self, structure: &Structure) {
        let largest = structure.supernodes.iter().map(Supernode::stride).max().unwrap_or(0);
        for (memory, length) in [
            (&mut self.panels, structure.panel_len),
            (&mut self.updates, structure.update_len),
            (&mut self.scratch, largest),
        ] {
            if memory.len() < length {
                *memory = pages::zeros(length);
            }
        }
        self.damped.clear();
    }

    /// Factors H + λD (D: [`damping_diagonal`]) and solves Ly = b in place, panel by panel while it is at hand. Never
    /// fails: a pivot that is nothing but rounding is replaced by its diagonal entry, and told in `damped`.
    pub fn compute(&mut self, structure: &Structure, h: &BlockMatrix, damping: f64, b: &mut [f64]) {
        self.damped.clear();
        self.passes.0 += 1;
        compute_all(self, structure, h, damping, b);
    }

    /// Factors H anew in these supernodes, closed under taking parents; the others stay as they are. Their update matrices
    /// must be apart.
    pub fn compute_changed(&mut self, structure: &Structure, h: &BlockMatrix, changed: &[bool]) {
        self.damped.retain(|&scalar| !changed[structure.supernode_of[scalar / 3] as usize]);
        compute_some(self, structure, h, changed);
        self.damped.sort_unstable();
    }

    #[inline(always)]
    fn supernode(
        &mut self,
        structure: &Structure,
        h: &BlockMatrix,
        damping: f64,
        node: &Supernode,
        shape: Shape,
    ) {
        let (columns, own, below) = shape;
        let stride = own + below;
        let panel = &mut self.panels[node.panel..node.panel + stride * columns];
        panel.fill(0.0);
        let diagonal = &mut self.scratch[..columns];
        for (k, c) in (node.first..node.first + node.columns).enumerate() {
            let (from, to) = (h.starts[c] as usize, h.starts[c + 1] as usize);
            for b in from..to {
                let (place, value) = (h.places[b] as usize, &h.values[b]);
                for (column, value) in value.as_chunks::<3>().0.iter().enumerate() {
                    panel[place + column * stride..][..3].copy_from_slice(value);
                }
            }
            let d = damping_diagonal(&h.values[from]);
            for (r, d) in d.into_iter().enumerate() {
                let entry = &mut panel[(3 * k + r) * (stride + 1)];
                *entry += damping * d;
                if *entry == 0.0 {
                    // No term knows this number: it stays where it is.
                    *entry = 1.0;
                }
                diagonal[3 * k + r] = *entry;
            }
        }
        let (kept, rest) = self.updates.split_at_mut(node.update.0);
        let update = &mut rest[..below * below];
        update.fill(0.0);
        for &child in &structure.children[node.children.0..node.children.1] {
            let child = structure.supernodes[child as usize];
            let places = &structure.places[child.rows.0..child.rows.1];
            extend(&kept[child.update.1..], child.below, places, panel, own, stride, update);
        }
        let damped = &mut self.damped;
        factor_panel(panel, stride, columns, diagonal, |column| damped.push(3 * node.first + column));
        downdate(panel, stride, own, columns, update);
        if node.update.0 != node.update.1 {
            self.updates.copy_within(node.update.0..node.update.0 + below * below, node.update.1);
        }
    }

    /// The panel of a supernode: columns of L, the diagonal inverted.
    pub fn panel(&self, node: &Supernode) -> &[f64] {
        &self.panels[node.panel..node.panel + 3 * node.columns * node.stride()]
    }

    /// Solves LLᵀx = b in place; `x` in elimination order, three numbers a block.
    pub fn solve(&mut self, structure: &Structure, x: &mut [f64]) {
        self.passes.1 += 1;
        forward_all(self, structure, x);
        backward_all(self, structure, x);
    }

    /// Solves Lᵀx = y in place.
    pub fn solve_upper(&mut self, structure: &Structure, x: &mut [f64]) {
        backward_all(self, structure, x);
    }

    #[inline(always)]
    fn forward(&mut self, structure: &Structure, node: &Supernode, x: &mut [f64], shape: Shape) {
        let (columns, node_own, below) = shape;
        let stride = node_own + below;
        let panel = &self.panels[node.panel..node.panel + stride * columns];
        let mut small = [0.0; SMALL];
        let w = if stride <= SMALL { &mut small[..stride] } else { &mut self.scratch[..stride] };
        let own = &mut x[3 * node.first..3 * node.first + columns];
        w[..columns].copy_from_slice(own);
        w[columns..].fill(0.0);
        forward_panel(panel, stride, columns, w);
        own.copy_from_slice(&w[..columns]);
        for (&row, w) in structure.rows[node.rows.0..node.rows.1].iter().zip(w[node_own..].chunks_exact(3)) {
            for (x, w) in x[3 * row as usize..].iter_mut().zip(w) {
                *x += w;
            }
        }
    }

    #[inline(always)]
    fn backward(&mut self, structure: &Structure, node: &Supernode, x: &mut [f64], shape: Shape) {
        let (columns, node_own, below) = shape;
        let stride = node_own + below;
        let panel = &self.panels[node.panel..node.panel + stride * columns];
        let mut small = [0.0; SMALL];
        let w = if stride <= SMALL { &mut small[..stride] } else { &mut self.scratch[..stride] };
        w.fill(0.0);
        for (&row, w) in
            structure.rows[node.rows.0..node.rows.1].iter().zip(w[node_own..].chunks_exact_mut(3))
        {
            w.copy_from_slice(&x[3 * row as usize..][..3]);
        }
        backward_panel(panel, stride, columns, &x[3 * node.first..], w);
        x[3 * node.first..3 * node.first + columns].copy_from_slice(&w[..columns]);
    }
}

wide! {
    fn compute_all(factor: &mut Factor, structure: &Structure, h: &BlockMatrix, damping: f64, b: &mut [f64]) {
        for s in 0..structure.supernodes.len() {
            let node = &structure.supernodes[s];
            by_shape!(node, shape => {
                factor.supernode(structure, h, damping, node, shape);
                factor.forward(structure, node, b, shape);
            });
        }
    }
}

wide! {
    fn compute_some(factor: &mut Factor, structure: &Structure, h: &BlockMatrix, changed: &[bool]) {
        for s in (0..structure.supernodes.len()).filter(|&s| changed[s]) {
            let node = &structure.supernodes[s];
            by_shape!(node, shape => factor.supernode(structure, h, 0.0, node, shape));
        }
    }
}

wide! {
    fn forward_all(factor: &mut Factor, structure: &Structure, x: &mut [f64]) {
        for node in &structure.supernodes {
            by_shape!(node, shape => factor.forward(structure, node, x, shape));
        }
    }
}

wide! {
    fn backward_all(factor: &mut Factor, structure: &Structure, x: &mut [f64]) {
        for node in structure.supernodes.iter().rev() {
            by_shape!(node, shape => factor.backward(structure, node, x, shape));
        }
    }
}

/// Adds a child's update matrix to its parent's panel and update matrix: the lower triangle, block by block.
#[inline(always)]
fn extend(
    child: &[f64],
    order: usize,
    places: &[u32],
    panel: &mut [f64],
    own: usize,
    stride: usize,
    update: &mut [f64],
) {
    for (j, &column) in places.iter().enumerate() {
        let column = column as usize;
        let (target, offset, height) = if column < own {
            (&mut panel[column * stride..], 0, stride)
        } else {
            (&mut update[(column - own) * (stride - own)..], own, stride - own)
        };
        for c in 0..3 {
            let from = &child[(3 * j + c) * order + 3 * j..(3 * j + c + 1) * order];
            let to = &mut target[c * height..(c + 1) * height];
            for (&row, from) in places[j..].iter().zip(from.as_chunks::<3>().0) {
                if let Some(to) = to[row as usize - offset..].first_chunk_mut::<3>() {
                    for k in 0..3 {
                        to[k] += from[k];
                    }
                }
            }
        }
    }
}

/// What λ multiplies for a diagonal block: its diagonal with the two position entries replaced by their mean, so that
/// steps do not depend on how the map is turned.
pub(super) fn damping_diagonal(block: &[f64; 9]) -> [f64; 3] {
    let position = (block[0] + block[4]) / 2.0;
    [position, position, block[8]]
}

impl BlockMatrix {
    /// Index of the block at a row and column, row > column; it must be there.
    pub fn find(&self, row: u32, column: u32) -> u32 {
        let (from, to) = (self.starts[column as usize] as usize, self.starts[column as usize + 1] as usize);
        let at = self.rows[from..to].binary_search(&row).unwrap_or_else(|at| at);
        (from + at) as u32
    }
}
