//! Stages 1 and 2: what did the person mean? (Section "Human Input Interpretation" of the paper.)
//!
//! `em` snaps a drawn stroke to the wall it stands for, `feature` keeps the poses that saw enough of it,
//! `order` decides which of two features comes first along the chain, whatever the order of drawing.

mod double;
mod em;
mod feature;
mod order;
mod stroke;

pub use double::two_walls;
pub use em::Fit;
pub use feature::{Caught, Reach, catch, make_feature};
pub use order::{Split, split};
pub use stroke::{anchor, check, in_world};

use crate::error::{Error, Result};

/// How strokes are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// σ: a person's drawing accuracy, metres.
    pub drawing_sigma_m: f64,
    /// T_p: a pose belongs to X only if it saw at least this many of the selected points; `None`: by scan density.
    pub min_points: Option<usize>,
    /// EM rounds at most.
    pub max_rounds: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { drawing_sigma_m: 0.05, min_points: None, max_rounds: 30 }
    }
}

impl Options {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Input`] that names the option.
    pub fn validate(&self) -> Result<()> {
        if !(self.drawing_sigma_m.is_finite() && self.drawing_sigma_m > 0.0) {
            let message = format!("found {}, expected a number > 0", self.drawing_sigma_m);
            return Err(Error::input("drawing sigma", message));
        }
        if self.min_points == Some(0) {
            return Err(Error::input("min points", "found 0, expected at least 1"));
        }
        Ok(())
    }
}
