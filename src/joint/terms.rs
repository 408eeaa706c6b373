//! The joint problem as the solver sees it: blocks are the poses, the segments and the end points; terms come in the
//! order of [`TermKind`].

use nalgebra::Vector3;

use super::factors::{self, Pair};
use super::problem::{JointProblem, TermKind};
use crate::solver::{Block, Linearization, Loss, Problem};

impl JointProblem {
    /// Every block in one list: poses, segments, then start and end of every segment of `paper`.
    pub fn blocks(&self) -> Vec<Block> {
        let mut x = Vec::with_capacity(self.block_count());
        self.blocks_into(&mut x);
        x
    }

    /// The same in the memory of another list.
    pub(super) fn blocks_into(&self, x: &mut Vec<Block>) {
        x.clear();
        x.extend_from_slice(&self.poses);
        x.extend_from_slice(&self.segments);
        x.extend(self.ends.iter().flatten().map(|&[x, y]| [x, y, 0.0]));
    }

    /// How many those are.
    pub fn block_count(&self) -> usize {
        self.poses.len() + self.segments.len() + 2 * self.ends.len()
    }

    /// The inverse of [`JointProblem::blocks`].
    pub fn set_blocks(&mut self, x: &[Block]) {
        let (poses, rest) = x.split_at(self.poses.len());
        let (segments, ends) = rest.split_at(self.segments.len());
        self.poses.copy_from_slice(poses);
        self.segments.copy_from_slice(segments);
        for (to, from) in self.ends.iter_mut().flatten().zip(ends) {
            *to = [from[0], from[1]];
        }
    }

    /// Σ‖r‖² of all terms where they stand: no ½, no loss.
    pub fn chi2(&self) -> f64 {
        let x = self.blocks();
        (0..self.terms()).map(|k| self.residual(k, &x).norm_squared()).sum()
    }

    fn segment_block(&self, segment: usize) -> usize {
        self.poses.len() + segment
    }

    fn end_blocks(&self, segment: usize) -> [usize; 2] {
        let start = self.poses.len() + self.segments.len() + 2 * segment;
        [start, start + 1]
    }

    fn relation_end_blocks(&self, a: usize, b: usize) -> [usize; 4] {
        let ([a0, a1], [b0, b1]) = (self.end_blocks(a), self.end_blocks(b));
        [a0, a1, b0, b1]
    }

    /// The two blocks of a term of R1…R4.
    fn pair_blocks(&self, kind: TermKind, k: usize) -> (usize, usize) {
        match kind {
            TermKind::Relative => (self.relatives[k].i, self.relatives[k].j),
            TermKind::Sighting => (self.sightings[k].pose, self.segment_block(self.sightings[k].segment)),
            TermKind::Point => (self.points[k].pose, self.segment_block(self.points[k].segment)),
            TermKind::Tie => (self.ties[k].pose, self.segment_block(self.ties[k].segment)),
            _ => (self.segment_block(self.relations[k].a), self.segment_block(self.relations[k].b)),
        }
    }

    /// A term of R1…R4.
    fn pair(&self, kind: TermKind, k: usize, first: &Block, second: &Block) -> Pair {
        match kind {
            TermKind::Relative => factors::relative(&self.relatives[k], first, second),
            TermKind::Sighting => factors::sighting(&self.sightings[k], first, second),
            TermKind::Point => factors::point(&self.points[k], first, second),
            TermKind::Tie => factors::tie(&self.ties[k], first, second),
            _ => factors::relation(&self.relations[k], first, second),
        }
    }
}

impl Problem for JointProblem {
    fn terms(&self) -> usize {
        self.counts().iter().map(|c| c.1).sum()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        if let Some(relative) = self.relatives.get(term) {
            blocks.extend([relative.i, relative.j]);
            return;
        }
        match self.kind_of(term) {
            None => {}
            Some((TermKind::Fit, k)) => {
                let fit = &self.fits[k];
                blocks.extend(fit.sightings.iter().map(|s| s.pose));
                blocks.extend(self.end_blocks(fit.segment));
            }
            Some((TermKind::PaperRelation, k)) => {
                let t = &self.paper_relations[k];
                blocks.extend(self.relation_end_blocks(t.a, t.b));
            }
            Some((kind, k)) => {
                let (first, second) = self.pair_blocks(kind, k);
                blocks.extend([first, second]);
            }
        }
    }

    fn loss_of(&self, term: usize) -> Loss {
        match self.kind_of(term) {
            Some((TermKind::Relative, k)) => self.relatives[k].loss,
            Some((TermKind::Relation, k)) => self.relations[k].loss,
            Some((TermKind::PaperRelation, k)) => self.paper_relations[k].loss,
            _ => Loss::None,
        }
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        match self.kind_of(term) {
            None => Vector3::zeros(),
            Some((TermKind::Fit, k)) => {
                let fit = &self.fits[k];
                factors::paper_fit_residual(fit, x, self.end_blocks(fit.segment).map(|e| &x[e]))
            }
            Some((TermKind::PaperRelation, _)) => {
                let mut at = Linearization::default();
                self.linearize(term, x, &mut at);
                at.residual
            }
            Some((kind, k)) => {
                let (first, second) = self.pair_blocks(kind, k);
                self.pair(kind, k, &x[first], &x[second]).residual
            }
        }
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        match self.kind_of(term) {
            None => {}
            Some((TermKind::Fit, k)) => {
                let fit = &self.fits[k];
                factors::paper_fit(fit, x, self.end_blocks(fit.segment), at);
            }
            Some((TermKind::PaperRelation, k)) => {
                let t = &self.paper_relations[k];
                factors::paper_relation(t, x, self.relation_end_blocks(t.a, t.b), at);
            }
            Some((kind, k)) => {
                let (first, second) = self.pair_blocks(kind, k);
                let pair = self.pair(kind, k, &x[first], &x[second]);
                at.residual = pair.residual;
                at.jacobians.extend([(first, pair.j_first), (second, pair.j_second)]);
            }
        }
    }
}
