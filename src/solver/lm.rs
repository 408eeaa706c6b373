//! Gauss–Newton with Levenberg–Marquardt damping where a step does not lower the true cost, as prose.
//!
//! A factor of H is kept while it serves: near the minimum H hardly changes, and the old factor with the new gradient makes
//! steps that are nearly as good for a fraction of the work. Where they are not, H is factored anew.

use std::time::Instant;

use super::normal_equations::NormalEquations;
use super::polish::{Place, polish};
use super::step::Step;
use super::{Block, Iteration, Options, Problem, Report, Termination};

/// λ below which the step is Gauss–Newton for all that doubles can tell.
const NEGLIGIBLE_DAMPING: f64 = 1e-10;
/// λ above which the step is so short that more damping cannot help.
const HOPELESS_DAMPING: f64 = 1e12;
/// So many undamped steps are taken on trust before they have to have lowered the cost together.
const LOOKS_AHEAD: usize = 3;
/// A factor is kept after a step that promised less than this share of the cost.
const KEEPS_BELOW: f64 = 1e-2;
/// A step with a kept factor must be shorter than this share of the one before, or H is factored anew.
const KEPT_SHRINKS_TO: f64 = 0.1;

/// A problem structure made ready: its ordering and pattern, and the memory of its factor. It serves every problem whose
/// terms meet the same blocks.
#[derive(Debug, Clone, Default)]
pub struct Solver {
    pub(super) equations: NormalEquations,
    /// Where a step leads.
    candidate: Vec<Block>,
    order_ms: f64,
    free: usize,
}

/// Minimises the problem from `x`; `held` (ascending) are blocks that must not move.
/// `x` holds the best point found, whatever the termination.
pub fn minimize(problem: &dyn Problem, x: &mut Vec<Block>, held: &[usize], options: &Options) -> Report {
    Solver::new(problem, x.len(), held).minimize(problem, x, options)
}

impl Solver {
    /// Analyses a problem of so many blocks; `held` (ascending) must not move.
    pub fn new(problem: &dyn Problem, blocks: usize, held: &[usize]) -> Self {
        let mut solver = Solver::default();
        solver.analyse(problem, blocks, held);
        solver
    }

    /// Makes it ready for another problem, in the memory that it has. Results do not depend on what it solved before.
    pub fn analyse(&mut self, problem: &dyn Problem, blocks: usize, held: &[usize]) {
        let start = Instant::now();
        self.equations.analyse(problem, blocks, held);
        self.free = blocks - held.len();
        self.order_ms = milliseconds(start);
    }

    /// Minimises from `x`, which then holds the best point found, whatever the termination.
    pub fn minimize(&mut self, problem: &dyn Problem, x: &mut Vec<Block>, options: &Options) -> Report {
        let start = Instant::now();
        let cost = self.equations.assemble(problem, x);
        let mut report = Report::new(cost, Termination::NotFinite);
        report.timings.order_ms = self.order_ms;
        if cost.is_finite() {
            if problem.terms() == 0 || self.free == 0 {
                report.termination = Termination::NothingToOptimize;
            } else {
                self.iterate(problem, x, options, &mut report);
            }
        }
        report.timings.iterate_ms = milliseconds(start);
        report.timings.total_ms = self.order_ms + report.timings.iterate_ms;
        report
    }

    /// One undamped Gauss–Newton step from `x`, whatever it does to the cost: the minimum, if the problem is linear.
    /// `None` if it is not finite.
    pub fn gauss_newton_step(&mut self, problem: &dyn Problem, x: &[Block]) -> Option<Vec<Block>> {
        self.equations.assemble(problem, x);
        self.equations.factor(problem, x, 0.0);
        let mut moved = x.to_vec();
        self.equations.step()?;
        self.equations.advance(&mut moved);
        Some(moved)
    }

    fn iterate(&mut self, problem: &dyn Problem, x: &mut Vec<Block>, options: &Options, report: &mut Report) {
        let mut search = Search { damping: 0.0, last_steps: [f64::INFINITY; 2], ..Search::default() };
        self.candidate.clone_from(x);
        report.termination = loop {
            if report.accepted_steps() >= options.max_iterations {
                break Termination::MaxIterations;
            }
            if let Some(termination) = self.descend(problem, x, &mut search, options, report) {
                break termination;
            }
        };
        report.undetermined = self.equations.undetermined();
        if report.termination != Termination::MaxIterations {
            let Search { pending, last_steps, .. } = search;
            let at = Place {
                x,
                candidate: &mut self.candidate,
                cost: &mut report.final_cost,
                last_steps,
                pending,
            };
            report.polish = polish(problem, at, &mut self.equations, options);
            report.conclude_polish();
        }
    }

    /// Tries steps until one lowers the cost; `Some` when it is time to stop. The equations are those at `x`, before and
    /// after.
    fn descend(
        &mut self,
        problem: &dyn Problem,
        x: &mut Vec<Block>,
        search: &mut Search,
        options: &Options,
        report: &mut Report,
    ) -> Option<Termination> {
        let gradient_max = self.equations.gradient_max();
        let mut factor = 10.0;
        loop {
            if !search.kept {
                self.equations.factor(problem, x, search.damping);
            }
            search.fresh = !search.kept;
            let Some(step) = self.equations.step() else {
                if search.retry(&mut factor, options) {
                    continue;
                }
                return Some(Termination::NoProgress);
            };
            let Step { max: step_max, promised } = step;
            let rounding = promised <= options.relative_decrease * report.final_cost.max(f64::MIN_POSITIVE);
            if search.kept && !rounding && step_max > KEPT_SHRINKS_TO * search.last_steps[0] {
                search.kept = false;
                continue;
            }
            if rounding || step_max <= options.step {
                search.pending = Some(step).filter(|_| search.damping == 0.0);
                return Some(if rounding { Termination::ConvergedCost } else { Termination::ConvergedStep });
            }
            self.equations.advance_from(x, &mut self.candidate);
            let share = promised / report.final_cost;
            let keeps = search.damping == 0.0 && share < KEEPS_BELOW;
            let mut candidate_cost = if keeps {
                self.equations.assemble_gradient(problem, &self.candidate)
            } else {
                self.equations.assemble(problem, &self.candidate)
            };
            // Along a strong factor a straight step leaves the valley, and the next ones lead back into it, further down.
            let mut ahead = 0;
            let falls = |cost: f64| cost < report.final_cost;
            while search.damping == 0.0 && !falls(candidate_cost) && ahead < LOOKS_AHEAD {
                ahead += 1;
                self.equations.factor(problem, &self.candidate, 0.0);
                search.fresh = true;
                if self.equations.step().is_none() {
                    break;
                }
                self.equations.advance(&mut self.candidate);
                candidate_cost = self.equations.assemble(problem, &self.candidate);
            }
            let accepted = falls(candidate_cost);
            if accepted {
                std::mem::swap(x, &mut self.candidate);
                report.final_cost = candidate_cost;
            } else {
                self.equations.assemble(problem, x);
            }
            report.iterations.push(Iteration {
                cost: report.final_cost,
                gradient_max,
                step_max,
                damping: search.damping,
                accepted,
            });
            if accepted {
                search.succeeded(step_max, keeps);
                return None;
            }
            if !search.retry(&mut factor, options) {
                return Some(Termination::NoProgress);
            }
        }
    }
}

/// How the next step is to be made.
#[derive(Default)]
struct Search {
    /// λ.
    damping: f64,
    /// True if the factor at hand was made where the search stands.
    fresh: bool,
    /// True if the factor at hand is to be used again.
    kept: bool,
    /// Largest entries of the last accepted step and of the one before it.
    last_steps: [f64; 2],
    /// The step at hand, if it is undamped and was too small to be tried.
    pending: Option<Step>,
}

impl Search {
    fn succeeded(&mut self, step_max: f64, keeps: bool) {
        self.damping /= 10.0;
        if self.damping < NEGLIGIBLE_DAMPING {
            self.damping = 0.0;
        }
        self.last_steps = [step_max, self.last_steps[0]];
        self.kept = keeps;
    }

    /// After a step that failed: a fresh factor if it was an old one, else more damping: times 10, times 100 after the
    /// next, and so on. A single jump would land so far above a weak direction's scale that a handful of short steps are
    /// needed to come back. False if more damping is hopeless.
    fn retry(&mut self, factor: &mut f64, options: &Options) -> bool {
        self.kept = false;
        if self.fresh {
            self.damping = if self.damping == 0.0 { options.initial_damping } else { self.damping * *factor };
            *factor *= 10.0;
        }
        self.damping <= HOPELESS_DAMPING
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
