//! The map under a list of corrections. After every correction a copy of what it changed is kept, so that a change
//! solves only from there on; what comes out is what a start from the source map gives, byte for byte.

use crate::error::Result;
use crate::geometry::Pose2;
use crate::map::{Correction, SlamMap};
use crate::pipeline::{CorrectionReport, Corrector, Proposal, State as MapState};

use super::{Settings, State, straighten};

/// A map and what was done to it.
#[derive(Debug, Clone)]
pub struct Solved {
    corrector: Corrector,
    source: MapState,
    settings: Settings,
    steps: Vec<Step>,
    /// Worked out for a person to look at, and likely to be what comes next.
    previewed: Option<(Correction, Proposal)>,
    world_from_map: Pose2,
}

#[derive(Debug, Clone)]
struct Step {
    correction: Correction,
    after: MapState,
    report: CorrectionReport,
}

impl Solved {
    /// The source map with nothing done to it.
    ///
    /// # Errors
    /// [`crate::error::Error::Input`] for a map without points.
    pub fn new(map: SlamMap) -> Result<Solved> {
        let settings = Settings::default();
        let corrector = Corrector::new(map, settings.options())?;
        let source = corrector.state();
        let world_from_map = Pose2::IDENTITY;
        Ok(Solved { corrector, source, settings, steps: Vec::new(), previewed: None, world_from_map })
    }

    /// The map; poses are in its own frame, before any straightening.
    pub fn corrector(&self) -> &Corrector {
        &self.corrector
    }

    /// Poses and human factors of the source map.
    pub fn source(&self) -> &MapState {
        &self.source
    }

    /// The turn of the straightened world.
    pub fn world_from_map(&self) -> Pose2 {
        self.world_from_map
    }

    /// What every correction did when it was applied, in order.
    pub fn reports(&self) -> impl Iterator<Item = &CorrectionReport> {
        self.steps.iter().map(|s| &s.report)
    }

    /// What a correction would do after all that are there.
    ///
    /// # Errors
    /// As [`Corrector::propose`].
    pub fn preview(&mut self, correction: &Correction) -> Result<&Proposal> {
        let proposal = match self.previewed.take() {
            Some((known, proposal)) if known == *correction => proposal,
            _ => self.corrector.propose(correction)?,
        };
        Ok(&self.previewed.insert((correction.clone(), proposal)).1)
    }

    /// Makes the map that `state` says. `progress(done, of)` is called before every correction; if it answers false,
    /// the work is given up and everything is as it was: false then.
    ///
    /// # Errors
    /// As [`Corrector::apply`]; everything is as it was.
    pub fn follow(&mut self, state: &State, progress: &mut dyn FnMut(usize, usize) -> bool) -> Result<bool> {
        let before = (self.settings, self.world_from_map);
        let mut kept = 0;
        if state.settings == self.settings {
            let same = self.steps.iter().zip(&state.corrections).take_while(|(s, c)| s.correction == **c);
            kept = same.count();
        } else {
            self.corrector.set_options(state.settings.options())?;
            self.previewed = None;
        }
        let old = self.steps.split_off(kept);
        let outcome = self.apply(state, progress);
        if !matches!(outcome, Ok(true)) {
            self.steps.truncate(kept);
            self.steps.extend(old);
            (self.settings, self.world_from_map) = before;
            self.corrector.set_options(self.settings.options())?;
            self.put_back()?;
        }
        outcome
    }

    /// Applies what is missing behind the steps that are there.
    fn apply(&mut self, state: &State, progress: &mut dyn FnMut(usize, usize) -> bool) -> Result<bool> {
        self.settings = state.settings;
        self.put_back()?;
        let first = self.steps.len();
        for (k, correction) in state.corrections[first..].iter().enumerate() {
            if !progress(k, state.corrections.len() - first) {
                return Ok(false);
            }
            let proposal = match self.previewed.take() {
                Some((known, proposal)) if known == *correction => proposal,
                _ => self.corrector.propose(correction)?,
            };
            let report = self.corrector.accept(proposal);
            let step = Step { correction: correction.clone(), after: self.corrector.state(), report };
            self.steps.push(step);
        }
        self.world_from_map = match &state.straighten {
            Some(along) => straighten::world_from_map(&self.corrector, along)?,
            None => Pose2::IDENTITY,
        };
        Ok(true)
    }

    /// The corrector as after the last step.
    fn put_back(&mut self) -> Result<()> {
        let last = self.steps.last().map_or(&self.source, |s| &s.after).clone();
        if last.poses != self.corrector.map().poses
            || last.human_factors != self.corrector.map().human_factors
        {
            self.previewed = None;
        }
        self.corrector.restore(last)
    }

    /// The finished map: corrected, and turned if it is to be straight.
    pub fn map(&self) -> SlamMap {
        self.with(self.corrector.state())
    }

    /// The source map, turned as the finished one is.
    pub fn source_map(&self) -> SlamMap {
        self.with(self.source.clone())
    }

    fn with(&self, state: MapState) -> SlamMap {
        let MapState { poses, human_factors } = state.turned(self.world_from_map);
        SlamMap { poses, human_factors, ..self.corrector.map().clone() }
    }
}
