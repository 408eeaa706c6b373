//! Corrections reweighted, taken out and put back: solved again from the last solution and the last factorisation.
//!
//! For whoever turns one knob and looks what it does: the problem's structure stands, so that its ordering, its compiled terms
//! and all of its factor that the knob does not reach serve on. The minimum is that of the batch solver, found on another
//! way: equal to the last digits of a step, not bit for bit.

use nalgebra::Vector3;

use super::compiled::{Compiled, Relative};
use super::problem::{JointProblem, TermKind};
use crate::error::{Error, Result};
use crate::solver::{Block, Linearization, Loss, Options, PairQuadratic, Problem, Report, Resolver};

/// A joint problem, solved, with a weight for every human factor.
#[derive(Debug, Clone, Default)]
pub struct Reweighing {
    problem: JointProblem,
    relatives: Vec<Relative>,
    /// By human factor: what multiplies its weight in `problem`.
    weights: Vec<f64>,
    /// By human factor: its terms.
    terms_of: Vec<Vec<usize>>,
    x: Vec<Block>,
    resolver: Resolver,
    options: Options,
}

impl Reweighing {
    /// Solves a problem from where it stands.
    ///
    /// # Errors
    /// [`Error::Input`] for a malformed problem.
    pub fn new(problem: JointProblem, options: &Options) -> Result<(Self, Report)> {
        let mut all = Reweighing { options: *options, ..Reweighing::default() };
        let report = all.replace(problem)?;
        Ok((all, report))
    }

    /// Takes another problem, say with one more human factor, and solves it from where it stands: in the memory at hand,
    /// all weights 1.
    ///
    /// # Errors
    /// [`Error::Input`] for a malformed problem; the old one stays.
    pub fn replace(&mut self, problem: JointProblem) -> Result<Report> {
        problem.validate()?;
        let factors = problem.segments.len().max(problem.ends.len()) / 2;
        self.weights = vec![1.0; factors];
        self.terms_of = vec![Vec::new(); factors];
        for term in problem.relatives.len()..problem.terms() {
            if let Some(k) = human_factor(&problem, term) {
                self.terms_of[k].push(term);
            }
        }
        self.relatives = Compiled::relatives(&problem, std::mem::take(&mut self.relatives));
        self.x = problem.blocks();
        self.problem = problem;
        let weighed = Weighed::new(&self.problem, &self.relatives, &self.weights);
        let report = self.resolver.solve(&weighed, &mut self.x, &self.problem.held, &self.options);
        self.problem.set_blocks(&self.x);
        Ok(report)
    }

    /// Gives human factors (by their order in the problem) a multiple of the weight that they came with, 0 takes one out,
    /// and solves again.
    ///
    /// # Errors
    /// [`Error::Input`] for a factor that is not there or a weight that is negative or not finite; nothing changes then.
    pub fn reweigh(&mut self, weights: &[(usize, f64)]) -> Result<Report> {
        let count = self.weights.len();
        for &(k, weight) in weights {
            if k >= count || !(weight >= 0.0 && weight.is_finite()) {
                let message = format!("found weight {weight}, expected one >= 0 for a factor below {count}");
                return Err(Error::input(format!("human factor {k}"), message));
            }
        }
        let mut changed = Vec::new();
        for &(k, weight) in weights {
            self.weights[k] = weight;
            changed.extend(&self.terms_of[k]);
        }
        let weighed = Weighed::new(&self.problem, &self.relatives, &self.weights);
        let report = self.resolver.solve_again(&weighed, &mut self.x, &changed, &self.options);
        self.problem.set_blocks(&self.x);
        Ok(report)
    }

    /// The problem where it is solved, with the weights that it came with.
    pub fn problem(&self) -> &JointProblem {
        &self.problem
    }

    /// What multiplies the weight of every human factor.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Supernodes that the last [`Reweighing::reweigh`] factored anew, and how many there are.
    pub fn refactored(&self) -> (usize, usize) {
        self.resolver.refactored()
    }
}

/// The human factor that a term belongs to: P_a and P_b of every one stand in turn.
fn human_factor(problem: &JointProblem, term: usize) -> Option<usize> {
    let (kind, k) = problem.kind_of(term)?;
    let segment = match kind {
        TermKind::Relative => return None,
        TermKind::Sighting => problem.sightings[k].segment,
        TermKind::Point => problem.points[k].segment,
        TermKind::Tie => problem.ties[k].segment,
        TermKind::Relation => problem.relations[k].a,
        TermKind::Fit => problem.fits[k].segment,
        TermKind::PaperRelation => problem.paper_relations[k].a,
    };
    Some(segment / 2)
}

/// The problem with its weights.
struct Weighed<'a> {
    compiled: Compiled<'a>,
    weights: &'a [f64],
}

impl<'a> Weighed<'a> {
    fn new(problem: &'a JointProblem, relatives: &'a [Relative], weights: &'a [f64]) -> Self {
        Weighed { compiled: Compiled::again(problem, relatives), weights }
    }

    /// Weighs a term's quadratic form, if there is one. Relative factors stand as they are.
    fn weigh(&self, term: usize, known: bool, at: &mut PairQuadratic) -> bool {
        if known && let Some(k) = human_factor(self.compiled.problem(), term) {
            at.scale(self.weights[k]);
        }
        known
    }

    /// √ of what multiplies a term's squared norm.
    fn root(&self, term: usize) -> f64 {
        human_factor(self.compiled.problem(), term).map_or(1.0, |k| self.weights[k].sqrt())
    }
}

impl Problem for Weighed<'_> {
    fn terms(&self) -> usize {
        self.compiled.terms()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        self.compiled.blocks_of(term, blocks);
    }

    fn loss_of(&self, term: usize) -> Loss {
        self.compiled.loss_of(term)
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        self.compiled.residual(term, x) * self.root(term)
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        self.compiled.linearize(term, x, at);
        let root = self.root(term);
        at.residual *= root;
        for (_, j) in &mut at.jacobians {
            *j *= root;
        }
    }

    fn turns(&self, x: &[Block], turns: &mut Vec<[f64; 2]>) {
        self.compiled.turns(x, turns);
    }

    fn pair_quadratic(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        let known = self.compiled.pair_quadratic(term, x, turns, at);
        self.weigh(term, known, at)
    }

    fn pair_gradient(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        let known = self.compiled.pair_gradient(term, x, turns, at);
        self.weigh(term, known, at)
    }
}
