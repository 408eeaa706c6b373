//! The Rao-Blackwellised particle filter of FootSLAM, on a structure of arrays.
//!
//! Per step and particle: draw the odometry error, move ([`super::motion`]), cross hexagon edges exactly
//! ([`super::hex`]), multiply the weight by (N_h^e + G·P_h^e + α)/(N_h + G·P_h + 6α) × norm for each crossing. N are
//! the particle's own counts including earlier crossings of the same step (`super::history`), P the prior map.
//! Blocks of particles are independent: they may run on any thread.

use rayon::prelude::*;

use super::genealogy::Genealogy;
use super::hex::{Cell, Hexagon};
pub use super::history::CROSSINGS_PER_STEP;
use super::history::{Archive, Past, Piece, Tail};
use super::layout::Layout;
use super::motion::{ErrorState, MeasuredStep, Sigmas};
use super::options::Options;
use super::path_tree::PathTree;
use super::random::{Key, Normals};
use super::transition_map::{Prior, TransitionMap};
use super::weights::{BLOCK, Sums, systematic};
use crate::geometry::Vec2;

/// Word of a step's stream that decides the resampling; the particles use the words from 0.
pub const RESAMPLING_WORD: u64 = 1 << 40;

/// What does not change during a run.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// Geometry of a hexagon.
    pub hexagon: Hexagon,
    /// Numbers of the cells.
    pub layout: Layout,
    /// The other walkers' map.
    pub prior: Option<&'a Prior>,
    /// Settings of the mapper.
    pub options: &'a Options,
    /// Random stream of the run.
    pub key: Key,
    /// Start in the grid frame, metres.
    pub start: [f32; 2],
    /// Standard deviations of the start: position per axis, heading.
    pub start_sigmas: [f32; 2],
    /// Run blocks of particles on several threads.
    pub parallel: bool,
}

#[derive(Debug, Clone, Default)]
struct Block {
    cells: Vec<Cell>,
    offsets: Vec<[f32; 2]>,
    errors: Vec<ErrorState>,
    weights: Vec<f32>,
    evidence: Vec<f32>,
    tails: Vec<Tail>,
    pasts: Vec<Past>,
}

/// All particles of a walker.
#[derive(Debug, Clone)]
pub struct ParticleFilter<'a> {
    setting: Setting<'a>,
    blocks: Vec<Block>,
    spare: Vec<Block>,
    archive: Archive,
    genealogy: Genealogy,
    /// Parents of the particles since the last layer of the genealogy.
    parents: Vec<u32>,
    /// Brings the mean weight back to 1.
    rescale: f32,
    steps: u64,
    /// ln of the evidence of all steps so far.
    pub log_evidence: f64,
    /// How often particles were resampled.
    pub resamplings: usize,
}

impl<'a> ParticleFilter<'a> {
    /// Draws the particles at the start.
    pub fn new(setting: Setting<'a>) -> Self {
        let count = setting.options.particles;
        let blocks: Vec<Block> = (0..count)
            .step_by(BLOCK)
            .map(|first| Block::draw(&setting, first, BLOCK.min(count - first)))
            .collect();
        let mut filter = ParticleFilter {
            setting,
            spare: blocks.clone(),
            blocks,
            archive: Archive::default(),
            genealogy: Genealogy::default(),
            parents: Vec::new(),
            rescale: 1.0,
            steps: 0,
            log_evidence: 0.0,
            resamplings: 0,
        };
        let positions = filter.blocks.iter().flat_map(|b| b.positions(&setting.hexagon)).collect();
        filter.genealogy.push(positions, Vec::new());
        filter
    }

    /// One step; particles are resampled where needed and allowed. The sums are those before resampling.
    pub fn step(&mut self, step: &MeasuredStep, may_resample: bool) -> Sums {
        self.step_with(self.setting.prior, step, may_resample)
    }

    /// The same against another prior than the setting's: one that grows while the walker walks.
    pub fn step_with(&mut self, prior: Option<&Prior>, step: &MeasuredStep, may_resample: bool) -> Sums {
        let key = self.setting.key.with(self.steps + 1);
        self.steps += 1;
        let setting = &Setting { prior, ..self.setting };
        let (archive, rescale) = (&self.archive, self.rescale);
        let advance = |(number, block): (usize, &mut Block)| {
            block.advance(setting, archive, step, rescale, key, (number * BLOCK) as u64)
        };
        let results: Vec<(Sums, Vec<[f32; 2]>)> = if setting.parallel {
            self.blocks.par_iter_mut().enumerate().map(advance).collect()
        } else {
            self.blocks.iter_mut().enumerate().map(advance).collect()
        };
        let mut sums = Sums::default();
        let mut positions = Vec::with_capacity(self.setting.options.particles);
        for (block_sums, block_positions) in results {
            sums.add(&block_sums);
            positions.extend(block_positions);
        }
        self.genealogy.push(positions, std::mem::take(&mut self.parents));

        let count = self.setting.options.particles;
        self.log_evidence += (sums.weight / count as f64).ln();
        self.rescale = (count as f64 / sums.weight) as f32;
        for block in &mut self.blocks {
            for (past, tail) in block.pasts.iter_mut().zip(&mut block.tails) {
                self.archive.flush(&self.setting.layout, past, tail);
            }
        }
        if may_resample && sums.effective() < self.setting.options.resample_below * count as f64 {
            self.resample(&sums, key.uniform(RESAMPLING_WORD));
            if self.archive.wants_tidying() {
                let mut pasts: Vec<&mut Past> = self.blocks.iter_mut().flat_map(|b| &mut b.pasts).collect();
                self.archive.tidy(&self.setting.layout, &mut pasts);
            }
        }
        sums
    }

    fn resample(&mut self, sums: &Sums, offset: f64) {
        let count = self.setting.options.particles;
        let weights = self.blocks.iter().flat_map(|b| b.weights.iter().copied());
        let parents = systematic(weights, sums.weight, count, offset);
        let blocks = &self.blocks;
        let gather = |(number, block): (usize, &mut Block)| {
            let first = number * BLOCK;
            let last = (first + BLOCK).min(count);
            block.gather(blocks, &parents[first..last]);
        };
        if self.setting.parallel {
            self.spare.par_iter_mut().enumerate().for_each(gather);
        } else {
            self.spare.iter_mut().enumerate().for_each(gather);
        }
        std::mem::swap(&mut self.blocks, &mut self.spare);
        self.parents = parents;
        self.rescale = 1.0;
        self.resamplings += 1;
    }

    /// Index of the particle with the greatest evidence along its whole line.
    pub fn best(&self) -> usize {
        let score = self.blocks.iter().flat_map(|b| b.evidence.iter().zip(&b.weights));
        let mut best = (f32::NEG_INFINITY, 0);
        for (i, (evidence, weight)) in score.enumerate() {
            let total = evidence + weight.ln();
            if total > best.0 {
                best = (total, i);
            }
        }
        best.1
    }

    /// Where a particle is, grid frame.
    pub fn position(&self, particle: usize) -> [f32; 2] {
        let (block, i) = (&self.blocks[particle / BLOCK], particle % BLOCK);
        let [x, y] = self.setting.hexagon.centre(block.cells[i]);
        [x + block.offsets[i][0], y + block.offsets[i][1]]
    }

    /// Positions of a particle and its ancestors in the grid frame, the start first.
    pub fn path(&self, particle: usize) -> Vec<[f32; 2]> {
        self.genealogy.path(particle)
    }

    /// The paths of `count` particles drawn by weight; `to_world` takes points from the grid frame.
    pub fn sample(&self, count: usize, to_world: impl Fn([f32; 2]) -> Vec2) -> PathTree {
        let weights = || self.blocks.iter().flat_map(|b| b.weights.iter().copied());
        let sum = weights().map(f64::from).sum();
        let drawn = systematic(weights(), sum, count, 0.5);
        PathTree::grow(&drawn, self.genealogy.len(), |layer, particle| {
            let (position, parent) = self.genealogy.look(layer, particle);
            (to_world(position), parent)
        })
    }

    /// Adds the expected crossings of all particles.
    pub fn add_to(&self, map: &mut TransitionMap) {
        let sum: f64 = self.blocks.iter().flat_map(|b| &b.weights).map(|&w| f64::from(w)).sum();
        let particles = self.blocks.iter().flat_map(|b| {
            b.weights.iter().zip(&b.pasts).zip(&b.tails).map(move |((&weight, past), tail)| {
                (TransitionMap::fixed(f64::from(weight) / sum), past, tail)
            })
        });
        self.archive.sum_up(particles, &mut |piece| match piece {
            Piece::Path(ids, fixed) => map.add_ids(ids, fixed),
            Piece::Edge(id, edge, fixed) => map.add_edge(id, edge, fixed),
        });
    }
}

impl Block {
    fn draw(setting: &Setting, first: usize, count: usize) -> Block {
        let (sigmas, normals) = (Sigmas::from(&setting.options.noise), Normals::table());
        let key = setting.key.with(0);
        let mut block = Block { weights: vec![1.0; count], evidence: vec![0.0; count], ..Block::default() };
        for i in (first..).take(count) {
            let [a, b, c, d] = normals.four(key.word(2 * i as u64));
            let [e, ..] = normals.four(key.word(2 * i as u64 + 1));
            let [position_sigma, heading_sigma] = setting.start_sigmas;
            let [x, y] = setting.start;
            let (cell, offset) = setting.hexagon.enter([x + position_sigma * a, y + position_sigma * b]);
            block.cells.push(cell);
            block.offsets.push(offset);
            block.errors.push(ErrorState::draw(&sigmas, heading_sigma, [c, d, e]));
            block.tails.push(Tail::new(setting.layout.id(cell)));
            block.pasts.push(Past::default());
        }
        block
    }

    fn positions(&self, hexagon: &Hexagon) -> Vec<[f32; 2]> {
        let absolute = |(&cell, offset): (&Cell, &[f32; 2])| {
            let [x, y] = hexagon.centre(cell);
            [x + offset[0], y + offset[1]]
        };
        self.cells.iter().zip(&self.offsets).map(absolute).collect()
    }

    fn advance(
        &mut self,
        setting: &Setting,
        archive: &Archive,
        step: &MeasuredStep,
        rescale: f32,
        key: Key,
        first: u64,
    ) -> (Sums, Vec<[f32; 2]>) {
        let count = self.cells.len();
        let (sigmas, normals) = (Sigmas::from(&setting.options.noise), Normals::table());
        let mut draws = [[0.0; 4]; BLOCK];
        for (i, draw) in draws[..count].iter_mut().enumerate() {
            *draw = normals.four(key.word(first + i as u64));
        }
        let (mut motions, mut directions) = ([[0.0; 2]; BLOCK], [[0.0; 2]; BLOCK]);
        let moved = motions.iter_mut().zip(&mut directions).zip(&draws);
        for (error, ((motion, direction), draw)) in self.errors.iter_mut().zip(moved) {
            (*error, *motion, *direction) = error.step(&sigmas, step, *draw);
        }
        let (layout, norm) = (&setting.layout, setting.options.norm_factor() as f32);
        let (alpha, alphas) = (setting.options.alpha as f32, (6.0 * setting.options.alpha) as f32);
        for (i, &motion) in motions[..count].iter().enumerate() {
            let (tail, past) = (&mut self.tails[i], &self.pasts[i]);
            let mut factor = rescale;
            let cross = |cell: Cell, edge: usize| {
                let to = layout.id(cell.across(edge));
                let (at_edge, at_cell) = archive.counts(layout, past, tail, edge, to);
                let (edge_prior, cell_prior) = match setting.prior {
                    Some(prior) => prior.at(layout.id(cell), edge),
                    None => (alpha, alphas),
                };
                factor *= norm * (edge_prior + at_edge as f32) / (cell_prior + at_cell as f32);
                tail.push(to);
            };
            let hexagon = &setting.hexagon;
            (self.cells[i], self.offsets[i]) =
                hexagon.walk(self.cells[i], self.offsets[i], motion, CROSSINGS_PER_STEP, cross);
            self.weights[i] *= factor;
        }
        let positions = self.positions(&setting.hexagon);
        (Sums::of_block(&self.weights, &positions, &directions[..count]), positions)
    }

    fn gather(&mut self, blocks: &[Block], parents: &[u32]) {
        for (i, &parent) in parents.iter().enumerate() {
            let (block, p) = (&blocks[parent as usize / BLOCK], parent as usize % BLOCK);
            self.cells[i] = block.cells[p];
            self.offsets[i] = block.offsets[p];
            self.errors[i] = block.errors[p];
            self.evidence[i] = block.evidence[p] + block.weights[p].ln();
            self.weights[i] = 1.0;
            self.tails[i].copy_from(&block.tails[p]);
            if !(block.pasts[p].is_empty() && self.pasts[i].is_empty()) {
                self.pasts[i].clone_from(&block.pasts[p]);
            }
        }
    }
}
