//! What the events leave: a list of states and a place in it. Undo and redo move the place, everything else cuts the
//! list off there and adds a state.

use std::collections::HashSet;

use super::Event;
use crate::joint::{Backend, Formulation};
use crate::map::{Correction, Stroke};
use crate::pipeline::Options;

/// What can be chosen in the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Who solves.
    pub solver: Backend,
    /// Which objective.
    pub formulation: Formulation,
    /// σ: a person's drawing accuracy, metres.
    pub drawing_sigma_m: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let Options { interpret, joint, .. } = Options::default();
        Settings {
            solver: joint.backend,
            formulation: joint.formulation,
            drawing_sigma_m: interpret.drawing_sigma_m,
        }
    }
}

impl Settings {
    /// The pipeline's options; what cannot be chosen stays at its default.
    pub fn options(&self) -> Options {
        let mut options = Options::default();
        options.joint.backend = self.solver;
        options.joint.formulation = self.formulation;
        options.interpret.drawing_sigma_m = self.drawing_sigma_m;
        options
    }
}

/// All that decides what the map is, besides the source map.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// In the order in which they are applied.
    pub corrections: Vec<Correction>,
    /// What is done between them about automatic factors, in order.
    pub closings: Vec<Closing>,
    /// Pairs of poses that the person said are no match, in the order of saying.
    pub refused: Vec<(usize, usize)>,
    /// The wall that is to lie along an axis.
    pub straighten: Option<Stroke>,
    /// How to solve.
    pub settings: Settings,
}

/// A change of the automatic factors, and its place among the corrections.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Closing {
    /// After so many corrections.
    pub after: usize,
    /// What.
    pub what: Close,
}

/// A change of the automatic factors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Close {
    /// All are found anew, without these pairs.
    Match(Vec<(usize, usize)>),
    /// Those between the two visits of these poses go.
    Refuse(usize, usize),
}

/// One step on the way from the source map to the one on screen.
#[derive(Debug, Clone, PartialEq)]
pub enum Todo {
    /// A correction.
    Correct(Box<Correction>),
    /// A change of the automatic factors.
    Close(Close),
}

impl State {
    /// Every step in order.
    pub fn todos(&self) -> Vec<Todo> {
        let mut todos = Vec::with_capacity(self.corrections.len() + self.closings.len());
        let mut closings = self.closings.iter().peekable();
        for done in 0..=self.corrections.len() {
            while let Some(closing) = closings.next_if(|c| c.after <= done) {
                todos.push(Todo::Close(closing.what.clone()));
            }
            todos.extend(self.corrections.get(done).map(|c| Todo::Correct(Box::new(c.clone()))));
        }
        todos
    }

    /// True if visits were matched since the last change of the corrections.
    pub fn is_matched(&self) -> bool {
        let now = |c: &Closing| c.after == self.corrections.len() && matches!(c.what, Close::Match(_));
        self.closings.iter().any(now)
    }

    /// What was matched after more than `after` corrections does not hold any more, since an earlier one has changed: it
    /// may have caused any of it. What was refused stays refused.
    fn forget_matches(&mut self, after: usize) {
        self.closings.retain(|c| c.after <= after || matches!(c.what, Close::Refuse(..)));
        self.closings.iter_mut().for_each(|c| c.after = c.after.min(after));
    }

    fn refuse(&mut self, pair: (usize, usize)) {
        self.refused.push(pair);
        self.closings.push(Closing { after: self.corrections.len(), what: Close::Refuse(pair.0, pair.1) });
    }

    fn allow(&mut self, pair: (usize, usize)) {
        self.refused.retain(|&r| r != pair);
        self.closings.retain(|c| c.what != Close::Refuse(pair.0, pair.1));
    }

    fn rematch(&mut self) {
        let after = self.corrections.len();
        self.closings.retain(|c| c.after < after || matches!(c.what, Close::Refuse(..)));
        self.closings.push(Closing { after, what: Close::Match(self.refused.clone()) });
    }
}

/// Every state that can be gone back to or forward to. Holds at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    states: Vec<(State, String)>,
    now: usize,
    used_ids: HashSet<String>,
}

/// What an event would do to a history.
#[derive(Debug, Clone, PartialEq)]
pub enum Plan {
    /// Go to a state that there is.
    Move(usize),
    /// Add a state, with what led to it in words.
    Step(Box<State>, String),
}

impl Default for History {
    fn default() -> Self {
        History { states: vec![(State::default(), String::new())], now: 0, used_ids: HashSet::new() }
    }
}

impl History {
    /// The state as it is.
    pub fn state(&self) -> &State {
        &self.states[self.now].0
    }

    /// What undo would take back, in words; `None`: nothing is left.
    pub fn undo(&self) -> Option<&str> {
        (self.now > 0).then(|| self.states[self.now].1.as_str())
    }

    /// What redo would do again, in words.
    pub fn redo(&self) -> Option<&str> {
        self.states.get(self.now + 1).map(|s| s.1.as_str())
    }

    /// A name that no correction of this session ever had.
    pub fn free_id(&self) -> String {
        (1..).map(|k| format!("c{k}")).find(|id| !self.used_ids.contains(id)).unwrap_or_default()
    }

    /// Takes an event in.
    ///
    /// # Errors
    /// Why it cannot be: what was found and what was expected. Nothing has changed then.
    pub fn take(&mut self, event: &Event) -> std::result::Result<(), String> {
        let plan = self.plan(event)?;
        self.commit(plan);
        Ok(())
    }

    /// What an event would leave.
    ///
    /// # Errors
    /// As [`History::take`].
    pub fn plan(&self, event: &Event) -> std::result::Result<Plan, String> {
        let mut next = self.state().clone();
        let known = |state: &State, id: &str| {
            let place = state.corrections.iter().position(|c| c.id == id);
            place.ok_or_else(|| format!("id: found \"{id}\", expected a correction that there is"))
        };
        let what = match event {
            Event::Undo if self.now > 0 => return Ok(Plan::Move(self.now - 1)),
            Event::Redo if self.now + 1 < self.states.len() => return Ok(Plan::Move(self.now + 1)),
            Event::Undo => return Err("undo: found nothing to undo".into()),
            Event::Redo => return Err("redo: found nothing to redo".into()),
            Event::Correct(correction, _) => {
                if self.used_ids.contains(&correction.id) {
                    return Err(format!("id: found \"{}\" a second time, expected a new one", correction.id));
                }
                next.corrections.push(correction.clone());
                format!("{} {}", correction.mode.name(), correction.id)
            }
            Event::Enable(id, enabled) => {
                let k = known(&next, id)?;
                next.corrections[k].enabled = *enabled;
                next.forget_matches(k);
                format!("switching {id} {}", if *enabled { "on" } else { "off" })
            }
            Event::Reweight(id, weight) => {
                let k = known(&next, id)?;
                next.corrections[k].weight = *weight;
                next.forget_matches(k);
                format!("weight of {id}")
            }
            Event::Delete(id) => {
                let k = known(&next, id)?;
                next.corrections.remove(k);
                next.forget_matches(k);
                format!("deleting {id}")
            }
            Event::Match(_) => {
                next.rematch();
                "matching visits".into()
            }
            Event::Refuse(i, j) => {
                if next.refused.contains(&(*i, *j)) {
                    return Err(format!("name: found {i}-{j}, which is refused already"));
                }
                next.refuse((*i, *j));
                format!("refusing {i}-{j}")
            }
            Event::Allow(i, j) => {
                if !next.refused.contains(&(*i, *j)) {
                    return Err(format!("name: found {i}-{j}, expected a pair that was refused"));
                }
                next.allow((*i, *j));
                format!("allowing {i}-{j}")
            }
            Event::Straighten(along) => {
                next.straighten = *along;
                (if along.is_some() { "straightening" } else { "turning back" }).into()
            }
            Event::Settings(settings) => {
                next.settings = *settings;
                next.forget_matches(0);
                next.closings.retain(|c| matches!(c.what, Close::Refuse(..)));
                "settings".into()
            }
        };
        Ok(Plan::Step(Box::new(next), what))
    }

    /// The state that a plan of this history leads to.
    pub fn planned<'a>(&'a self, plan: &'a Plan) -> &'a State {
        match plan {
            Plan::Move(place) => &self.states[*place].0,
            Plan::Step(state, _) => state,
        }
    }

    /// Carries a plan of this history out.
    pub fn commit(&mut self, plan: Plan) {
        match plan {
            Plan::Move(place) => self.now = place,
            Plan::Step(state, what) => {
                self.used_ids.extend(state.corrections.iter().map(|c| c.id.clone()));
                self.states.truncate(self.now + 1);
                self.states.push((*state, what));
                self.now += 1;
            }
        }
    }
}
