//! How much each kind of term is trusted.

use crate::error::{Error, Result};
use crate::solver::{self, Loss};

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
    /// σ of a point's distance to its segment, metres.
    pub observation_sigma_m: f64,
    /// Per point or per feature.
    pub normalization: Normalization,
    /// σ of the tie along a segment, for the whole feature, metres.
    pub tie_sigma_m: f64,
    /// σ of the offset between related segments, metres: 1/K₁ of the paper.
    pub offset_sigma_m: f64,
    /// σ of the angle between related segments, radians: 1/K₂ of the paper.
    pub angle_sigma_rad: f64,
    /// Loss on loop closures (relative factors between poses that are not neighbours) and on relations.
    pub loss: Loss,
    /// Stopping rules.
    pub solver: solver::Options,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            observation_sigma_m: 0.05,
            normalization: Normalization::Sum,
            tie_sigma_m: 0.05,
            offset_sigma_m: 0.02,
            angle_sigma_rad: 0.01,
            loss: Loss::None,
            solver: solver::Options::default(),
        }
    }
}

impl Options {
    /// Checks that every σ and scale is a number > 0.
    ///
    /// # Errors
    /// [`Error::Input`] that names the option.
    pub fn validate(&self) -> Result<()> {
        let mut numbers = vec![
            ("observation sigma", self.observation_sigma_m),
            ("tie sigma", self.tie_sigma_m),
            ("offset sigma", self.offset_sigma_m),
            ("angle sigma", self.angle_sigma_rad),
        ];
        if let Loss::Huber(c) | Loss::Cauchy(c) | Loss::GemanMcClure(c) = self.loss {
            numbers.push(("loss scale", c));
        }
        match numbers.into_iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
            Some((name, value)) => Err(Error::input(name, format!("found {value}, expected a number > 0"))),
            None => Ok(()),
        }
    }
}
