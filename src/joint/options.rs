//! Which objective, how much each kind of term is trusted, and who solves it.

use std::str::FromStr;

use super::{Backend, ceres};
use crate::error::{Error, Result};
use crate::solver::{self, Loss};

/// Which objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Formulation {
    /// R1…R4: the paper's objective where it is well defined, in a solvable form.
    #[default]
    Smooth,
    /// R1, R5, R6: the paper's residuals to the letter. For fidelity and cross-checking; its limits are documented.
    Paper,
}

impl Formulation {
    /// The name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::Smooth => "smooth",
            Formulation::Paper => "paper",
        }
    }
}

impl FromStr for Formulation {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        [Formulation::Smooth, Formulation::Paper]
            .into_iter()
            .find(|f| f.name() == name)
            .ok_or_else(|| Error::input("formulation", format!("found {name}, expected smooth or paper")))
    }
}

/// How R2 is written; the cost is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ObservationForm {
    /// Three residuals a pose, whatever the number of its points.
    #[default]
    Moments,
    /// One residual a point.
    Points,
}

/// How the observation terms of a feature add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Normalization {
    /// Every point counts: σ is per point.
    Sum,
    /// The paper's mean over S: σ is for the whole feature, however many points it has.
    Mean,
}

/// Weights of the joint problem. The defaults were measured (docs/RESULTS.md, docs/DECISIONS.md).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Which objective.
    pub formulation: Formulation,
    /// Who solves it.
    pub backend: Backend,
    /// σ of a point's distance to its segment, metres.
    pub observation_sigma_m: f64,
    /// Per point or per feature; `paper` is always per feature.
    pub normalization: Normalization,
    /// How R2 is written.
    pub observation_form: ObservationForm,
    /// σ of the tie along a segment, for the whole feature, metres.
    pub tie_sigma_m: f64,
    /// σ of the offset between related segments, metres: 1/K₁ of the paper.
    pub offset_sigma_m: f64,
    /// σ of the angle between related segments, radians: 1/K₂ of the paper.
    pub angle_sigma_rad: f64,
    /// Loss on loop closures (relative factors between poses that are not neighbours) and on relations.
    pub loss: Loss,
    /// Scale of the loss (Geman–McClure) on automatic factors, standard deviations.
    pub automatic_loss_scale: f64,
    /// Relative factors between neighbours may be wrong too: the loss is on them as well.
    pub doubt_odometry: bool,
    /// Stopping rules, of both back ends.
    pub solver: solver::Options,
    /// Choices that only Ceres has.
    pub ceres: ceres::Options,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            formulation: Formulation::default(),
            backend: Backend::default(),
            observation_sigma_m: 0.05,
            normalization: Normalization::Sum,
            observation_form: ObservationForm::default(),
            tie_sigma_m: 0.05,
            offset_sigma_m: 0.02,
            angle_sigma_rad: 0.01,
            loss: Loss::None,
            automatic_loss_scale: 4.0,
            doubt_odometry: false,
            solver: solver::Options::default(),
            ceres: ceres::Options::default(),
        }
    }
}

impl Options {
    /// Checks that every σ and scale is a number > 0 and that the back end is there.
    ///
    /// # Errors
    /// [`Error::Input`] that names the option.
    pub fn validate(&self) -> Result<()> {
        self.backend.require()?;
        let mut numbers = vec![
            ("observation sigma", self.observation_sigma_m),
            ("tie sigma", self.tie_sigma_m),
            ("offset sigma", self.offset_sigma_m),
            ("angle sigma", self.angle_sigma_rad),
            ("automatic loss scale", self.automatic_loss_scale),
        ];
        numbers.extend(self.loss.scale().map(|c| ("loss scale", c)));
        match numbers.into_iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
            Some((name, value)) => Err(Error::input(name, format!("found {value}, expected a number > 0"))),
            None => Ok(()),
        }
    }
}
