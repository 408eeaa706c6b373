//! What one correction did, as data.

use crate::geometry::Vec2;
use crate::interpret::Caught;
use crate::map::{Correction, HumanFactor, Mode};
use crate::solver;

/// One stroke as drawn and as understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// `a` or `b`, as in the correction.
    pub name: &'static str,
    /// The drawn ends, world frame.
    pub drawn: [Vec2; 2],
    /// What it caught, if anything.
    pub caught: Option<Caught>,
}

/// Wall-clock times of the stages, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timings {
    /// Stages 1 and 2.
    pub interpret_ms: f64,
    /// Stage 3.
    pub explicit_ms: f64,
    /// Stage 4.
    pub copslam_ms: f64,
    /// Stage 5.
    pub optimize_ms: f64,
    /// All of them.
    pub total_ms: f64,
}

/// What one correction did.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionReport {
    /// The correction's name.
    pub id: String,
    /// Its mode.
    pub mode: Mode,
    /// False: switched off in the file, and skipped.
    pub enabled: bool,
    /// Why it was not applied; `None`: it was.
    pub rejection: Option<String>,
    /// The strokes, in the order of the correction.
    pub strokes: Vec<Stroke>,
    /// True if stroke `b` was the one seen earlier along the chain.
    pub swapped: bool,
    /// |X_a|, |X_b|, `a` being the earlier feature.
    pub poses: [usize; 2],
    /// |S_a|, |S_b|.
    pub observations: [usize; 2],
    /// Distance that the mode wants to be zero, metres: before and after; `None` if it wants none.
    pub offset_m: [Option<f64>; 2],
    /// Angle that the mode wants to be zero, radians: before and after.
    pub angle_rad: [Option<f64>; 2],
    /// This factor's Σ‖r‖² after its own solve.
    pub chi2: Option<f64>,
    /// The solve.
    pub solve: Option<solver::Report>,
    /// Times.
    pub timings: Timings,
}

impl CorrectionReport {
    pub(super) fn new(correction: &Correction) -> Self {
        CorrectionReport {
            id: correction.id.clone(),
            mode: correction.mode,
            enabled: correction.enabled,
            rejection: None,
            strokes: Vec::with_capacity(2),
            swapped: false,
            poses: [0; 2],
            observations: [0; 2],
            offset_m: [None; 2],
            angle_rad: [None; 2],
            chi2: None,
            solve: None,
            timings: Timings::default(),
        }
    }

    /// True if the map was changed.
    pub fn accepted(&self) -> bool {
        self.rejection.is_none()
    }

    /// The first reason stays.
    pub(super) fn refuse(&mut self, reason: String) {
        self.rejection.get_or_insert(reason);
    }

    pub(super) fn caught(&mut self, factor: &HumanFactor, swapped: bool) {
        self.swapped = swapped;
        let features = [&factor.a, &factor.b];
        self.poses = features.map(|f| f.sightings.len());
        self.observations = features.map(|f| f.points.len());
    }

    pub(super) fn before(&mut self, factor: &HumanFactor) {
        self.offset_m[0] = factor.offset_m();
        self.angle_rad[0] = Some(factor.angle_rad());
    }

    pub(super) fn after(&mut self, factor: &HumanFactor, chi2: f64) {
        self.offset_m[1] = factor.offset_m();
        self.angle_rad[1] = Some(factor.angle_rad());
        self.chi2 = Some(chi2);
    }

    pub(super) fn solved(&mut self, solve: &solver::Report) {
        self.solve = Some(solve.clone());
    }
}
