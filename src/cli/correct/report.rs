//! The report of `hitl correct`, field by field as docs/FORMATS.md gives it.

use hitl_slam::map::Mode;
use hitl_slam::pipeline::{self, CorrectionReport};
use serde::Serialize;

use super::{Corrected, contradictions};
use crate::cli::reassociate;
use crate::cli::report::peak_rss_mb;
use crate::cli::tunables::Tunables;

/// The whole report.
#[derive(Debug, Serialize)]
pub struct Report {
    version: &'static str,
    solver: &'static str,
    formulation: &'static str,
    settings: Settings,
    pub poses: usize,
    pub observations: usize,
    pub corrections: Vec<Entry>,
    pub contradictions: Vec<contradictions::Entry>,
    #[serde(flatten)]
    reassociation: reassociate::Summary,
    pub total_ms: f64,
    pub peak_rss_mb: Option<f64>,
}

/// The tunables, and T_p as it was used.
#[derive(Debug, Serialize)]
struct Settings {
    #[serde(flatten)]
    tunables: Tunables,
    min_points_used: usize,
}

/// One correction.
#[derive(Debug, Serialize)]
pub struct Entry {
    pub id: String,
    pub mode: Mode,
    pub accepted: bool,
    pub reason: Option<String>,
    pub poses_a: usize,
    pub poses_b: usize,
    pub observations_a: usize,
    pub observations_b: usize,
    pub offset_before_m: Option<f64>,
    pub offset_after_m: Option<f64>,
    pub angle_before_rad: Option<f64>,
    pub angle_after_rad: Option<f64>,
    pub chi2: Option<f64>,
    pub iterations: usize,
    pub termination: Option<&'static str>,
    pub initial_cost: Option<f64>,
    pub final_cost: Option<f64>,
    pub interpret_ms: f64,
    pub explicit_ms: f64,
    pub copslam_ms: f64,
    pub optimize_ms: f64,
    pub total_ms: f64,
    strokes: Vec<Stroke>,
}

impl Entry {
    /// Names of the strokes whose EM was stopped before it had settled.
    pub fn unsettled(&self) -> Vec<&'static str> {
        let is_unsettled = |s: &&Stroke| s.snapped.is_some() && !s.em_settled;
        self.strokes.iter().filter(is_unsettled).map(|s| s.name).collect()
    }
}

/// What one stroke caught (an addition to the contract: what `--interpret-only` is for).
#[derive(Debug, Serialize)]
struct Stroke {
    name: &'static str,
    drawn: [[f64; 2]; 2],
    snapped: Option<[[f64; 2]; 2]>,
    em_rounds: usize,
    em_settled: bool,
}

impl Report {
    /// Gathers everything.
    pub fn new(done: &Corrected, tunables: &Tunables) -> Self {
        let Corrected { corrector, reports, reassociation, total_ms, .. } = done;
        let map = corrector.map();
        Report {
            version: env!("CARGO_PKG_VERSION"),
            solver: corrector.options().joint.backend.name(),
            formulation: tunables.formulation.name(),
            settings: Settings { tunables: tunables.clone(), min_points_used: corrector.min_points() },
            poses: map.poses.len(),
            observations: map.observations.len(),
            corrections: reports.iter().map(entry).collect(),
            contradictions: done.contradictions.clone(),
            reassociation: reassociate::Summary::new(map, reassociation.as_ref()),
            total_ms: *total_ms,
            peak_rss_mb: peak_rss_mb(),
        }
    }
}

fn entry(r: &CorrectionReport) -> Entry {
    let solve = r.solve.as_ref();
    Entry {
        id: r.id.clone(),
        mode: r.mode,
        accepted: r.accepted(),
        reason: r.rejection.clone(),
        poses_a: r.poses[0],
        poses_b: r.poses[1],
        observations_a: r.observations[0],
        observations_b: r.observations[1],
        offset_before_m: r.offset_m[0],
        offset_after_m: r.offset_m[1],
        angle_before_rad: r.angle_rad[0],
        angle_after_rad: r.angle_rad[1],
        chi2: r.chi2,
        iterations: solve.map_or(0, |s| s.iterations.len()),
        termination: solve.map(|s| s.termination.name()),
        initial_cost: solve.map(|s| s.initial_cost),
        final_cost: solve.map(|s| s.final_cost),
        interpret_ms: r.timings.interpret_ms,
        explicit_ms: r.timings.explicit_ms,
        copslam_ms: r.timings.copslam_ms,
        optimize_ms: r.timings.optimize_ms,
        total_ms: r.timings.total_ms,
        strokes: r.strokes.iter().map(stroke).collect(),
    }
}

fn stroke(stroke: &pipeline::Stroke) -> Stroke {
    let plain = |ends: [hitl_slam::geometry::Vec2; 2]| ends.map(|p| [p.x, p.y]);
    let fit = stroke.caught.as_ref().map(|c| &c.fit);
    Stroke {
        name: stroke.name,
        drawn: plain(stroke.drawn),
        snapped: fit.map(|f| plain(f.segment.ends())),
        em_rounds: fit.map_or(0, |f| f.rounds),
        em_settled: fit.is_some_and(|f| f.settled),
    }
}
