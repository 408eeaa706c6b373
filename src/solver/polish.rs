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

/// Takes Gauss–Newton steps from `x` while they are small, shrink, and leave the cost the same up to rounding, until
/// one is at most `options.step`. `equations` are those at `x`, with a factor of about there; `pending`: the step that
/// they give, if it is known. All together cannot move
/// anything by more than a millimetre.
pub(super) fn polish(
    problem: &dyn Problem,
    x: &mut Vec<Block>,
    equations: &mut NormalEquations,
    mut pending: Option<Vec<f64>>,
    options: &Options,
    final_cost: &mut f64,
) -> Polish {
    let mut done = Polish::default();
    let highest = *final_cost * (1.0 + options.relative_decrease);
    let mut longest = LONGEST_STEP;
    let mut fresh = false;
    while done.steps < MOST_STEPS {
        let step = pending.take().or_else(|| equations.step());
        let step_max = step.iter().flatten().fold(0.0_f64, |m, d| m.max(d.abs()));
        let target = if done.steps == 0 { LONGEST_STEP } else { longest * KEPT_SHRINKS_TO / SHRINKS_TO };
        if !fresh && (step.is_none() || step_max > target.max(options.step)) {
            equations.factor(0.0);
            fresh = true;
            continue;
        }
        let Some(delta) = step.filter(|_| step_max <= longest) else { break };
        let candidate = equations.moved(x, &delta);
        let candidate_cost = equations.assemble(problem, &candidate);
        fresh = false;
        // Also false if it is not a number.
        let as_good = candidate_cost <= highest;
        if !as_good {
            equations.assemble(problem, x);
            break;
        }
        *x = candidate;
        *final_cost = candidate_cost;
        done.steps += 1;
        done.last_step = step_max;
        if step_max <= options.step {
            done.settled = true;
            break;
        }
        longest = SHRINKS_TO * step_max;
    }
    done
}
