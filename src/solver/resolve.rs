//! Solving again what was solved before, with other weights: from the last solution, on the last factorisation, of which
//! only the supernodes whose part of H changed are made anew, and those above them.
//!
//! H is that of a point x̄ near the estimate: every block of x̄ stays where it is until the estimate has gone too far from
//! it, as in Kaess et al., *iSAM2*, IJRR 2012, so that what did not change has the very numbers that were factored. The
//! gradient is that of the estimate itself: where the steps end does not depend on x̄, only how many they are.

use super::normal_equations::NormalEquations;
use super::polish::next_step;
use super::structure::NONE;
use super::{Block, Iteration, Options, Problem, Report, Solver, Termination};

/// A block of x̄ follows the estimate when it is further away than this (metres, radians).
const FOLLOWS_BEYOND: f64 = 1e-3;
/// After a step longer than this it is looked whether x̄ must follow.
const FOLLOWS_FROM: f64 = 1e-2;
/// A step must be shorter than this share of the one before, or x̄ follows.
const SHRINKS_TO: f64 = 0.2;
/// With x̄ at the estimate itself it must be shorter than this share, or the search begins anew, damped where need be.
const FRESH_SHRINKS_TO: f64 = 0.9;
/// The cost may rise by this share of it: the rounding of a sum of some 1e5 terms.
const RISES_BY: f64 = 1e-12;
/// More steps than this are a search.
const MOST_STEPS: usize = 30;

/// A solved problem and its factorisation. Takes more memory than a [`Solver`]: every supernode keeps what it hands up.
#[derive(Debug, Clone, Default)]
pub struct Resolver {
    solver: Solver,
    /// x̄.
    linearised: Vec<Block>,
    /// Scratch: where a step leads.
    candidate: Vec<Block>,
    /// Scratch, by supernode: to be factored anew.
    changed: Vec<bool>,
    refactored: usize,
}

impl Resolver {
    /// Solves a problem from `x` as [`Solver::minimize`] does, to the last digits, whatever was solved before, and is then
    /// ready to solve it again. `held` (ascending) must not move.
    pub fn solve(
        &mut self,
        problem: &dyn Problem,
        x: &mut Vec<Block>,
        held: &[usize],
        options: &Options,
    ) -> Report {
        self.solver.analyse(problem, x.len(), held);
        self.solver.equations.keep_updates();
        self.search(problem, x, options)
    }

    /// Solves it again from `x`, where it ended. `changed`: the terms that are not what they were, on the same blocks.
    pub fn solve_again(
        &mut self,
        problem: &dyn Problem,
        x: &mut Vec<Block>,
        changed: &[usize],
        options: &Options,
    ) -> Report {
        let start = std::time::Instant::now();
        let equations = &mut self.solver.equations;
        self.changed.clear();
        self.changed.resize(equations.structure.supernodes.len(), false);
        mark(equations, problem, changed.iter().copied(), &mut self.changed);
        self.refactored = 0;
        self.refactor(problem);
        let mut report = match self.steps(problem, x, options) {
            Some(report) => report,
            None => self.search(problem, x, options),
        };
        report.timings.iterate_ms = start.elapsed().as_secs_f64() * 1e3;
        report.timings.total_ms = report.timings.iterate_ms;
        report
    }

    /// Supernodes that the last [`Resolver::solve_again`] factored (one that was factored twice counts twice), and how many
    /// there are.
    pub fn refactored(&self) -> (usize, usize) {
        (self.refactored, self.changed.len())
    }

    /// The whole search, a factor of where it ends, and what steps with that still gain.
    fn search(&mut self, problem: &dyn Problem, x: &mut Vec<Block>, options: &Options) -> Report {
        let mut report = self.solver.minimize(problem, x, options);
        self.linearised.clone_from(x);
        self.changed.clear();
        self.changed.resize(self.solver.equations.structure.supernodes.len(), true);
        self.refactor(problem);
        if report.termination.converged()
            && let Some(further) = self.steps(problem, x, options)
        {
            report.final_cost = further.final_cost;
        }
        report
    }

    fn refactor(&mut self, problem: &dyn Problem) {
        self.refactored += self.solver.equations.refactor(problem, &self.linearised, &mut self.changed);
        self.changed.fill(false);
    }

    /// x̄ follows the estimate where it is further away than `beyond`, and everywhere if that is nowhere or in a third of all
    /// blocks; true if everywhere. The gradient is that of the estimate before and after.
    fn follow(&mut self, problem: &dyn Problem, x: &[Block], beyond: f64) -> bool {
        let far = |(a, b): (&Block, &Block)| a.iter().zip(b).any(|(a, b)| (a - b).abs() > beyond);
        let moved: Vec<bool> = self.linearised.iter().zip(x).map(far).collect();
        let count = moved.iter().filter(|m| **m).count();
        if count == 0 || 3 * count > moved.len() {
            self.linearised.copy_from_slice(x);
            self.changed.fill(true);
            self.refactor(problem);
            return true;
        }
        for (k, _) in moved.iter().enumerate().filter(|m| *m.1) {
            self.linearised[k] = x[k];
        }
        let mut blocks = Vec::new();
        let mut touches = |term: usize| {
            blocks.clear();
            problem.blocks_of(term, &mut blocks);
            blocks.iter().any(|&b| moved[b])
        };
        let terms = (0..problem.terms()).filter(|&t| touches(t)).collect::<Vec<_>>();
        mark(&self.solver.equations, problem, terms.into_iter(), &mut self.changed);
        self.refactor(problem);
        self.solver.equations.assemble_gradient(problem, x);
        false
    }

    /// Steps with the factor at hand until the next would be too short; `None` if they do not get there.
    fn steps(&mut self, problem: &dyn Problem, x: &mut Vec<Block>, options: &Options) -> Option<Report> {
        let mut cost = self.solver.equations.assemble_gradient(problem, x);
        let mut report = Report::new(cost, Termination::ConvergedStep);
        let mut last = f64::INFINITY;
        let mut fresh = false;
        while report.iterations.len() < MOST_STEPS {
            let equations = &mut self.solver.equations;
            let gradient_max = equations.gradient_max();
            let step = equations.step();
            let step_max = step.map_or(f64::NAN, |step| step.max);
            // Each also false if something is not a number.
            let shrinks = step_max <= last * if fresh { FRESH_SHRINKS_TO } else { SHRINKS_TO };
            let mut good = shrinks || step_max <= options.step;
            let mut candidate_cost = f64::NAN;
            if good {
                self.candidate.clone_from(x);
                equations.advance(&mut self.candidate);
                candidate_cost = equations.assemble_gradient(problem, &self.candidate);
                good = candidate_cost <= cost * (1.0 + RISES_BY);
                if !good && !fresh {
                    equations.assemble_gradient(problem, x);
                }
            }
            if !good && fresh {
                break;
            }
            if !good {
                fresh = self.follow(problem, x, FOLLOWS_BEYOND);
                last = f64::INFINITY;
                continue;
            }
            std::mem::swap(x, &mut self.candidate);
            cost = candidate_cost;
            report.iterations.push(Iteration { cost, gradient_max, step_max, damping: 0.0, accepted: true });
            report.final_cost = cost;
            if next_step(step_max, [last, f64::INFINITY]) <= options.step {
                report.undetermined = self.solver.equations.undetermined();
                return Some(report);
            }
            last = step_max;
            fresh = step_max > FOLLOWS_FROM && self.follow(problem, x, FOLLOWS_BEYOND);
        }
        None
    }
}

/// Marks the supernodes that these terms add to.
fn mark(
    equations: &NormalEquations,
    problem: &dyn Problem,
    terms: impl Iterator<Item = usize>,
    changed: &mut [bool],
) {
    let mut blocks = Vec::new();
    for term in terms {
        blocks.clear();
        problem.blocks_of(term, &mut blocks);
        for column in blocks.iter().filter_map(|&b| equations.column(b)) {
            changed[equations.structure.supernode_of[column] as usize] = true;
        }
    }
}

impl NormalEquations {
    /// From here on every supernode keeps its update matrix.
    fn keep_updates(&mut self) {
        self.structure.place_updates_apart();
        self.factor.fit(&self.structure);
    }

    /// Factors H at x̄ anew in these supernodes, and in all above them, which are then marked too; says how many. g is
    /// that of x̄ afterwards.
    fn refactor(&mut self, problem: &dyn Problem, linearised: &[Block], changed: &mut [bool]) -> usize {
        for (s, node) in self.structure.supernodes.iter().enumerate() {
            if changed[s] && node.parent != NONE {
                changed[node.parent as usize] = true;
            }
        }
        self.assemble(problem, linearised);
        self.factor_changed(changed);
        changed.iter().filter(|c| **c).count()
    }
}
