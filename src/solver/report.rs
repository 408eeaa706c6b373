//! What a solve did, as data. Printing it is somebody else's job.

/// One accepted or refused step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Cost after the step if it was accepted, else the cost kept.
    pub cost: f64,
    /// Largest entry of the gradient before the step.
    pub gradient_max: f64,
    /// Largest entry of the step (metres, radians); Ceres gives the step's Euclidean norm instead.
    pub step_max: f64,
    /// λ used; with Ceres 1/(trust-region radius).
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
    /// The gradient is as flat as rounding can tell (Ceres only).
    ConvergedGradient,
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
            Termination::ConvergedCost
                | Termination::ConvergedStep
                | Termination::ConvergedGradient
                | Termination::NothingToOptimize
        )
    }

    /// snake_case name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Termination::ConvergedCost => "converged_cost",
            Termination::ConvergedStep => "converged_step",
            Termination::ConvergedGradient => "converged_gradient",
            Termination::MaxIterations => "max_iterations",
            Termination::NoProgress => "no_progress",
            Termination::NothingToOptimize => "nothing_to_optimize",
            Termination::NotFinite => "not_finite",
        }
    }
}

/// Wall-clock times of a solve, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timings {
    /// Fill-reducing ordering and symbolic analysis, once; with Ceres its whole preprocessing.
    pub order_ms: f64,
    /// The iterations.
    pub iterate_ms: f64,
    /// All, including what is neither.
    pub total_ms: f64,
}

/// Gauss–Newton steps after the last iteration, whose gain the cost cannot show; no iterations of their own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Polish {
    /// How many were taken.
    pub steps: usize,
    /// Largest entry of the last one (metres, radians); 0 without any.
    pub last_step: f64,
    /// True if no step longer than the tolerance is due after it.
    pub settled: bool,
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
    /// The last digits.
    pub polish: Polish,
    /// Why it stopped.
    pub termination: Termination,
    /// Blocks with a number that nothing determines as far as doubles can tell, ascending: it was left about where it was.
    pub undetermined: Vec<usize>,
    /// Times.
    pub timings: Timings,
    /// What a person should know of, in sentences: parts without a held pose, lines that Ceres logged.
    pub warnings: Vec<String>,
}

impl Report {
    /// A report of a solve that has not begun.
    pub fn new(initial_cost: f64, termination: Termination) -> Self {
        Report {
            initial_cost,
            final_cost: initial_cost,
            iterations: Vec::new(),
            polish: Polish::default(),
            termination,
            undetermined: Vec::new(),
            timings: Timings::default(),
            warnings: Vec::new(),
        }
    }

    /// The table ends at the final cost, and a solve whose last step was negligible has converged even if no step
    /// could lower the cost any more.
    pub(crate) fn conclude_polish(&mut self) {
        if self.polish.steps > 0
            && let Some(last) = self.iterations.last_mut()
        {
            last.cost = self.final_cost;
        }
        if self.polish.settled && self.termination == Termination::NoProgress {
            self.termination = Termination::ConvergedStep;
        }
    }

    /// Number of accepted steps.
    pub fn accepted_steps(&self) -> usize {
        self.iterations.iter().filter(|i| i.accepted).count()
    }
}
