//! The last digits: where the cost cannot show progress any more, the gradient still can.
//!
//! The cost has a relative rounding error of some 1e-13, so that along a direction of curvature h it cannot tell points
//! √(1e-13 · cost / h) apart: micrometres where a long chain is weakly held. The gradient is good to far less. Undamped
//! Gauss–Newton steps use it alone; the cost only stands guard.

use super::normal_equations::NormalEquations;
use super::step::Step;
use super::{Block, Options, Polish, Problem};

/// A step that is longer and still gains nothing that the cost could show lies along a direction that nothing
/// determines.
const LONGEST_STEP: f64 = 1e-4;

/// A step must be shorter than this share of the one before, or what is left is rounding.
const SHRINKS_TO: f64 = 0.9;

/// With an old factor it must be shorter than this share, or H is factored anew.
const KEPT_SHRINKS_TO: f64 = 0.2;

/// Enough for the linear convergence under robust losses; without them two or three do.
const MOST_STEPS: usize = 20;

/// Steps of a kept factor shrink by about the same share each; a first one that shrinks by more is luck, and so is a
/// second one that shrinks by more than the other.
const SHRINKS_AT_BEST_TO: [f64; 2] = [0.1, 0.03];

/// It ends when the step after is shorter than this share of the tolerance: two solves of one problem, each with as much
/// still before it, are then less than the tolerance apart.
const LEAVES: f64 = 0.3;

/// How long the step after this one will be, if they go on as they do; `before`: the step before it and the one before
/// that, infinite where there was none.
pub(super) fn next_step(step: f64, before: [f64; 2]) -> f64 {
    let [last, earlier] = before;
    if earlier.is_finite() {
        step * (step / last).max(last / earlier).max(SHRINKS_AT_BEST_TO[1])
    } else if last.is_finite() {
        step * (step / last).max(SHRINKS_AT_BEST_TO[0])
    } else {
        step
    }
}

/// Where the search ended: the point, memory for another, and the cost.
pub(super) struct Place<'a> {
    pub x: &'a mut Vec<Block>,
    /// The same as `x` where it is held.
    pub candidate: &'a mut Vec<Block>,
    pub cost: &'a mut f64,
    /// Largest entries of the step that led there and of the one before it; infinite if there was none.
    pub last_steps: [f64; 2],
    /// The next step, if the equations hold it already.
    pub pending: Option<Step>,
}

/// Takes Gauss–Newton steps from `at.x` while they are small, shrink, and leave the cost the same up to rounding, until
/// the next would be far below `options.step`. `equations` are those there, with a factor of about there. All together cannot
/// move anything by more than a millimetre.
///
/// A step that promises less than the cost can show, and after which none is due, is taken without a look at the cost:
/// that would be a pass over all terms for a number that is known already.
pub(super) fn polish(
    problem: &dyn Problem,
    mut at: Place,
    equations: &mut NormalEquations,
    options: &Options,
) -> Polish {
    let mut done = Polish::default();
    let highest = *at.cost * (1.0 + options.relative_decrease);
    let mut longest = LONGEST_STEP;
    let mut before = at.last_steps;
    let mut fresh = false;
    while done.steps < MOST_STEPS {
        let step = at.pending.take().or_else(|| equations.step());
        let step_max = step.map_or(f64::INFINITY, |step| step.max);
        let target = if done.steps == 0 { LONGEST_STEP } else { longest * KEPT_SHRINKS_TO / SHRINKS_TO };
        if !fresh && step_max > target.max(options.step) {
            equations.factor(problem, at.x, 0.0);
            fresh = true;
            continue;
        }
        if step_max > longest {
            break;
        }
        let is_last = next_step(step_max, before) <= LEAVES * options.step;
        if is_last && step.is_some_and(|step| step.promised <= options.relative_decrease * *at.cost) {
            equations.advance(at.x);
            done = Polish { steps: done.steps + 1, last_step: step_max, settled: true };
            break;
        }
        equations.advance_from(at.x, at.candidate);
        let candidate_cost = equations.assemble_gradient(problem, at.candidate);
        // Also false if it is not a number.
        let as_good = candidate_cost <= highest;
        if !as_good && fresh {
            break;
        }
        if !as_good {
            equations.assemble(problem, at.x);
            equations.factor(problem, at.x, 0.0);
            fresh = true;
            continue;
        }
        fresh = false;
        std::mem::swap(at.x, at.candidate);
        *at.cost = candidate_cost;
        done.steps += 1;
        done.last_step = step_max;
        if is_last {
            done.settled = true;
            break;
        }
        before = [step_max, before[0]];
        longest = SHRINKS_TO * step_max;
    }
    done
}
