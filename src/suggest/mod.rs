//! Where a correction would help most: places ranked, each with two strokes ready to be looked at and applied.
//!
//! Like a person who looks the map through: first faults of the chain (a torn step, a slip), since nothing
//! else means anything before they are mended; then visits that were matched with each other and lie apart. The strokes
//! are drawn on walls that both visits show. Every candidate is tried on a copy of the map, and the one
//! after which most of *all* matches agree comes first: a right correction brings other places together too, a wrong match tears
//! them apart. The next is searched on the copy with the first applied, so that together they say no thing twice.

mod faults;
mod places;
mod report;

pub use report::{Kind, Suggestion};

use rayon::prelude::*;

use crate::closures;
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::{Observations, SlamMap};
use crate::pipeline::{self, Corrector, Proposal};
use crate::sights::{Chain, Pieces, Sight};
use faults::Fault;
use places::{Place, mean_misfit_m};

/// How well a match knows where two looks lie: metres, radians.
const KNOWN: (f64, f64) = (0.03, 0.01);
/// What is farther off than the chain can explain must be insisted on: standard deviations, and the weight.
const FAULT_SIGMAS: f64 = 7.0;
const INSISTING: f64 = 1e3;
/// Strokes for a fault are drawn from poses so far before and after it, metres.
const BESIDE_M: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 7.0];
/// Corrections for one fault at most.
const MOST_PER_FAULT: usize = 4;
/// Each must take so much of what is left of it.
const LEAST_MENDED: f64 = 0.15;
/// Candidates that are tried for each suggestion.
const MOST_TRIED: usize = 24;
/// A correction must lessen the mean misfit by so much of what is visible, as a share.
const LEAST_GAIN: f64 = 0.02;
/// A match alone is believed if it is no farther than this from where the map has it, metres; …
const FARTHEST_ALONE_M: f64 = 0.5;
/// … else other places must gain this share of what its own place gains.
const LEAST_OTHERS: f64 = 0.2;
/// Searches for visits, each on the map as suggested so far.
const MOST_SEARCHES: usize = 3;

/// Tunables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Suggestions at most, > 0.
    pub most: usize,
    /// What is less apart than this is no reason to draw, metres, > 0.
    pub visible_m: f64,
    /// How corrections are tried.
    pub pipeline: pipeline::Options,
}

impl Default for Options {
    fn default() -> Self {
        Options { most: 8, visible_m: 0.1, pipeline: pipeline::Options::default() }
    }
}

impl Options {
    fn validate(&self) -> Result<()> {
        if self.most == 0 {
            return Err(Error::input("most suggestions", "found 0, expected 1 or more"));
        }
        if !(self.visible_m.is_finite() && self.visible_m > 0.0) {
            let message = format!("found {}, expected a number > 0", self.visible_m);
            return Err(Error::input("visible distance", message));
        }
        Ok(())
    }
}

/// Suggestions for a map as it stands, the most helpful first; empty where nothing is visibly wrong. They are meant to be applied in
/// this order. The map is not changed. `told` hears how many were found so far, again and again; once it says false, these are
/// all that is answered.
///
/// # Errors
/// [`Error::Input`] for options out of range or a map that cannot be corrected (no points).
pub fn suggest(
    map: &SlamMap,
    options: &Options,
    told: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Vec<Suggestion>> {
    options.validate()?;
    let mut search = Search {
        corrector: Corrector::new(map.clone(), options.pipeline)?,
        observations: &map.observations,
        options,
        found: Vec::new(),
        told,
        is_given_up: false,
    };
    if search.is_over() {
        return Ok(search.found);
    }
    for fault in faults::find(map) {
        search.mend(&fault)?;
    }
    for _ in 0..MOST_SEARCHES {
        if search.is_over() || !search.visits()? {
            break;
        }
    }
    Ok(search.found)
}

/// The copy of the map, and what was suggested so far.
struct Search<'a> {
    corrector: Corrector,
    observations: &'a Observations,
    options: &'a Options,
    found: Vec<Suggestion>,
    told: &'a (dyn Fn(usize) -> bool + Sync),
    is_given_up: bool,
}

/// A candidate on trial.
struct Trial {
    sight: Sight,
    weight: f64,
    apart_m: f64,
    sigmas: f64,
    misfit_m: f64,
    proposal: Proposal,
}

impl Search<'_> {
    /// Says how far it is; true if there are enough suggestions, or nobody waits for them any more.
    fn is_over(&mut self) -> bool {
        self.is_given_up = self.is_given_up || !(self.told)(self.found.len());
        self.is_given_up || self.found.len() >= self.options.most
    }

    /// Suggests what mends a fault.
    fn mend(&mut self, fault: &Fault) -> Result<()> {
        let mut pieces = Pieces::new(self.observations);
        let inliers = fault.inliers[0];
        let around = self.around(fault);
        let across = pairs(&around).filter(|(p, q)| p.0 < fault.j && q.0 > fault.i);
        let across: Vec<Place> = across.map(|(p, q)| place(p, q, inliers)).collect();
        let mut sights: Vec<Sight> = across.iter().flat_map(|p| p.sights(&mut pieces)).collect();
        for _ in 0..MOST_PER_FAULT {
            let misfit_m = mean_misfit_m(&across, &self.corrector.map().poses);
            if self.is_over() || misfit_m < self.options.visible_m {
                break;
            }
            let trials = self.tried(&self.candidates(&sights), &across, Some(INSISTING))?;
            let Some(best) = best(trials, misfit_m * (1.0 - LEAST_MENDED)) else { break };
            sights.retain(|s| *s != best.sight);
            let text = report::of_fault(fault, self.corrector.map());
            self.take(best, Kind::Break, inliers, misfit_m, (0, 0), text);
        }
        Ok(())
    }

    /// The stations of a fault and some poses before and after it, as seen from its first pose.
    fn around(&self, fault: &Fault) -> Vec<(usize, Pose2)> {
        let map = self.corrector.map();
        let path_m = map.path_lengths_m();
        let at = |wanted_m: f64| path_m.partition_point(|&s| s < wanted_m);
        let (i, j) = (fault.i, fault.j);
        let before = BESIDE_M.iter().map(|m| (at(path_m[i] - m), i)).filter(|(p, _)| *p < i);
        let after =
            BESIDE_M.iter().map(|m| (at(path_m[j] + m), j)).filter(|(p, _)| *p > j && *p < map.poses.len());
        let i_from_j = fault.i_from_j();
        let mut around = fault.stations.clone();
        around.extend(before.map(|(p, i)| (p, map.poses[i].between(map.poses[p]))));
        around.extend(after.map(|(p, j)| (p, i_from_j.compose(map.poses[j].between(map.poses[p])))));
        around.sort_by_key(|s| s.0);
        around.dedup_by_key(|s| s.0);
        around
    }

    /// Compares all visits and suggests what brings them together; false if there was nothing to suggest.
    fn visits(&mut self) -> Result<bool> {
        let compared = closures::compare_visits(self.corrector.map(), &self.options.pipeline.joint)?;
        let places = compared.iter().filter_map(|c| c.matched.as_ref()).map(Place::of);
        let places: Vec<Place> = places.filter(|p| p.is_telling(&self.corrector.map().poses)).collect();
        let mut pieces = Pieces::new(self.observations);
        let mut sights: Vec<Sight> = places.iter().flat_map(|p| p.sights(&mut pieces)).collect();
        let before = self.found.len();
        while !self.is_over() {
            let poses = &self.corrector.map().poses;
            let misfit_m = mean_misfit_m(&places, poses);
            let candidates = self.candidates(&sights);
            let open = self.open(&places, poses);
            let mut trials = self.tried(&candidates, &places, None)?;
            trials.retain(|t| self.is_confirmed(t, &places, misfit_m));
            let least = misfit_m - LEAST_GAIN * self.options.visible_m;
            let Some(best) = best(trials, least) else { break };
            let poses = (best.sight.a.pose, best.sight.b.pose);
            let inliers = places.iter().find(|p| (p.i, p.j) == poses).map_or(0.0, |p| p.inliers);
            sights.retain(|s| *s != best.sight);
            let after = best.proposal.state.as_ref().map_or(0, |s| self.open(&places, &s.poses));
            let kind = report::kind(&best.sight, self.corrector.map());
            let text = report::of_visits(kind, &best.sight, best.apart_m, best.sigmas, self.corrector.map());
            self.take(best, kind, inliers, misfit_m, (open.saturating_sub(after), open), text);
        }
        Ok(self.found.len() > before)
    }

    /// False if nothing but its own match speaks for a correction, and that from afar: in a building that looks like itself
    /// elsewhere, such a match is as likely wrong as right.
    fn is_confirmed(&self, trial: &Trial, places: &[Place], misfit_m: f64) -> bool {
        let Some(state) = &trial.proposal.state else { return false };
        let poses = (trial.sight.a.pose, trial.sight.b.pose);
        let own = places.iter().filter(|p| (p.i, p.j) == poses);
        let own_m: f64 =
            own.map(|p| p.misfit_m(&self.corrector.map().poses) - p.misfit_m(&state.poses)).sum();
        let all_m = (misfit_m - trial.misfit_m) * places.len() as f64;
        trial.apart_m < FARTHEST_ALONE_M || all_m - own_m >= LEAST_OTHERS * own_m.max(0.0)
    }

    /// Number of places that are visibly apart.
    fn open(&self, places: &[Place], poses: &[Pose2]) -> usize {
        places.iter().filter(|p| p.misfit_m(poses) >= self.options.visible_m).count()
    }

    /// Of the sights that are visibly apart: the farthest, and some of all others.
    fn candidates(&self, sights: &[Sight]) -> Vec<Sight> {
        let map = self.corrector.map();
        let chain = Chain::new(map);
        let mut apart: Vec<(f64, usize)> = sights
            .iter()
            .enumerate()
            .filter_map(|(k, s)| Some((s.disagreement(map, &chain, KNOWN)?.0, k)))
            .filter(|(apart_m, _)| *apart_m >= self.options.visible_m)
            .collect();
        apart.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let rest = apart.split_off(apart.len().min(MOST_TRIED / 2));
        let some = rest.iter().step_by(rest.len().div_ceil(MOST_TRIED / 2).max(1));
        apart.iter().chain(some).map(|(_, k)| sights[*k]).collect()
    }

    /// Every sight drawn on the copy, as far as its strokes catch what they are drawn on.
    fn tried(&self, sights: &[Sight], places: &[Place], weight: Option<f64>) -> Result<Vec<Trial>> {
        let map = self.corrector.map();
        let chain = Chain::new(map);
        let one = |sight: &Sight| -> Result<Option<Trial>> {
            let Some((apart_m, surprise)) = sight.disagreement(map, &chain, KNOWN) else { return Ok(None) };
            let sigmas = surprise.sqrt();
            let weight = weight.unwrap_or(if sigmas > FAULT_SIGMAS { INSISTING } else { 1.0 });
            let correction = sight.correction("s".into(), weight);
            if !self.corrector.preview(&correction)?.is_understood(&correction) {
                return Ok(None);
            }
            let proposal = self.corrector.propose(&correction)?;
            let Some(state) = &proposal.state else { return Ok(None) };
            let misfit_m = mean_misfit_m(places, &state.poses);
            Ok(Some(Trial { sight: *sight, weight, apart_m, sigmas, misfit_m, proposal }))
        };
        let trials: Vec<Option<Trial>> = sights.par_iter().map(one).collect::<Result<_>>()?;
        Ok(trials.into_iter().flatten().collect())
    }

    /// Applies a trial to the copy and writes it down.
    fn take(
        &mut self,
        mut trial: Trial,
        kind: Kind,
        inliers: f64,
        misfit_m: f64,
        brings: (usize, usize),
        reason: String,
    ) {
        let mut id = format!("s{}", self.found.len() + 1);
        while self.corrector.map().human_factors.iter().any(|f| f.id == id) {
            id.push('_');
        }
        for factor in trial.proposal.state.iter_mut().flat_map(|s| s.human_factors.last_mut()) {
            factor.id.clone_from(&id);
        }
        let map = self.corrector.map();
        self.found.push(Suggestion {
            rank: self.found.len() + 1,
            kind,
            reason,
            poses: [trial.sight.a.pose, trial.sight.b.pose],
            walls: [trial.sight.a, trial.sight.b]
                .map(|look| look.ends.map(|p| map.poses[look.pose].transform_point(p)).map(|p| [p.x, p.y])),
            apart_m: trial.apart_m,
            sigmas: trial.sigmas,
            inliers,
            misfit_before_m: misfit_m,
            misfit_after_m: trial.misfit_m,
            brings_together: brings.0,
            of_apart: brings.1,
            correction: trial.sight.correction(id, trial.weight),
        });
        self.corrector.accept(trial.proposal);
    }
}

/// All pairs of stations, the earlier first.
fn pairs(stations: &[(usize, Pose2)]) -> impl Iterator<Item = (&(usize, Pose2), &(usize, Pose2))> {
    stations.iter().enumerate().flat_map(|(k, p)| stations[k + 1..].iter().map(move |q| (p, q)))
}

/// Two stations as a place.
fn place(p: &(usize, Pose2), q: &(usize, Pose2), inliers: f64) -> Place {
    Place { i: p.0, j: q.0, i_from_j: p.1.between(q.1), inliers, weak_rad: None }
}

/// The trial that leaves the least misfit, if that is no more than `most_m`; of equal ones the first.
fn best(trials: Vec<Trial>, most_m: f64) -> Option<Trial> {
    trials.into_iter().filter(|t| t.misfit_m <= most_m).min_by(|a, b| a.misfit_m.total_cmp(&b.misfit_m))
}
