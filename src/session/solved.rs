//! The map under a list of steps. After every one a copy of what it changed is kept, so that a change solves only from
//! there on; what comes out is what a start from the source map gives, byte for byte.

use super::steps::{Outcome, Told, carry_out};
use super::{Settings, State, Todo, straighten};
use crate::error::Result;
use crate::geometry::Pose2;
use crate::map::{Correction, SlamMap};
use crate::pipeline::{CorrectionReport, Corrector, Proposal, Reassociation, State as MapState};

/// Matching takes longer than solving: so many of its last results need not be found again after an undo.
const MATCHES_KEPT: usize = 24;

/// A map and what was done to it.
#[derive(Debug, Clone)]
pub struct Solved {
    corrector: Corrector,
    source: MapState,
    settings: Settings,
    steps: Vec<Step>,
    /// Worked out for a person to look at, and likely to be what comes next.
    previewed: Option<(Correction, Proposal)>,
    known: Vec<Known>,
    world_from_map: Pose2,
}

#[derive(Debug, Clone)]
struct Step {
    todo: Todo,
    after: MapState,
    outcome: Outcome,
}

/// A re-association that was done once, and all that it depends on.
#[derive(Debug, Clone)]
struct Known {
    settings: Settings,
    way: Vec<Todo>,
    step: Step,
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
        Ok(Solved {
            corrector,
            source,
            settings,
            steps: Vec::new(),
            previewed: None,
            known: Vec::new(),
            world_from_map: Pose2::IDENTITY,
        })
    }

    /// The map; poses are in its own frame, before any straightening.
    pub fn corrector(&self) -> &Corrector {
        &self.corrector
    }

    /// What the source map was.
    pub fn source(&self) -> &MapState {
        &self.source
    }

    /// The turn of the straightened world.
    pub fn world_from_map(&self) -> Pose2 {
        self.world_from_map
    }

    /// What every correction did when it was applied, in order.
    pub fn reports(&self) -> impl Iterator<Item = &CorrectionReport> {
        self.steps.iter().filter_map(|s| match &s.outcome {
            Outcome::Corrected(report) => Some(&**report),
            _ => None,
        })
    }

    /// The last re-association, if there was one; corrections may have come after it.
    pub fn matched(&self) -> Option<&Reassociation> {
        self.steps.iter().rev().find_map(|s| match &s.outcome {
            Outcome::Matched(found) => Some(&**found),
            _ => None,
        })
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

    /// Makes the map that `state` says. `progress(done, of)` is called before every step and while visits are matched; if
    /// it answers false, the work is given up and everything is as it was: false then.
    ///
    /// # Errors
    /// As [`Corrector::apply`]; everything is as it was.
    pub fn follow(&mut self, state: &State, progress: Told<'_>) -> Result<bool> {
        let before = (self.settings, self.world_from_map);
        let todos = state.todos();
        let mut kept = 0;
        if state.settings == self.settings {
            kept = self.steps.iter().zip(&todos).take_while(|(s, t)| s.todo == **t).count();
        } else {
            self.corrector.set_options(state.settings.options())?;
            self.previewed = None;
        }
        let old = self.steps.split_off(kept);
        let outcome = self.apply(state, &todos, progress);
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
    fn apply(&mut self, state: &State, todos: &[Todo], progress: Told<'_>) -> Result<bool> {
        self.settings = state.settings;
        self.put_back()?;
        let first = self.steps.len();
        for (k, todo) in todos.iter().enumerate().skip(first) {
            if !progress(100 * (k - first), 100 * (todos.len() - first)) {
                return Ok(false);
            }
            if let Some(step) = self.recall(&todos[..=k]) {
                self.corrector.restore(step.after.clone())?;
                self.previewed = None;
                self.steps.push(step);
                continue;
            }
            let previewed = self.previewed.take();
            let mut told = |share: usize| progress(100 * (k - first) + share, 100 * (todos.len() - first));
            let Some(outcome) = carry_out(&mut self.corrector, todo, previewed, &mut told)? else {
                return Ok(false);
            };
            let step = Step { todo: todo.clone(), after: self.corrector.state(), outcome };
            if matches!(step.outcome, Outcome::Matched(_)) {
                self.remember(&todos[..=k], step.clone());
            }
            self.steps.push(step);
        }
        self.world_from_map = match &state.straighten {
            Some(along) => straighten::world_from_map(&self.corrector, along)?,
            None => Pose2::IDENTITY,
        };
        Ok(true)
    }

    fn recall(&self, way: &[Todo]) -> Option<Step> {
        let known = self.known.iter().find(|k| k.settings == self.settings && k.way == way);
        known.map(|k| k.step.clone())
    }

    fn remember(&mut self, way: &[Todo], step: Step) {
        self.known.truncate(MATCHES_KEPT - 1);
        self.known.insert(0, Known { settings: self.settings, way: way.to_vec(), step });
    }

    /// Takes over what a copy of this map has matched meanwhile.
    pub(super) fn learn(&mut self, copy: Solved) {
        if let Some(found) = copy.known.into_iter().next()
            && self.recall(&found.way).is_none()
        {
            self.known.truncate(MATCHES_KEPT - 1);
            self.known.insert(0, found);
        }
    }

    /// The corrector as after the last step.
    fn put_back(&mut self) -> Result<()> {
        let last = self.steps.last().map_or(&self.source, |s| &s.after).clone();
        if last != self.corrector.state() {
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
        let MapState { poses, human_factors, automatic_factors } = state.turned(self.world_from_map);
        SlamMap { poses, human_factors, automatic_factors, ..self.corrector.map().clone() }
    }
}
