//! Every tunable of the pipeline as a flag; all are echoed in the report.

use clap::ValueEnum;
use hitl_slam::error::Result;
use hitl_slam::joint::{Formulation, Normalization};
use hitl_slam::pipeline::Options;
use serde::Serialize;

use super::loss::LossArgs;
use super::options::{at_least_one, positive};

/// Flags of the pipeline.
#[derive(Debug, Clone, clap::Args, Serialize)]
#[command(next_help_heading = "Tunables")]
pub struct Tunables {
    /// The objective: smooth, or paper (the paper's residuals to the letter; see docs/RESULTS.md before use).
    #[arg(long, value_name = "smooth|paper", default_value = "smooth")]
    pub formulation: Formulation,

    /// A person's drawing accuracy σ, metres.
    #[arg(long, value_name = "M", default_value_t = Options::default().interpret.drawing_sigma_m)]
    pub drawing_sigma_m: f64,

    /// T_p: a pose takes part only if it saw so many of the selected points [default: by scan density, 3 to 12].
    #[arg(long, value_name = "N")]
    pub min_points: Option<usize>,

    /// σ of a point's distance to its wall, metres.
    #[arg(long, value_name = "M", default_value_t = Options::default().joint.observation_sigma_m)]
    pub observation_sigma_m: f64,

    /// Whether that σ is per point (sum) or for the whole feature (mean, as in the paper).
    #[arg(long, value_enum, default_value = "sum")]
    pub normalization: NormalizationFlag,

    /// σ of the tie along a wall, metres.
    #[arg(long, value_name = "M", default_value_t = Options::default().joint.tie_sigma_m)]
    pub tie_sigma_m: f64,

    /// σ of the offset between related walls, metres: 1/K₁ of the paper.
    #[arg(long, value_name = "M", default_value_t = Options::default().joint.offset_sigma_m)]
    pub offset_sigma_m: f64,

    /// σ of the angle between related walls, radians: 1/K₂ of the paper.
    #[arg(long, value_name = "RAD", default_value_t = Options::default().joint.angle_sigma_rad)]
    pub angle_sigma_rad: f64,

    /// The loss.
    #[command(flatten)]
    #[serde(flatten)]
    pub loss: LossArgs,

    /// Scale of the bounded loss on automatic factors (re-association), standard deviations.
    #[arg(long, value_name = "S", default_value_t = Options::default().joint.automatic_loss_scale)]
    pub automatic_loss_scale: f64,

    /// Solver steps per correction at most.
    #[arg(long, value_name = "N", default_value_t = Options::default().joint.solver.max_iterations)]
    pub max_iterations: usize,

    /// Skip the explicit correction and COP-SLAM: the solver starts from the map as it stands.
    #[arg(long)]
    pub no_initial_guess: bool,
}

/// [`Normalization`] as a flag.
#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NormalizationFlag {
    /// σ per point.
    Sum,
    /// σ per feature.
    Mean,
}

impl Tunables {
    /// The pipeline's options.
    pub fn options(&self) -> Result<Options> {
        self.check()?;
        let mut options = Options { initial_guess: !self.no_initial_guess, ..Options::default() };
        options.interpret.drawing_sigma_m = self.drawing_sigma_m;
        options.interpret.min_points = self.min_points;
        options.joint.observation_sigma_m = self.observation_sigma_m;
        options.joint.normalization = match self.normalization {
            NormalizationFlag::Sum => Normalization::Sum,
            NormalizationFlag::Mean => Normalization::Mean,
        };
        options.joint.tie_sigma_m = self.tie_sigma_m;
        options.joint.offset_sigma_m = self.offset_sigma_m;
        options.joint.angle_sigma_rad = self.angle_sigma_rad;
        options.joint.formulation = self.formulation;
        options.joint.loss = self.loss.loss()?;
        options.joint.automatic_loss_scale = self.automatic_loss_scale;
        options.joint.solver.max_iterations = self.max_iterations;
        options.interpret.validate()?;
        options.joint.validate()?;
        Ok(options)
    }

    fn check(&self) -> Result<()> {
        positive("--drawing-sigma-m", self.drawing_sigma_m)?;
        at_least_one("--min-points", self.min_points.unwrap_or(1))?;
        positive("--observation-sigma-m", self.observation_sigma_m)?;
        positive("--tie-sigma-m", self.tie_sigma_m)?;
        positive("--offset-sigma-m", self.offset_sigma_m)?;
        positive("--angle-sigma-rad", self.angle_sigma_rad)?;
        positive("--automatic-loss-scale", self.automatic_loss_scale)?;
        at_least_one("--max-iterations", self.max_iterations)
    }
}
