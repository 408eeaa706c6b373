//! `hitl suggest`, believed blindly: what the first suggestions do to real and simulated maps, strokes as drawn by the tool.

use std::fmt::Write;

use hitl_slam::io;
use hitl_slam::map::SlamMap;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::Scenario;
use hitl_slam::simulate::damage::{self, Kind};
use hitl_slam::suggest::{self, Kind as Why, Suggestion};

use crate::effort::{relation_error_m, scan_matched};
use crate::page::{Claim, Result, Section, project};
use crate::runs;
use crate::stats::Sample;

/// Errors after so many suggestions.
const COUNTS: [usize; 5] = [0, 1, 2, 4, 8];
/// Of a chain with one step torn by 30°.
const KICKS: u64 = 20;

/// Errors of one map after so many suggestions, how many there were, and whether the first names the torn step.
struct Course {
    errors_m: [f64; 5],
    found: usize,
    is_named: bool,
}

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Suggestions", name: "suggest", ..Section::default() };
    section.body = INTRODUCTION.into();
    for (name, log, relations) in runs::REAL_LOGS {
        let [log, relations] = [log, relations].map(project);
        if !log.exists() {
            let _ = writeln!(section.body, "| {name} | skipped: ../shared is absent | | | | | | | |");
            continue;
        }
        let (log, relations) = (io::carmen::read(&log)?.value, io::relations::read(&relations)?.value);
        let error_m = |map: &SlamMap| relation_error_m(map, &relations);
        let chain = scan_matched(&log)?;
        let course = course(&chain, error_m, None)?;
        let share = course.errors_m[3] / course.errors_m[0];
        row(&mut section, &format!("{name}, scan-matched chain"), &[course], false);
        section.claims.push(claim(
            format!("{name}, 4 suggestions applied blindly, no closures: share of the error that is left"),
            share,
            0.5,
        ));
        if name == "ACES" {
            let seeds: Vec<u64> = (1..=KICKS).collect();
            let courses = runs::parallel(&seeds, |&seed| kicked(&chain, seed, error_m))?;
            row(&mut section, "ACES, kick in the chain", &courses, true);
            named(&mut section, "ACES", &courses);
        }
    }
    for (scenario, seeds) in
        [(Scenario::Loop, 10), (Scenario::OfficeBent, 10), (Scenario::OfficeKick, 10), (Scenario::Campus, 4)]
    {
        let seeds: Vec<u64> = (1..=seeds).collect();
        let is_torn = scenario == Scenario::OfficeKick;
        let courses = runs::parallel(&seeds, |&seed| {
            let s = runs::simulated(scenario, seed, 0.0)?;
            let torn = is_torn.then_some((330, 331));
            course(&s.map, |m| runs::ate_m(&m.poses, &s.truth), torn)
        })?;
        row(&mut section, scenario.name(), &courses, is_torn);
        if is_torn {
            named(&mut section, scenario.name(), &courses);
        }
        let shares = Sample::of(courses.iter().map(|c| c.errors_m[3] / c.errors_m[0]));
        let what =
            format!("{}, 4 suggestions applied blindly: mean share of the ATE that is left", scenario.name());
        section.claims.push(claim(what, shares.mean(), 0.5));
    }
    Ok(section)
}

fn kicked(chain: &SlamMap, seed: u64, error_m: impl Fn(&SlamMap) -> f64) -> Result<Course> {
    let settings = damage::Settings { kind: Kind::Kick, count: 1, seed };
    let (map, done) = damage::map(chain, &settings)?;
    course(&map, error_m, Some((done[0].first, done[0].last)))
}

fn course(map: &SlamMap, error_m: impl Fn(&SlamMap) -> f64, torn: Option<(usize, usize)>) -> Result<Course> {
    let found = suggest::suggest(map, &suggest::Options::default(), &|_| true)?;
    let mut corrector = Corrector::new(map.clone(), Options::default())?;
    let mut all_m = vec![error_m(map)];
    for suggestion in &found {
        corrector.apply(&suggestion.correction)?;
        all_m.push(error_m(corrector.map()));
    }
    let errors_m = COUNTS.map(|n| all_m[n.min(found.len())]);
    let names = |(i, j): (usize, usize)| {
        let between = format!("between poses {i} and {j}");
        found.first().is_some_and(|s: &Suggestion| s.kind == Why::Break && s.reason.contains(&between))
    };
    Ok(Course { errors_m, found: found.len(), is_named: torn.is_some_and(names) })
}

fn row(section: &mut Section, name: &str, courses: &[Course], is_torn: bool) {
    let found = Sample::of(courses.iter().map(|c| c.found as f64));
    let _ = write!(section.body, "| {name} | {} | {:.1} ", courses.len(), found.mean());
    for k in 0..COUNTS.len() {
        let errors = Sample::of(courses.iter().map(|c| c.errors_m[k]));
        let cell = match courses {
            [_] => format!("{:.4}", errors.mean()),
            _ => format!("{:.3} ({:.3})", errors.mean(), errors.largest()),
        };
        let _ = write!(section.body, "| {cell} ");
    }
    let named = courses.iter().filter(|c| c.is_named).count();
    let named = if is_torn { format!("{named} of {}", courses.len()) } else { "–".into() };
    let _ = writeln!(section.body, "| {named} |");
}

fn named(section: &mut Section, name: &str, courses: &[Course]) {
    let missed = courses.iter().filter(|c| !c.is_named).count() as f64 / courses.len() as f64;
    section.claims.push(claim(
        format!("{name}, one step torn: share of runs whose first suggestion is not that very step"),
        missed,
        0.1,
    ));
}

fn claim(what: String, measured: f64, bound: f64) -> Claim {
    Claim { what, measured, bound, unit: "", decimals: 2, why: "suggestions must help, unseen" }
}

const INTRODUCTION: &str = "\
`hitl suggest MAP` knows no truth: it matches scans with each other. Here its suggestions are applied one after the other as they are, without \
anybody's look and without re-association. A person who drops wrong ones can only do better. Mean error over all relations in m \
(simulated worlds: ATE), mean over seeds (worst); where fewer were suggested, the last one again. Last column: the first suggestion names \
the very step that was torn.\n\n\
| map | runs | suggestions | before | after 1 | after 2 | after 4 | after 8 | torn step named |\n|---|---|---|---|---|---|---|---|---|\n";
