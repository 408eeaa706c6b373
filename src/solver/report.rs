//! What a solve did, as data. Printing it is somebody else's job.

/// One accepted or refused step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Cost after the step if it was accepted, else the cost kept.
    pub cost: f64,
    /// Largest entry of the gradient before the step.
    pub gradient_max: f64,
    /// Largest entry of the step (metres, radians).
    pub step_max: f64,
    /// λ used.
    pub damping: f64,
    /// True if the true cost fell.
    pub accepted: bool,
}

/// Why the solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Termination {
    /// The next step would lower the cost by less than rounding can show.
    ConvergedCost,
    /// The next step is shorter than anybody could measure.
    ConvergedStep,
    /// Stopped at the limit of iterations: not converged.
    MaxIterations,
    /// No damping made the cost fall: not converged.
    NoProgress,
    /// Nothing to do: every block is held, or there is no term.
    NothingToOptimize,
    /// The cost is not finite at the start.
    NotFinite,
}

impl Termination {
    /// True if the result is a minimum as far as numbers can tell.
    pub fn converged(self) -> bool {
        matches!(
            self,
            Termination::ConvergedCost | Termination::ConvergedStep | Termination::NothingToOptimize
        )
    }

    /// snake_case name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Termination::ConvergedCost => "converged_cost",
            Termination::ConvergedStep => "converged_step",
            Termination::MaxIterations => "max_iterations",
            Termination::NoProgress => "no_progress",
            Termination::NothingToOptimize => "nothing_to_optimize",
            Termination::NotFinite => "not_finite",
        }
    }
}

/// Result of a solve.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// ½ Σ ρ at the start.
    pub initial_cost: f64,
    /// ½ Σ ρ at the end.
    pub final_cost: f64,
    /// Every step tried, in order.
    pub iterations: Vec<Iteration>,
    /// Why it stopped.
    pub termination: Termination,
}

impl Report {
    /// Number of accepted steps.
    pub fn accepted_steps(&self) -> usize {
        self.iterations.iter().filter(|i| i.accepted).count()
    }
}
