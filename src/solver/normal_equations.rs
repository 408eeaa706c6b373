//! H = Σ ρ′ JᵀJ and g = Σ ρ′ Jᵀr, summed straight into the blocks that the factorisation reads.

use nalgebra::Matrix3;

use super::factor::{BlockMatrix, Factor};
use super::ordering::Graph;
use super::pages;
use super::step::{Step, largest};
use super::structure::Structure;
use super::{Block, Linearization, PairQuadratic, Problem};

const HELD: u32 = u32::MAX;

/// Where a product JₐᵀJ_b goes: a block of H, as it is or transposed.
#[derive(Debug, Clone, Copy)]
struct Slot {
    block: u32,
    transposed: bool,
}

const NOWHERE: Slot = Slot { block: HELD, transposed: false };

/// The normal equations of one problem structure. Held blocks do not appear in them (that is the gauge).
#[derive(Debug, Clone, Default)]
pub(super) struct NormalEquations {
    /// Block column of each block, or [`HELD`].
    column_of: Vec<u32>,
    /// Block of each block column.
    block_of: Vec<u32>,
    pub structure: Structure,
    h: BlockMatrix,
    /// Off-diagonal slots: for each term in turn every pair of its blocks, (0, 1), (0, 2), … (1, 2), …
    slots: Vec<Slot>,
    /// g, 3 per block column.
    gradient: Vec<f64>,
    /// δ, likewise; or what the factorisation made of −g on its way there.
    delta: Vec<f64>,
    /// True if `delta` is the latter.
    halfway: bool,
    /// True if H is that of where g is.
    filled: bool,
    /// Scratch: see [`Problem::turns`].
    turns: Vec<[f64; 2]>,
    pub factor: Factor,
}

impl NormalEquations {
    /// Analyses which blocks meet; `held` (ascending) are the blocks that must not move. In the memory of what was analysed
    /// before: fresh pages cost as much as a step.
    pub fn analyse(&mut self, problem: &dyn Problem, blocks: usize, held: &[usize]) {
        let mut unknown = vec![0u32; blocks];
        for &h in held {
            unknown[h] = HELD;
        }
        let mut free = 0;
        for u in unknown.iter_mut().filter(|u| **u != HELD) {
            *u = free;
            free += 1;
        }
        let mut pairs = Vec::with_capacity(problem.terms());
        let mut touched = Vec::new();
        for term in 0..problem.terms() {
            touched.clear();
            problem.blocks_of(term, &mut touched);
            for (k, &a) in touched.iter().enumerate() {
                pairs.extend(touched[k + 1..].iter().map(|&b| (unknown[a], unknown[b])));
            }
        }
        let is_free = |&(a, b): &(u32, u32)| a != HELD && b != HELD;
        let edges: Vec<_> = pairs.iter().copied().filter(is_free).collect();
        let graph = Graph::new(free as usize, &edges);
        let structure = Structure::new(&graph);
        self.h = pattern(&graph, &structure, std::mem::take(&mut self.h.values));
        let slot = |(a, b): (u32, u32)| {
            if !is_free(&(a, b)) {
                return NOWHERE;
            }
            let (a, b) = (structure.column_of[a as usize], structure.column_of[b as usize]);
            Slot { block: self.h.find(a.max(b), a.min(b)), transposed: a < b }
        };
        self.slots.clear();
        self.slots.extend(pairs.into_iter().map(slot));
        let column = |&u: &u32| if u == HELD { HELD } else { structure.column_of[u as usize] };
        self.column_of.clear();
        self.column_of.extend(unknown.iter().map(column));
        self.block_of.resize(free as usize, 0);
        for (block, &column) in self.column_of.iter().enumerate().filter(|c| *c.1 != HELD) {
            self.block_of[column as usize] = block as u32;
        }
        self.factor.fit(&structure);
        self.structure = structure;
        self.gradient.resize(3 * free as usize, 0.0);
        self.delta.resize(3 * free as usize, 0.0);
        self.halfway = false;
        self.filled = false;
    }

    /// Fills H and g at x; returns the cost there.
    pub fn assemble(&mut self, problem: &dyn Problem, x: &[Block]) -> f64 {
        self.h.values.fill([0.0; 9]);
        self.filled = true;
        self.sum::<true>(problem, x)
    }

    /// Fills g at x alone, for a factor that serves on; returns the cost there.
    pub fn assemble_gradient(&mut self, problem: &dyn Problem, x: &[Block]) -> f64 {
        self.filled = false;
        self.sum::<false>(problem, x)
    }

    fn sum<const H: bool>(&mut self, problem: &dyn Problem, x: &[Block]) -> f64 {
        self.halfway = false;
        self.gradient.fill(0.0);
        let mut turns = std::mem::take(&mut self.turns);
        problem.turns(x, &mut turns);
        let mut slot = 0;
        let mut cost = 0.0;
        let mut at = Linearization::default();
        let mut pair = PairQuadratic::default();
        for term in 0..problem.terms() {
            let is_pair = if H {
                problem.pair_quadratic(term, x, &turns, &mut pair)
            } else {
                problem.pair_gradient(term, x, &turns, &mut pair)
            };
            if is_pair {
                let loss = problem.loss_of(term);
                cost += loss.rho(pair.squared_norm);
                self.add_pair::<H>(&pair, loss.weight(pair.squared_norm), slot);
                slot += 1;
                continue;
            }
            at.clear();
            problem.linearize(term, x, &mut at);
            let (loss, s) = (problem.loss_of(term), at.residual.norm_squared());
            cost += loss.rho(s);
            slot = self.add_term::<H>(&at, loss.weight(s), slot);
        }
        self.turns = turns;
        0.5 * cost
    }

    fn add_pair<const H: bool>(&mut self, pair: &PairQuadratic, w: f64, slot: usize) {
        for side in 0..2 {
            let column = self.column_of[pair.blocks[side]];
            if column == HELD {
                continue;
            }
            for (g, p) in self.gradient[3 * column as usize..].iter_mut().zip(pair.gradient[side]) {
                *g += w * p;
            }
            if !H {
                continue;
            }
            let h = &mut self.h.values[self.h.starts[column as usize] as usize];
            let [xx, xy, xt, yy, yt, tt] = pair.own[side];
            // The lower triangle is all that is read.
            h[0] += w * xx;
            h[1] += w * xy;
            h[2] += w * xt;
            h[4] += w * yy;
            h[5] += w * yt;
            h[8] += w * tt;
        }
        if !H {
            return;
        }
        let slot = self.slots[slot];
        if slot.block != HELD {
            // `cross` is J₀ᵀJ₁, column-major; below the diagonal lies the row of the later column.
            let h = &mut self.h.values[slot.block as usize];
            let c = &pair.cross;
            if slot.transposed {
                for k in 0..9 {
                    h[k] += w * c[3 * (k % 3) + k / 3];
                }
            } else {
                for k in 0..9 {
                    h[k] += w * c[k];
                }
            }
        }
    }

    fn add_term<const H: bool>(&mut self, at: &Linearization, w: f64, mut slot: usize) -> usize {
        for (k, &(block, j)) in at.jacobians.iter().enumerate() {
            let jt = j.transpose() * w;
            let column = self.column_of[block];
            if column != HELD {
                let g = jt * at.residual;
                for (sum, g) in self.gradient[3 * column as usize..].iter_mut().zip(g.iter()) {
                    *sum += g;
                }
                if H {
                    let diagonal = self.h.starts[column as usize];
                    self.add_block(Slot { block: diagonal, transposed: false }, &(jt * j));
                }
            }
            if H {
                for (_, other) in &at.jacobians[k + 1..] {
                    self.add_block(self.slots[slot], &(jt * other));
                    slot += 1;
                }
            }
        }
        // Without H the slots are not looked at.
        slot
    }

    fn add_block(&mut self, slot: Slot, block: &Matrix3<f64>) {
        if slot.block == HELD {
            return;
        }
        let h = &mut self.h.values[slot.block as usize];
        for (k, h) in h.iter_mut().enumerate() {
            *h += if slot.transposed { block[(k / 3, k % 3)] } else { block[(k % 3, k / 3)] };
        }
    }

    /// Factors H + λD; g is that of `x`.
    pub fn factor(&mut self, problem: &dyn Problem, x: &[Block], damping: f64) {
        if !self.filled {
            self.assemble(problem, x);
        }
        self.negate_gradient();
        self.factor.compute(&self.structure, &self.h, damping, &mut self.delta);
        self.halfway = true;
    }

    /// Factors H anew in these supernodes alone.
    pub fn factor_changed(&mut self, changed: &[bool]) {
        self.factor.compute_changed(&self.structure, &self.h, changed);
        self.halfway = false;
    }

    /// Puts δ with LLᵀδ = −g for the factor at hand into `delta`; `None` if it is not finite.
    pub fn step(&mut self) -> Option<Step> {
        if std::mem::take(&mut self.halfway) {
            self.factor.solve_upper(&self.structure, &mut self.delta);
        } else {
            self.negate_gradient();
            self.factor.solve(&self.structure, &mut self.delta);
        }
        Step::of(&self.delta, &self.gradient)
    }

    fn negate_gradient(&mut self) {
        for (d, g) in self.delta.iter_mut().zip(&self.gradient) {
            *d = -g;
        }
    }

    /// Largest entry of g.
    pub fn gradient_max(&self) -> f64 {
        largest(&self.gradient)
    }

    /// Block column of a block that is free.
    pub fn column(&self, block: usize) -> Option<usize> {
        Some(self.column_of[block]).filter(|&c| c != HELD).map(|c| c as usize)
    }

    /// x ← x ⊕ δ: plain addition on every free block.
    pub fn advance(&self, x: &mut [Block]) {
        for (&block, delta) in self.block_of.iter().zip(self.delta.as_chunks::<3>().0) {
            for (x, d) in x[block as usize].iter_mut().zip(delta) {
                *x += d;
            }
        }
    }

    /// y ← x ⊕ δ; what is held must be the same in both already.
    pub fn advance_from(&self, x: &[Block], y: &mut [Block]) {
        for (&block, delta) in self.block_of.iter().zip(self.delta.as_chunks::<3>().0) {
            for ((y, x), d) in y[block as usize].iter_mut().zip(&x[block as usize]).zip(delta) {
                *y = x + d;
            }
        }
    }

    /// Blocks with a number that nothing determines, as far as doubles can tell, ascending: their pivots were replaced.
    pub fn undetermined(&self) -> Vec<usize> {
        let mut blocks: Vec<usize> =
            self.factor.damped.iter().map(|&scalar| self.block_of[scalar / 3] as usize).collect();
        blocks.sort_unstable();
        blocks.dedup();
        blocks
    }
}

/// The blocks of H for a structure, in the memory of other ones.
fn pattern(graph: &Graph, structure: &Structure, values: Vec<[f64; 9]>) -> BlockMatrix {
    let n = graph.nodes();
    let mut nodes = vec![0u32; n];
    for (node, &column) in structure.column_of.iter().enumerate() {
        nodes[column as usize] = node as u32;
    }
    let mut h = BlockMatrix { starts: vec![0], values, ..BlockMatrix::default() };
    for (column, &node) in nodes.iter().enumerate() {
        let from = h.rows.len();
        h.rows.push(column as u32);
        let rows = graph.of(node).iter().map(|&m| structure.column_of[m as usize]);
        h.rows.extend(rows.filter(|&row| row > column as u32));
        h.rows[from..].sort_unstable();
        h.starts.push(h.rows.len() as u32);
        let supernode = &structure.supernodes[structure.supernode_of[column] as usize];
        let base = 3 * (column - supernode.first) * supernode.stride();
        let below = &structure.rows[supernode.rows.0..supernode.rows.1];
        let mut at = 0;
        for &row in &h.rows[from..] {
            let row = row as usize;
            let place = if row < supernode.first + supernode.columns {
                3 * (row - supernode.first)
            } else {
                while below[at] < row as u32 {
                    at += 1;
                }
                supernode.own + 3 * at
            };
            h.places.push((base + place) as u32);
        }
    }
    pages::make_room(&mut h.values, h.rows.len());
    h.values.resize(h.rows.len(), [0.0; 9]);
    h
}
