//! One of five strokes on the wrong wall: whether it is named, what is named falsely, and what the map is like in the end.

use std::fmt::Write;
use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::io;
use hitl_slam::map::{Correction, Mode, SlamMap, Trajectory};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::Scenario;
use hitl_slam::simulate::person::{self, Drawn, Person, Reference, Settings};

use crate::effort::{relation_error_m, scan_matched};
use crate::page::{Claim, Result, Section, project};
use crate::runs;
use crate::stats::Sample;

const STROKES: u64 = 5;

/// One run.
struct Run {
    /// Mode of the wrong stroke; `None`: no wall within sight could be taken for the right one.
    wrong: Option<Mode>,
    is_named: bool,
    falsely: usize,
    /// With it, without it (someone knows), as judged; then the last two with re-association.
    errors_m: [f64; 5],
}

pub fn section() -> Result<Section> {
    let mut section =
        Section { title: "A stroke on the wrong wall", name: "wrong-strokes", ..Section::default() };
    section.body = INTRODUCTION.into();
    for (name, log, relations, seeds) in [
        ("ACES", "data/aces.clf.bz2", "data/aces.relations", 20),
        ("Intel", "../shared/data/radish_raw/intel.clf.bz2", "../shared/data/radish_raw/intel.relations", 10),
    ] {
        let [log, relations] = [log, relations].map(project);
        if !log.exists() {
            let _ = writeln!(section.body, "| {name} | skipped: ../shared is absent | | | | | | | |");
            continue;
        }
        let chain = scan_matched(&io::carmen::read(&log)?.value)?;
        let relations = io::relations::read(&relations)?.value;
        let error_m = |map: &SlamMap| relation_error_m(map, &relations);
        let seeds: Vec<u64> = (1..=seeds).collect();
        let runs =
            runs::parallel(&seeds, |&seed| run(&chain, Reference::Relations(&relations), seed, error_m))?;
        row(&mut section, name, &runs);
        claims(&mut section, name, &runs);
    }
    for (scenario, seeds) in [
        (Scenario::Loop, 10),
        (Scenario::LostPoses, 10),
        (Scenario::OfficeBent, 10),
        (Scenario::OfficeKick, 10),
        (Scenario::Campus, 4),
    ] {
        let seeds: Vec<u64> = (1..=seeds).collect();
        let runs = runs::parallel(&seeds, |&seed| {
            let s = runs::simulated(scenario, seed, 0.0)?;
            let truth = Trajectory { poses: s.truth.clone(), ..s.map.trajectory() };
            run(&s.map, Reference::Truth(&truth), seed, |m| runs::ate_m(&m.poses, &s.truth))
        })?;
        row(&mut section, scenario.name(), &runs);
    }
    Ok(section)
}

fn run(map: &SlamMap, reference: Reference, seed: u64, error_m: impl Fn(&SlamMap) -> f64) -> Result<Run> {
    let mut person = Person::new(map, reference, &Settings { seed, ..Settings::default() })?;
    let mut corrector = Corrector::new(map.clone(), Options::default())?;
    let mut drawn: Vec<Drawn> = Vec::new();
    for stroke in 0..STROKES {
        let is_due = stroke >= seed % STROKES && !drawn.iter().any(|d| d.is_wrong);
        person.set_wrong(if is_due { 1.0 } else { 0.0 })?;
        drawn.extend(person::repair(&mut corrector, &mut person, 1)?.into_iter().map(|d| d.0));
    }
    let all: Vec<Correction> = drawn.iter().map(|d| d.correction.clone()).collect();
    let right: Vec<Correction> = drawn.iter().filter(|d| !d.is_wrong).map(|d| d.correction.clone()).collect();
    let (without, _) = runs::corrected(map, &right, Options::default())?;
    let mut judge = Corrector::new(map.clone(), Options::default())?;
    let agreement = judge.apply_agreeing(&all, false, &|_| ())?;
    let named = agreement.set_aside.iter().map(|(k, _)| drawn[*k].is_wrong);
    let (is_named, falsely) = (named.clone().any(|wrong| wrong), named.filter(|wrong| !wrong).count());
    let closed_m = |map: &SlamMap| -> Result<f64> {
        let mut corrector = Corrector::new(map.clone(), Options::default())?;
        corrector.reassociate(&closures::Options::default(), &|_| (), &AtomicBool::new(false))?;
        Ok(error_m(corrector.map()))
    };
    let errors_m = [
        error_m(corrector.map()),
        error_m(&without),
        error_m(judge.map()),
        closed_m(&without)?,
        closed_m(judge.map())?,
    ];
    let wrong = drawn.iter().find(|d| d.is_wrong).map(|d| d.correction.mode);
    Ok(Run { wrong, is_named, falsely, errors_m })
}

fn row(section: &mut Section, name: &str, runs: &[Run]) {
    let of = |mode: Mode| {
        let all = runs.iter().filter(|r| r.wrong == Some(mode));
        format!("{} of {}", all.clone().filter(|r| r.is_named).count(), all.count())
    };
    let falsely: usize = runs.iter().map(|r| r.falsely).sum();
    let _ = write!(
        section.body,
        "| {name} | {} | {} | {} | {falsely} ",
        runs.len(),
        of(Mode::Colocation),
        of(Mode::Collinear)
    );
    for k in 0..5 {
        let errors = Sample::of(runs.iter().map(|r| r.errors_m[k]));
        let _ = write!(section.body, "| {:.3} ({:.3}) ", errors.mean(), errors.largest());
    }
    section.body.push_str("|\n");
}

fn claims(section: &mut Section, name: &str, runs: &[Run]) {
    let wrong: Vec<&Run> = runs.iter().filter(|r| r.wrong.is_some()).collect();
    let missed = wrong.iter().filter(|r| !r.is_named).count() as f64 / wrong.len().max(1) as f64;
    let mean = |k: usize| Sample::of(runs.iter().map(|r| r.errors_m[k])).mean();
    let mut claim = |what: &str, measured: f64, bound: f64| {
        let what = format!("{name}, one of {STROKES} strokes on the wrong wall: {what}");
        section.claims.push(Claim {
            what,
            measured,
            bound,
            unit: "",
            decimals: 2,
            why: "set before it was built",
        });
    };
    claim("share of runs in which it is not named", missed, 0.1);
    claim("error as judged over that without it", mean(2) / mean(1), 1.5);
    claim("the same with re-association", mean(4) / mean(3), 1.5);
}

const INTRODUCTION: &str = "\
The simulated person draws five strokes, one of them on a parallel wall within sight (where there is one). Named and set aside by \
`hitl correct`, of those that were wrong, by the mode of the wrong stroke; right strokes set aside in all runs. Mean error over seeds in m \
(worst; relations, for simulated worlds ATE): with the wrong stroke; without it, for someone who knows; as `hitl correct` judges; the last two \
with re-association.\n\n\
| map | runs | named: colocation | collinear | falsely | with it | without | as judged | without, closed | as judged, closed |\n\
|---|---|---|---|---|---|---|---|---|---|\n";
