//! Robust losses as flags.

use clap::ValueEnum;
use hitl_slam::error::Result;
use hitl_slam::solver::Loss;
use serde::Serialize;

use super::options::positive;

/// Which loss, and how wide.
#[derive(Debug, Clone, Copy, clap::Args, Serialize)]
pub struct LossArgs {
    /// Robust loss on loop closures and on relations.
    #[arg(long, value_enum, default_value = "none")]
    pub loss: LossFlag,

    /// Scale of the loss, standard deviations.
    #[arg(long, visible_alias = "loss-width", value_name = "S", default_value_t = 2.0)]
    pub loss_scale: f64,
}

/// [`Loss`] as a flag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossFlag {
    /// Least squares.
    None,
    /// Quadratic, then linear.
    Huber,
    /// Logarithmic.
    Cauchy,
    /// Bounded.
    #[value(name = "geman-mcclure", alias = "geman-mc-clure")]
    #[serde(rename = "geman-mcclure")]
    GemanMcClure,
}

impl LossArgs {
    /// The loss.
    ///
    /// # Errors
    /// [`hitl_slam::error::Error::Input`] for a scale that is not > 0.
    pub fn loss(&self) -> Result<Loss> {
        positive("--loss-scale", self.loss_scale)?;
        Ok(match self.loss {
            LossFlag::None => Loss::None,
            LossFlag::Huber => Loss::Huber(self.loss_scale),
            LossFlag::Cauchy => Loss::Cauchy(self.loss_scale),
            LossFlag::GemanMcClure => Loss::GemanMcClure(self.loss_scale),
        })
    }
}
