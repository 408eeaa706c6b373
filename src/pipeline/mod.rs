//! The main job: one correction after the other, each in the paper's five stages.
//!
//! [`crate::interpret`] (EM, then order) → [`crate::explicit`] → [`crate::copslam`] → [`crate::joint`].
//! Then, if wanted, [`crate::closures`] (re-association) finds what now fits by itself.
//! A correction that cannot be applied is rejected with its reason and leaves the map as it was.

mod agreeing;
mod closing;
mod report;
mod state;
mod understood;

pub use agreeing::Agreement;
pub use report::{CorrectionReport, Stroke, Timings};
pub use state::{Standing, State};

use std::time::Instant;

use crate::closures;
use crate::copslam;
use crate::error::{Error, Result};
use crate::explicit;
use crate::geometry::{Pose2, Segment, Vec2, angle_diff};
use crate::interpret::{self, Caught, Reach, Split};
use crate::joint;
use crate::map::{AutomaticFactor, Correction, Feature, HumanFactor, Mode, SlamMap};
use crate::solver;

/// A jump is spread over at least this many edges, widening the gap into X_a and X_b if need be.
const MIN_GAP_EDGES: usize = 10;

/// Tunables of the whole pipeline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Stages 1 and 2.
    pub interpret: interpret::Options,
    /// Stage 5.
    pub joint: joint::Options,
    /// Stages 3 and 4; off: the solver starts from the map as it stands.
    pub initial_guess: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options { interpret: Default::default(), joint: Default::default(), initial_guess: true }
    }
}

/// A correction on its way: where its stages 1 to 4 leave the map, ready for the joint optimisation.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// Start of the optimisation.
    pub poses: Vec<Pose2>,
    /// The map's human factors and, last, the new one.
    pub factors: Vec<HumanFactor>,
    report: CorrectionReport,
    start: Instant,
}

/// What re-association did, and how long it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Reassociation {
    /// Rounds, and where visits pass each other unmatched.
    pub report: closures::Report,
    /// Wall clock, milliseconds.
    pub total_ms: f64,
}

/// A correction worked out on the map as it stands, and not taken into it.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// What the map would be; `None`: the correction is rejected.
    pub state: Option<State>,
    /// What it would do; the reason if it is rejected.
    pub report: CorrectionReport,
}

/// A map under correction.
#[derive(Debug, Clone)]
pub struct Corrector {
    map: SlamMap,
    options: Options,
    reach: Reach,
    chain_variances: Vec<(f64, f64)>,
    memory: joint::Memory,
}

impl Corrector {
    /// Takes a map.
    ///
    /// # Errors
    /// [`crate::error::Error::Input`] for options out of range or a map that cannot be corrected (no points).
    pub fn new(map: SlamMap, options: Options) -> Result<Self> {
        options.interpret.validate()?;
        options.joint.validate()?;
        options.joint.backend.require()?;
        map.validate("map")?;
        if map.observations.is_empty() {
            let message = "found none, expected laser points for the strokes to catch";
            return Err(Error::input("map: points", message));
        }
        let reach = Reach::new(&map.observations);
        let chain_variances = copslam::chain_variances(&map);
        Ok(Corrector { map, options, reach, chain_variances, memory: joint::Memory::default() })
    }

    /// The options it was made with.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The map as it stands.
    pub fn map(&self) -> &SlamMap {
        &self.map
    }

    /// T_p in use.
    pub fn min_points(&self) -> usize {
        self.options.interpret.min_points.unwrap_or(self.reach.min_points())
    }

    /// The map, handed back.
    pub fn into_map(self) -> SlamMap {
        self.map
    }

    /// Stages 1 and 2 alone: what a correction would do, on the map as it stands.
    ///
    /// # Errors
    /// [`crate::error::Error::Input`] for a stroke that names a pose or stamp that the map does not have.
    pub fn preview(&self, correction: &Correction) -> Result<CorrectionReport> {
        Ok(self.understand(correction)?.0)
    }

    /// Stages 1 and 2; no factor if the correction is disabled or cannot be applied, and the report says why.
    fn understand(
        &self,
        correction: &Correction,
    ) -> Result<(CorrectionReport, Option<(HumanFactor, Split)>)> {
        let start = Instant::now();
        let mut report = CorrectionReport::new(correction);
        if !correction.enabled {
            report.refuse("disabled".into());
            return Ok((report, None));
        }
        let mut caught = Vec::with_capacity(2);
        for (name, stroke) in [("a", &correction.a), ("b", &correction.b)] {
            let drawn = interpret::in_world(&self.map, &self.map.poses, stroke)?;
            let reading = interpret::catch(
                &self.map.observations,
                &self.map.poses,
                &self.reach,
                drawn,
                &self.options.interpret,
            );
            report.strokes.push(Stroke { name, drawn, caught: reading.as_ref().ok().cloned() });
            match reading {
                Ok(reading) => caught.push(reading),
                Err(reason) => report.refuse(format!("stroke {name}: {reason}")),
            }
        }
        report.timings.interpret_ms = milliseconds(start);
        report.timings.total_ms = report.timings.interpret_ms;
        let [a, b] = &caught[..] else { return Ok((report, None)) };
        let anchors = [&correction.a, &correction.b].map(|stroke| interpret::anchor(&self.map, stroke));
        let split = interpret::split(a, b, anchors);
        let (sides, anchors) = match split.swapped {
            true => ([b, a], [anchors[1], anchors[0]]),
            false => ([a, b], anchors),
        };
        let Some(factor) = self.factor(correction, sides, anchors, split.cut) else {
            report.refuse(ambiguous(correction.mode));
            return Ok((report, None));
        };
        report.caught(&factor, split.swapped);
        report.before(&factor);
        report.timings.interpret_ms = milliseconds(start);
        report.timings.total_ms = report.timings.interpret_ms;
        Ok((report, Some((factor, split))))
    }

    /// Applies one correction; the report says whether it was accepted.
    ///
    /// # Errors
    /// As [`Corrector::preview`]; a correction that is merely not applicable is no error.
    pub fn apply(&mut self, correction: &Correction) -> Result<CorrectionReport> {
        let proposal = self.propose(correction)?;
        Ok(self.accept(proposal))
    }

    /// All stages of one correction, the map left as it is: what [`Corrector::accept`] would make of it.
    ///
    /// # Errors
    /// As [`Corrector::apply`].
    pub fn propose(&self, correction: &Correction) -> Result<Proposal> {
        let mut prepared = match self.prepare(correction)? {
            Ok(prepared) => prepared,
            Err(report) => return Ok(Proposal { state: None, report: *report }),
        };
        let stage = Instant::now();
        let Prepared { poses, factors, .. } = &mut prepared;
        let solve = match joint::optimize_in(&self.memory, &self.map, poses, factors, &self.options.joint) {
            Ok(solve) => solve,
            // Map and options are sound: only numbers that overflow on the way can have made the problem unsound.
            Err(Error::Input { .. }) => {
                prepared.report.refuse("the numbers of the map are too large to compute with".into());
                return Ok(Proposal { state: None, report: prepared.report });
            }
            Err(error) => return Err(error),
        };
        prepared.report.timings.optimize_ms = milliseconds(stage);
        Ok(self.judge(prepared, &solve))
    }

    /// Takes a proposal that was made on the map as it stands; the report says whether it was accepted.
    pub fn accept(&mut self, proposal: Proposal) -> CorrectionReport {
        if let Some(State { poses, human_factors, automatic_factors }) = proposal.state {
            self.map.poses = poses;
            self.map.human_factors = human_factors;
            self.map.automatic_factors = automatic_factors;
        }
        proposal.report
    }

    /// Stages 1 to 4 of one correction: all that comes before the joint optimisation. The map stays as it is.
    /// The inner error is the report of a rejected correction.
    ///
    /// # Errors
    /// As [`Corrector::preview`].
    pub fn prepare(
        &self,
        correction: &Correction,
    ) -> Result<std::result::Result<Prepared, Box<CorrectionReport>>> {
        let start = Instant::now();
        let (mut report, understood) = self.understand(correction)?;
        let Some((factor, split)) = understood else { return Ok(Err(Box::new(report))) };
        let mut poses = self.map.poses.clone();
        if self.options.initial_guess {
            self.guess(&factor, split, &mut poses, &mut report);
        }
        let mut factors = self.map.human_factors.clone();
        factors.push(factor);
        Ok(Ok(Prepared { poses, factors, report, start }))
    }

    /// Takes a solved correction into the map; the report says whether it was accepted.
    pub fn conclude(&mut self, prepared: Prepared, solve: &solver::Report) -> CorrectionReport {
        let proposal = self.judge(prepared, solve);
        self.accept(proposal)
    }

    /// What a solved correction leaves, if its numbers are sound.
    fn judge(&self, prepared: Prepared, solve: &solver::Report) -> Proposal {
        let Prepared { poses, factors, mut report, start } = prepared;
        report.solved(solve);
        if !solve.final_cost.is_finite() || poses.iter().any(|p| !p.is_finite()) {
            report.refuse("the joint optimisation did not give finite numbers".into());
            return Proposal { state: None, report };
        }
        if let Some(factor) = factors.last() {
            report.after(factor, joint::factor_chi2(&self.map, &poses, factor, &self.options.joint));
        }
        report.timings.total_ms = milliseconds(start);
        let automatic_factors = judged(&self.map.automatic_factors, &poses);
        Proposal { state: Some(State { poses, human_factors: factors, automatic_factors }), report }
    }

    /// The human factor, directions aligned so that sin Δφ (cos Δφ) has its zero in reach; `None`: ambiguous.
    fn factor(
        &self,
        correction: &Correction,
        [a, b]: [&Caught; 2],
        [anchor_a, anchor_b]: [Option<usize>; 2],
        cut: usize,
    ) -> Option<HumanFactor> {
        let (segment_a, mut segment_b) = (a.fit.segment, b.fit.segment);
        explicit::rotation(correction.mode, &segment_a, &segment_b)?;
        if angle_diff(segment_b.direction_rad, segment_a.direction_rad).abs() > std::f64::consts::FRAC_PI_2 {
            segment_b = Segment::from_ends(segment_b.ends()[1], segment_b.ends()[0]);
        }
        let (observations, poses) = (&self.map.observations, &self.map.poses);
        Some(HumanFactor {
            id: correction.id.clone(),
            mode: correction.mode,
            weight: correction.weight,
            a: interpret::make_feature(segment_a, a, ..cut, anchor_a, observations, poses),
            b: interpret::make_feature(segment_b, b, cut.., anchor_b, observations, poses),
        })
    }

    /// Stages 3 and 4: moves X_b and all that follows, then bends the gap. Skipped where there is no gap to bend
    /// (all support on one side) or where a held pose would have to move: the solver alone does those.
    fn guess(&self, factor: &HumanFactor, split: Split, poses: &mut [Pose2], report: &mut CorrectionReport) {
        let (Some(last_of_a), Some(first_of_b)) = (split.last_of_a, split.first_of_b) else { return };
        let (last_of_a, first_of_b) = widen(last_of_a, first_of_b, poses.len());
        if self.map.held.iter().any(|&pose| pose > last_of_a) {
            return;
        }
        let stage = Instant::now();
        let pivot = mean_point(&factor.b, &self.map, poses);
        let Some(corrected_from_world) =
            explicit::correction(factor.mode, &factor.a.segment, &factor.b.segment, pivot)
        else {
            return;
        };
        let gap_end = poses[first_of_b];
        for pose in &mut poses[first_of_b..] {
            *pose = corrected_from_world.compose(*pose);
        }
        report.timings.explicit_ms = milliseconds(stage);
        let stage = Instant::now();
        let target = std::mem::replace(&mut poses[first_of_b], gap_end);
        let gap = last_of_a..first_of_b;
        copslam::distribute(&mut poses[gap.start..=gap.end], &self.chain_variances[gap], target);
        report.timings.copslam_ms = milliseconds(stage);
    }
}

/// A gap of at least [`MIN_GAP_EDGES`], grown on both sides as far as the chain goes.
fn widen(last_of_a: usize, first_of_b: usize, poses: usize) -> (usize, usize) {
    let missing = MIN_GAP_EDGES.saturating_sub(first_of_b - last_of_a);
    let start = last_of_a.saturating_sub(missing.div_ceil(2));
    let end = (first_of_b + missing / 2).min(poses - 1);
    (start, end)
}

/// Mean of a feature's points at `poses`, world frame.
fn mean_point(feature: &Feature, map: &SlamMap, poses: &[Pose2]) -> Vec2 {
    let sum: Vec2 = feature
        .points_by_sighting(&map.observations)
        .flat_map(|(sighting, points)| points.iter().map(move |&p| (sighting.pose, p)))
        .map(|(pose, p)| poses[pose].transform_point(map.observations.point(p as usize)))
        .sum();
    sum / feature.points.len() as f64
}

/// The same automatic factors, each with its χ² at `poses`.
fn judged(factors: &[AutomaticFactor], poses: &[Pose2]) -> Vec<AutomaticFactor> {
    let judge = |a: &AutomaticFactor| {
        let chi2 = a.factor.chi2(poses[a.factor.i], poses[a.factor.j]);
        AutomaticFactor { chi2, ..*a }
    };
    factors.iter().map(judge).collect()
}

fn ambiguous(mode: Mode) -> String {
    let question = match mode {
        Mode::Perpendicular => "the strokes are nearly parallel, so that they could turn either way",
        _ => "the strokes are nearly at a right angle, so that they could turn either way",
    };
    format!("ambiguous: {question}")
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
