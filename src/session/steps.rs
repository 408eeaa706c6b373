//! One step of a session on a map, and all of them from the start.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::{Close, State, Todo};
use crate::closures::{self, Progress};
use crate::error::{Error, Result};
use crate::map::Correction;
use crate::pipeline::{CorrectionReport, Corrector, Proposal, Reassociation};

/// Called with (hundredths done, of how many: a hundred a step); false gives the work up.
pub type Told<'a> = &'a mut (dyn FnMut(usize, usize) -> bool + Send);

/// What a step did.
#[derive(Debug, Clone)]
pub(super) enum Outcome {
    Corrected(Box<CorrectionReport>),
    Matched(Box<Reassociation>),
    Refused,
}

/// Does one step. `previewed`: worked out before on the map as it stands. `None`: given up, the map is as it was.
pub(super) fn carry_out(
    corrector: &mut Corrector,
    todo: &Todo,
    previewed: Option<(Correction, Proposal)>,
    told: &mut (dyn FnMut(usize) -> bool + Send),
) -> Result<Option<Outcome>> {
    Ok(Some(match todo {
        Todo::Correct(correction) => {
            let proposal = match previewed {
                Some((known, proposal)) if known == **correction => proposal,
                _ => corrector.propose(correction)?,
            };
            Outcome::Corrected(Box::new(corrector.accept(proposal)))
        }
        Todo::Close(Close::Refuse(i, j)) => {
            corrector.refuse((*i, *j))?;
            Outcome::Refused
        }
        Todo::Close(Close::Match(refused)) => {
            let options = closures::Options { refused: refused.clone(), ..closures::Options::default() };
            let cancelled = AtomicBool::new(false);
            let told = Mutex::new(told);
            let progress = |p: Progress| {
                let share = 100 * (p.round * p.pairs + p.done) / (p.rounds * p.pairs).max(1);
                let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
                if !told(share.min(99)) {
                    cancelled.store(true, Ordering::Relaxed);
                }
            };
            match corrector.reassociate(&options, &progress, &cancelled)? {
                Some(found) => Outcome::Matched(Box::new(found)),
                None => return Ok(None),
            }
        }
    }))
}

/// Takes every step of a state, on a corrector with options of its own; straightening is left to the caller. The reports of
/// the corrections, and the last re-association.
///
/// # Errors
/// As [`Corrector::apply`] and [`Corrector::reassociate`].
pub fn apply(
    corrector: &mut Corrector,
    state: &State,
    progress: Told<'_>,
) -> Result<(Vec<CorrectionReport>, Option<Reassociation>)> {
    let todos = state.todos();
    let (mut reports, mut matched) = (Vec::with_capacity(state.corrections.len()), None);
    for (k, todo) in todos.iter().enumerate() {
        let mut told = |share: usize| progress(100 * k + share, 100 * todos.len());
        match carry_out(corrector, todo, None, &mut told)? {
            Some(Outcome::Corrected(report)) => reports.push(*report),
            Some(Outcome::Matched(found)) => matched = Some(*found),
            Some(Outcome::Refused) => {}
            None => {
                return Err(Error::input("session", "found that it was given up, expected to be finished"));
            }
        }
    }
    Ok((reports, matched))
}
