//! The last digits: where the cost cannot show progress any more, the gradient still can.
//!
//! The cost has a relative rounding error of some 1e-13, so that along a direction of curvature h it cannot tell points
//! √(1e-13 · cost / h) apart: micrometres where a long chain is weakly held. The gradient is good to far less. Undamped
//! Gauss–Newton steps use it alone; the cost only stands guard.

use super::normal_equations::NormalEquations;
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

/// Steps of a kept factor shrink by about the same share each; a first one that shrinks by more is luck.
const SHRINKS_AT_BEST_TO: f64 = 0.1;

/// How long the step after this one will be, if they go on as they do.
pub(super) fn next_step(step: f64, before: f64) -> f64 {
    if before.is_finite() { step * (step / before).max(SHRINKS_AT_BEST_TO) } else { step }
}

/// Where the search ended: the point, memory for another, and the cost.
pub(super) struct Place<'a> {
    pub x: &'a mut Vec<Block>,
    pub candidate: Vec<Block>,
    pub cost: &'a mut f64,
}

/// Takes Gauss–Newton steps from `at.x` while they are small, shrink, and leave the cost the same up to rounding, until
/// the next would be at most `options.step`. `equations` are those there, with a factor of about there; `pending`: they hold the step
/// that these give. All together cannot move anything by more than a millimetre.
pub(super) fn polish(
    problem: &dyn Problem,
    mut at: Place,
    equations: &mut NormalEquations,
    mut pending: bool,
    options: &Options,
) -> Polish {
    let mut done = Polish::default();
    let highest = *at.cost * (1.0 + options.relative_decrease);
    let mut longest = LONGEST_STEP;
    let mut before = f64::INFINITY;
    let mut fresh = false;
    while done.steps < MOST_STEPS {
        let finite = std::mem::take(&mut pending) || equations.step();
        let step_max = equations.step_max();
        let target = if done.steps == 0 { LONGEST_STEP } else { longest * KEPT_SHRINKS_TO / SHRINKS_TO };
        if !fresh && (!finite || step_max > target.max(options.step)) {
            equations.factor(problem, at.x, 0.0);
            fresh = true;
            continue;
        }
        if !finite || step_max > longest {
            break;
        }
        at.candidate.copy_from_slice(at.x);
        equations.advance(&mut at.candidate);
        let candidate_cost = equations.assemble_gradient(problem, &at.candidate);
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
        std::mem::swap(at.x, &mut at.candidate);
        *at.cost = candidate_cost;
        done.steps += 1;
        done.last_step = step_max;
        if next_step(step_max, before) <= options.step {
            done.settled = true;
            break;
        }
        before = step_max;
        longest = SHRINKS_TO * step_max;
    }
    done
}
