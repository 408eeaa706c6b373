//! A problem that grows, term by term: a tree of supernodes of which an update computes only the part that it changes.
//!
//! After Kaess et al., *iSAM2*, IJRR 2012: the supernodes that new terms touch, and all above them, are taken out; their
//! blocks are ordered anew, the subtrees below hang on as they are; the solution is carried down only as far as it changes; a
//! block is linearised anew once its estimate has gone too far from where it was. Terms touch one or two free blocks.

use super::clique::{Clique, Front, NONE};
use super::ordering::{Graph, minimum_degree_between};
use super::structure::{Analysis, analyse};
use super::{Block, Linearization, PairQuadratic, Problem};

/// How little an update may leave undone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laziness {
    /// A block is linearised anew when its estimate is further away than this from where it was (metres, radians).
    pub relinearise_beyond: f64,
    /// A change of a block's estimate is carried on to the blocks below only if it is larger.
    pub carry_beyond: f64,
}

impl Laziness {
    /// Every update is a full Gauss–Newton step, to rounding.
    pub const NONE: Laziness = Laziness { relinearise_beyond: 0.0, carry_beyond: 0.0 };
}

impl Default for Laziness {
    /// The values of iSAM2.
    fn default() -> Self {
        Laziness { relinearise_beyond: 0.1, carry_beyond: 1e-3 }
    }
}

/// Terms, the blocks they are on, and the current solution.
#[derive(Debug, Clone, Default)]
pub struct Incremental {
    laziness: Laziness,
    /// Where each block is linearised.
    linearised: Vec<Block>,
    /// Estimate minus `linearised`.
    delta: Vec<Block>,
    held: Vec<bool>,
    /// At `linearised`, times ρ′.
    terms: Vec<PairQuadratic>,
    terms_of: Vec<Vec<u32>>,
    cliques: Vec<Clique>,
    free_cliques: Vec<u32>,
    clique_of: Vec<u32>,
    /// Blocks whose estimate was computed in the last update.
    computed: Vec<u32>,
    /// Scratch: index of a block among those that are eliminated anew.
    local: Vec<u32>,
    front: Front,
    changed: Vec<bool>,
}

impl Incremental {
    /// Nothing yet.
    pub fn new(laziness: Laziness) -> Self {
        Incremental { laziness, ..Incremental::default() }
    }

    /// Adds a block that starts at `start`; a held one never moves. Returns its index.
    pub fn add_block(&mut self, start: Block, held: bool) -> usize {
        self.linearised.push(start);
        self.delta.push([0.0; 3]);
        self.held.push(held);
        self.terms_of.push(Vec::new());
        self.clique_of.push(NONE);
        self.local.push(NONE);
        self.changed.push(false);
        self.linearised.len() - 1
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.linearised.len()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.linearised.is_empty()
    }

    /// The current estimate of a block.
    pub fn block(&self, index: usize) -> Block {
        let (x, d) = (self.linearised[index], self.delta[index]);
        [x[0] + d[0], x[1] + d[1], x[2] + d[2]]
    }

    /// The current estimate of every block.
    pub fn estimate(&self) -> Vec<Block> {
        (0..self.linearised.len()).map(|b| self.block(b)).collect()
    }

    /// Takes over what [`Incremental::add_block`] added and the terms of `problem` that are new since the last update.
    /// `altered`: earlier terms that are not what they were (on the same blocks).
    pub fn update(&mut self, problem: &dyn Problem, altered: &[usize]) {
        let mut touched: Vec<u32> = self.relinearise(problem);
        for &term in altered {
            self.terms[term] = quadratic(problem, term, &self.linearised);
            touched.extend(self.terms[term].blocks.map(|b| b as u32));
        }
        let first_new = self.terms.len();
        for term in first_new..problem.terms() {
            let at = quadratic(problem, term, &self.linearised);
            for block in ends(&at) {
                self.terms_of[block].push(term as u32);
                touched.push(block as u32);
            }
            self.terms.push(at);
        }
        // Newest last, so that the next update finds them at the root.
        let newest: Vec<u32> = self.terms[first_new..]
            .iter()
            .flat_map(|t| ends(t).map(|b| b as u32))
            .filter(|&b| self.clique_of[b as usize] == NONE)
            .collect();
        let (mut blocks, orphans) = self.take_out(&touched);
        for &b in touched.iter().filter(|&&b| !self.held[b as usize]) {
            if self.clique_of[b as usize] == NONE {
                self.clique_of[b as usize] = NONE - 1;
                blocks.push(b);
            }
        }
        let made = self.eliminate(&blocks, &orphans, &newest);
        self.carry_down(&made);
    }

    /// Linearises anew the blocks that have gone too far; returns all blocks whose supernodes that concerns.
    fn relinearise(&mut self, problem: &dyn Problem) -> Vec<u32> {
        let mut touched = Vec::new();
        let beyond = self.laziness.relinearise_beyond;
        let far = |d: &Block| d.iter().any(|d| d.abs() > beyond);
        let gone: Vec<u32> = self.computed.drain(..).filter(|&b| far(&self.delta[b as usize])).collect();
        for &b in &gone {
            self.linearised[b as usize] = self.block(b as usize);
            self.delta[b as usize] = [0.0; 3];
        }
        for &b in &gone {
            for k in 0..self.terms_of[b as usize].len() {
                let term = self.terms_of[b as usize][k] as usize;
                self.terms[term] = quadratic(problem, term, &self.linearised);
                touched.extend(self.terms[term].blocks.map(|b| b as u32));
            }
            // Supernodes below that have it among their rows are about the old place too.
            let mut stack = vec![self.clique_of[b as usize]];
            while let Some(c) = stack.pop() {
                let clique = &self.cliques[c as usize];
                touched.push(clique.columns[0]);
                let below = clique.children.iter().copied();
                stack.extend(below.filter(|&k| self.cliques[k as usize].rows.contains(&b)));
            }
        }
        touched
    }

    /// Takes out the supernodes of these blocks and all above; returns their blocks and the subtrees that are left.
    fn take_out(&mut self, touched: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let mut taken = Vec::new();
        for &b in touched {
            let mut c = self.clique_of[b as usize];
            while c < NONE - 1 && !self.cliques[c as usize].taken {
                self.cliques[c as usize].taken = true;
                taken.push(c);
                c = self.cliques[c as usize].parent;
            }
        }
        // Children before parents is of no use here; a fixed order is.
        taken.sort_unstable();
        let (mut blocks, mut orphans) = (Vec::new(), Vec::new());
        for &c in &taken {
            let clique = std::mem::take(&mut self.cliques[c as usize]);
            for &child in &clique.children {
                // A child that was taken out before is already gone.
                if !self.cliques[child as usize].taken && !self.cliques[child as usize].columns.is_empty() {
                    orphans.push(child);
                }
            }
            for &b in &clique.columns {
                self.clique_of[b as usize] = NONE - 1;
            }
            blocks.extend(clique.columns);
            self.free_cliques.push(c);
        }
        blocks.sort_unstable();
        orphans.sort_unstable();
        (blocks, orphans)
    }

    /// Eliminates `blocks` above the subtrees `orphans`; returns the new supernodes, children before parents.
    fn eliminate(&mut self, blocks: &[u32], orphans: &[u32], newest: &[u32]) -> Vec<u32> {
        let m = orphans.len();
        for (k, &b) in blocks.iter().enumerate() {
            self.local[b as usize] = (m + k) as u32;
        }
        let mut edges = Vec::new();
        for (o, &orphan) in orphans.iter().enumerate() {
            let rows = self.cliques[orphan as usize].rows.iter();
            edges.extend(rows.map(|&row| (o as u32, self.local[row as usize])));
        }
        for (k, &b) in blocks.iter().enumerate() {
            for &term in &self.terms_of[b as usize] {
                let [a, c] = self.terms[term as usize].blocks;
                let other = if a == b as usize { c } else { a };
                let other = self.local[other];
                if other != NONE && other > (m + k) as u32 {
                    edges.push(((m + k) as u32, other));
                }
            }
        }
        let graph = Graph::new(m + blocks.len(), &edges);
        let is_last = |v: u32| newest.contains(&blocks[v as usize - m]);
        let order = minimum_degree_between(&graph, m, is_last);
        let Analysis { order, starts, rows, groups, .. } = analyse(&graph, &order, |v| (v as usize) < m);
        let block_of = |column: u32| blocks[order[column as usize] as usize - m];
        let mut clique_of_column = vec![NONE; order.len()];
        let mut made = Vec::new();
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); groups.len()];
        for (g, &(first, end)) in groups.iter().enumerate() {
            clique_of_column[first..end].fill(g as u32);
        }
        for (g, &(first, end)) in groups.iter().enumerate() {
            let mut below: Vec<u32> = rows[starts[end - 1]..starts[end]].to_vec();
            below.sort_unstable();
            let node = order[first] as usize;
            let clique = if node < m {
                orphans[node]
            } else {
                let columns = (first..end).map(|c| block_of(c as u32)).collect();
                let below: Vec<u32> = below.iter().map(|&c| block_of(c)).collect();
                self.make(columns, below, std::mem::take(&mut children[g]))
            };
            self.cliques[clique as usize].parent = NONE;
            if let Some(&parent) = below.first() {
                children[clique_of_column[parent as usize] as usize].push(clique);
            }
            if node >= m {
                made.push(clique);
            }
        }
        for &b in blocks {
            self.local[b as usize] = NONE;
        }
        made
    }

    /// A new supernode, factored.
    fn make(&mut self, columns: Vec<u32>, rows: Vec<u32>, children: Vec<u32>) -> u32 {
        let id = self.free_cliques.pop().unwrap_or_else(|| {
            self.cliques.push(Clique::default());
            (self.cliques.len() - 1) as u32
        });
        for &b in &columns {
            self.clique_of[b as usize] = id;
        }
        for &child in &children {
            self.cliques[child as usize].parent = id;
        }
        let mut clique = Clique::new(columns, rows, children);
        self.front.open(&mut clique, self.linearised.len());
        for k in 0..clique.columns.len() {
            for &term in &self.terms_of[clique.columns[k] as usize] {
                self.front.add_term(&mut clique, k, &self.terms[term as usize], &self.held);
            }
        }
        for k in 0..clique.children.len() {
            let child = clique.children[k] as usize;
            self.front.add_child(&mut clique, &self.cliques[child]);
        }
        self.front.factor(&mut clique);
        self.cliques[id as usize] = clique;
        id
    }

    /// Solves for the new supernodes from the root down, and below them as far as anything changes.
    fn carry_down(&mut self, made: &[u32]) {
        for &c in made {
            self.cliques[c as usize].fresh = true;
        }
        let mut stack: Vec<u32> =
            made.iter().copied().filter(|&c| self.cliques[c as usize].parent == NONE).collect();
        while let Some(c) = stack.pop() {
            let clique = &mut self.cliques[c as usize];
            if !clique.fresh && !clique.rows.iter().any(|&r| self.changed[r as usize]) {
                continue;
            }
            clique.fresh = false;
            let solved = self.front.solve(clique, &self.delta);
            for (&b, new) in clique.columns.iter().zip(solved.as_chunks::<3>().0) {
                let old = &mut self.delta[b as usize];
                self.changed[b as usize] =
                    old.iter().zip(new).any(|(o, n)| (o - n).abs() > self.laziness.carry_beyond);
                *old = *new;
                self.computed.push(b);
            }
            stack.extend(&clique.children);
        }
        for &b in &self.computed {
            self.changed[b as usize] = false;
        }
    }
}

/// The one or two blocks of a term.
fn ends(at: &PairQuadratic) -> impl Iterator<Item = usize> + use<> {
    let [a, b] = at.blocks;
    [Some(a), Some(b).filter(|&b| b != a)].into_iter().flatten()
}

/// A term at x, times ρ′. A term on a single block comes back with that block twice.
fn quadratic(problem: &dyn Problem, term: usize, x: &[Block]) -> PairQuadratic {
    let mut at = PairQuadratic::default();
    if !problem.pair_quadratic(term, x, &[], &mut at) {
        let mut linear = Linearization::default();
        problem.linearize(term, x, &mut linear);
        at = PairQuadratic::from_jacobians(&linear);
    }
    at.scale(problem.loss_of(term).weight(at.squared_norm));
    at
}
