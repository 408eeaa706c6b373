//! The joint problem on our own solver: blocks are the poses, then the segments; terms are R1, R2, R3, R4 in turn.

use nalgebra::Vector3;

use super::factors;
use super::problem::JointProblem;
use crate::error::Result;
use crate::solver::{self, Block, Linearization, Loss, Options, Problem, Report};

/// One term of a [`JointProblem`].
enum Term<'a> {
    Relative(&'a super::problem::RelativeTerm),
    Sighting(&'a super::problem::SightingTerm),
    Tie(&'a super::problem::TieTerm),
    Relation(&'a super::problem::RelationTerm),
}

impl JointProblem {
    fn term(&self, k: usize) -> Term<'_> {
        let k2 = k.wrapping_sub(self.relatives.len());
        let k3 = k2.wrapping_sub(self.sightings.len());
        let k4 = k3.wrapping_sub(self.ties.len());
        if k < self.relatives.len() {
            Term::Relative(&self.relatives[k])
        } else if k2 < self.sightings.len() {
            Term::Sighting(&self.sightings[k2])
        } else if k3 < self.ties.len() {
            Term::Tie(&self.ties[k3])
        } else {
            Term::Relation(&self.relations[k4])
        }
    }
}

impl Problem for JointProblem {
    fn terms(&self) -> usize {
        self.relatives.len() + self.sightings.len() + self.ties.len() + self.relations.len()
    }

    fn blocks_of(&self, term: usize) -> (usize, usize) {
        let segment = |s: usize| self.poses.len() + s;
        match self.term(term) {
            Term::Relative(t) => (t.i, t.j),
            Term::Sighting(t) => (t.pose, segment(t.segment)),
            Term::Tie(t) => (t.pose, segment(t.segment)),
            Term::Relation(t) => (segment(t.a), segment(t.b)),
        }
    }

    fn loss_of(&self, term: usize) -> Loss {
        match self.term(term) {
            Term::Relative(t) => t.loss,
            Term::Relation(t) => t.loss,
            Term::Sighting(_) | Term::Tie(_) => Loss::None,
        }
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        self.linearize(term, x).residual
    }

    fn linearize(&self, term: usize, x: &[Block]) -> Linearization {
        let (first, second) = self.blocks_of(term);
        let (first, second) = (&x[first], &x[second]);
        match self.term(term) {
            Term::Relative(t) => factors::relative(t, first, second),
            Term::Sighting(t) => factors::sighting(t, first, second),
            Term::Tie(t) => factors::tie(t, first, second),
            Term::Relation(t) => factors::relation(t, first, second),
        }
    }
}

impl JointProblem {
    /// Every block in one list: poses, then segments.
    pub fn blocks(&self) -> Vec<Block> {
        self.poses.iter().chain(&self.segments).copied().collect()
    }

    /// Σ‖r‖² of all terms where they stand: no ½, no loss.
    pub fn chi2(&self) -> f64 {
        let x = self.blocks();
        (0..self.terms()).map(|k| self.residual(k, &x).norm_squared()).sum()
    }
}

/// Minimises the problem in place: `problem.poses` and `problem.segments` hold the result.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed problem.
pub fn solve(problem: &mut JointProblem, options: &Options) -> Result<Report> {
    problem.validate()?;
    let mut x = problem.blocks();
    let report = solver::minimize(problem, &mut x, &problem.held, options)?;
    problem.segments = x.split_off(problem.poses.len());
    problem.poses = x;
    Ok(report)
}
