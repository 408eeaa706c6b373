//! Human effort: damaged logs and chains, and a simulated person who repairs them, counted in strokes.

use std::fmt::Write;
use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::front_end::{self, Chain};
use hitl_slam::io;
use hitl_slam::map::{RawLog, Relation, SlamMap, Trajectory};
use hitl_slam::metrics;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::damage::{self, Kind};
use hitl_slam::simulate::person::{self, Person, Reference, Settings};
use hitl_slam::simulate::{self, Scenario};

use crate::page::{Claim, Result, Section, project};
use crate::runs;
use crate::stats::Sample;

/// Strokes that an undamaged log gets.
const USUAL: usize = 4;
/// Strokes that each damage may cost.
const PER_DAMAGE: usize = 2;
const SEEDS: u64 = 20;
/// "Good again": within so much of the undamaged result.
const GOOD: f64 = 1.2;

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Damage and human effort", name: "effort", ..Section::default() };
    section.body = INTRODUCTION.replace("{SEEDS}", &SEEDS.to_string());
    let aces = Aces::read()?;
    damages(&mut section, &aces)?;
    worlds(&mut section)?;
    Ok(section)
}

/// Errors of one run: without closures after 0, 1, … strokes; with them, before any and after those for the damage.
type Courses = (Vec<f64>, [f64; 2]);

/// Error after 0, 1, … strokes of a person; where the person has stopped, the last one again.
pub fn course(
    map: &SlamMap,
    reference: Reference,
    seed: u64,
    strokes: usize,
    error_m: impl Fn(&SlamMap) -> f64,
) -> Result<Vec<f64>> {
    let mut person = Person::new(map, reference, &Settings { seed, ..Settings::default() })?;
    let mut corrector = Corrector::new(map.clone(), Options::default())?;
    let mut errors_m = vec![error_m(map)];
    for _ in 0..strokes {
        if person::repair(&mut corrector, &mut person, 1)?.is_empty() {
            break;
        }
        errors_m.push(error_m(corrector.map()));
    }
    let last_m = errors_m[errors_m.len() - 1];
    errors_m.resize(strokes + 1, last_m);
    Ok(errors_m)
}

/// The same with re-association after every look: before any stroke, and after those that a damage may cost.
fn closed_course(
    map: &SlamMap,
    reference: Reference,
    seed: u64,
    error_m: impl Fn(&SlamMap) -> f64,
) -> Result<[f64; 2]> {
    let mut person = Person::new(map, reference, &Settings { seed, ..Settings::default() })?;
    let mut corrector = Corrector::new(map.clone(), Options::default())?;
    let close = |corrector: &mut Corrector| {
        corrector.reassociate(&closures::Options::default(), &|_| (), &AtomicBool::new(false))
    };
    close(&mut corrector)?;
    let before_m = error_m(corrector.map());
    for _ in 0..PER_DAMAGE {
        if person::repair(&mut corrector, &mut person, 1)?.is_empty() {
            break;
        }
        close(&mut corrector)?;
    }
    Ok([before_m, error_m(corrector.map())])
}

/// The strokes until the error is, and stays, at most `good_m`; one more than the budget where it never is.
fn effort(errors_m: &[f64], good_m: f64) -> f64 {
    errors_m.iter().rposition(|&e| e > good_m).map_or(0.0, |k| (k + 1) as f64)
}

pub fn scan_matched(log: &RawLog) -> Result<SlamMap> {
    let progress = |_| {};
    let chain = Chain::ScanMatch { progress: &progress };
    Ok(front_end::build(log, chain, &front_end::Options::for_scan_matching())?.0)
}

pub fn relation_error_m(map: &SlamMap, relations: &[Relation]) -> f64 {
    let errors = metrics::relation_errors(&map.trajectory(), relations, metrics::DEFAULT_TOLERANCE_S);
    errors.translation_mean_m.unwrap_or(f64::NAN)
}

/// The real log and the chain that its front end makes.
struct Aces {
    log: RawLog,
    relations: Vec<Relation>,
    chain: SlamMap,
}

impl Aces {
    fn read() -> Result<Aces> {
        let log = io::carmen::read(&project("data/aces.clf.bz2"))?.value;
        let relations = io::relations::read(&project("data/aces.relations"))?.value;
        let chain = scan_matched(&log)?;
        Ok(Aces { log, relations, chain })
    }
}

/// The log damaged, or the chain.
fn damages(section: &mut Section, aces: &Aces) -> Result<()> {
    let Aces { log, relations, chain } = aces;
    let error_m = |map: &SlamMap| relation_error_m(map, relations);
    let reference = Reference::Relations(relations);
    let budget = USUAL + PER_DAMAGE;
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    let both = |map: &SlamMap, seed| -> Result<Courses> {
        let open = course(map, reference, seed, budget + 4, error_m)?;
        Ok((open, closed_course(map, reference, seed, error_m)?))
    };
    let sound = runs::parallel(&seeds, |&seed| both(chain, seed))?;
    let closed_m = Sample::of(sound.iter().map(|e| e.1[0])).mean();
    let good_m = Sample::of(sound.iter().map(|e| e.0[USUAL])).mean();

    section.body += "**ACES**, scan-matched chain, no loop closure (on the right: with re-association after every stroke). Mean error over all relations in m: mean over seeds ± 95 % interval \
                     (worst). Strokes until it stays within 1.2 of the undamaged result after 4 strokes: mean (worst).\n\n\
                     | damage | before | after 2 strokes | after 4 | after 6 | strokes | closures on: before | after 2 strokes |\n|---|---|---|---|---|---|---|---|\n";
    let mut row = |name: &str, courses: &[Courses]| {
        let at = |k: usize| Sample::of(courses.iter().map(|e| e.0[k]));
        let closed = |k: usize| Sample::of(courses.iter().map(|e| e.1[k]));
        let efforts = Sample::of(courses.iter().map(|e| effort(&e.0, GOOD * good_m)));
        let _ = write!(section.body, "| {name} ");
        for k in [0, 2, 4, 6] {
            let _ = write!(section.body, "| {} ({:.3}) ", at(k).with_interval(3), at(k).largest());
        }
        let _ = write!(section.body, "| {:.1} ({:.0}) ", efforts.mean(), efforts.largest());
        for k in [0, 1] {
            let _ = write!(section.body, "| {} ({:.3}) ", closed(k).with_interval(4), closed(k).largest());
        }
        section.body.push_str("|\n");
    };
    row("none", &sound);
    let mut claims = Vec::new();
    for kind in [Kind::Kick, Kind::Slip, Kind::Drift] {
        let courses = runs::parallel(&seeds, |&seed| {
            let (map, _) = damage::map(chain, &damage::Settings { kind, count: 1, seed })?;
            both(&map, seed)
        })?;
        row(&format!("{kind}, in the chain"), &courses);
        claims.push(back_to_good(&format!("{kind} in the chain"), &courses, good_m));
    }
    for kind in Kind::ALL {
        let courses = runs::parallel(&seeds, |&seed| {
            let (log, _) = damage::log(log, &damage::Settings { kind, count: 1, seed })?;
            both(&scan_matched(&log)?, seed)
        })?;
        row(&format!("{kind}, in the log"), &courses);
        claims.push(back_to_good(&format!("{kind} in the log"), &courses, good_m));
        let closed = Sample::of(courses.iter().map(|e| e.1[1]));
        claims.push(Claim {
            what: format!("ACES, {kind} in the log, closures on, {PER_DAMAGE} strokes: error over the undamaged closed one"),
            measured: closed.mean() / closed_m,
            bound: GOOD,
            unit: "",
            decimals: 2,
            why: "set before it was built",
        });
    }
    section.claims.extend(claims);
    section.body.push('\n');
    Ok(())
}

/// The bound, on the mean over seeds: 4 strokes as without damage, and 2 for the damage.
fn back_to_good(what: &str, courses: &[Courses], good_m: f64) -> Claim {
    let after = Sample::of(courses.iter().map(|e| e.0[USUAL + PER_DAMAGE]));
    Claim {
        what: format!(
            "ACES, {what}, {USUAL} + {PER_DAMAGE} strokes: error over the undamaged one after {USUAL}"
        ),
        measured: after.mean() / good_m,
        bound: GOOD,
        unit: "",
        decimals: 2,
        why: "set before it was built",
    }
}

/// A world of its own per seed, with truth.
type World = Box<dyn Fn(u64) -> Result<simulate::Simulation> + Sync>;

/// Simulated worlds: error against truth, stroke by stroke.
fn worlds(section: &mut Section) -> Result<()> {
    const STROKES: usize = 8;
    const GOOD_M: f64 = 0.1;
    let of = |scenario: Scenario| -> World { Box::new(move |seed| runs::simulated(scenario, seed, 0.0)) };
    let plan = |name: &str| -> Result<Option<World>> {
        let path = project(&format!("../shared/data/amrl_maps/{name}.vectormap.txt"));
        if !path.exists() {
            return Ok(None);
        }
        let walls = io::floor_plan::read(&path)?.value;
        Ok(Some(Box::new(move |seed| {
            let settings = simulate::Settings { seed, ..simulate::Settings::default() };
            Ok(simulate::run_through(&walls, 300.0, &settings)?)
        })))
    };
    section.body += "**Simulated worlds**, the truth as the reference: ATE in m, and strokes until it stays below 0.1 m.\n\n\
                     | world | damage | before | after 1 stroke | after 2 | after 4 | after 8 | strokes |\n|---|---|---|---|---|---|---|---|\n";
    let damages = [None, Some(Kind::Kick), Some(Kind::Slip), Some(Kind::Drift)];
    let worlds = [
        ("loop", Some(of(Scenario::Loop)), &damages[..], SEEDS),
        ("campus", Some(of(Scenario::Campus)), &damages[..1], 6),
        ("GHC 7 (floor plan)", plan("GHC7")?, &damages[..2], SEEDS),
        ("NSH 3 (floor plan)", plan("NSH3")?, &damages[..1], SEEDS),
    ];
    for (name, world, kinds, count) in worlds {
        let Some(world) = world else {
            let _ = writeln!(section.body, "| {name} | skipped: ../shared is absent | | | | | | |");
            continue;
        };
        let seeds: Vec<u64> = (1..=count).collect();
        for kind in kinds {
            let courses = runs::parallel(&seeds, |&seed| {
                let s = world(seed)?;
                let map = match *kind {
                    Some(kind) => damage::map(&s.map, &damage::Settings { kind, count: 1, seed })?.0,
                    None => s.map.clone(),
                };
                let truth = Trajectory { poses: s.truth.clone(), ..s.map.trajectory() };
                course(&map, Reference::Truth(&truth), seed, STROKES, |m| runs::ate_m(&m.poses, &s.truth))
            })?;
            let _ = write!(section.body, "| {name} | {} ", kind.map_or("none", Kind::name));
            for k in [0, 1, 2, 4, 8] {
                let sample = Sample::of(courses.iter().map(|e| e[k]));
                let _ = write!(section.body, "| {} ({:.3}) ", sample.with_interval(3), sample.largest());
            }
            let efforts = Sample::of(courses.iter().map(|e| effort(e, GOOD_M)));
            let _ = writeln!(section.body, "| {:.1} ({:.0}) |", efforts.mean(), efforts.largest());
        }
    }
    Ok(())
}

const INTRODUCTION: &str = "\
What fails in practice, done to good data (`hitl simulate damage`, seeds 1–{SEEDS}), and a simulated person (`hitl simulate person`, \
3 cm of drawing noise, always the right wall) who repairs it, looking at the map after every stroke. The person knows the reference that \
the error is measured against: this counts what a person who knows the building has to do, not how well someone guesses. **In the \
log**: odometry or scans are damaged and the scan matcher starts anew; it heals most of it by itself. **In the chain**: the relative \
factors are damaged behind its back, which is what a failed front end leaves. kick: 30° in one step; slip: 34° over 20 m; drift: 0.2–0.5° a \
metre all the way; blind: no return for 60 s; drop: 60 s missing.\n\n";
