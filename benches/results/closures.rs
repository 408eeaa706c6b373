//! Re-association: raw logs to closed maps without a stroke, one setting for all; and what it does for strokes.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::geometry::Vec2;
use hitl_slam::io;
use hitl_slam::map::{SlamMap, Trajectory};
use hitl_slam::metrics;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::Scenario;

use crate::child::{self, Scratch};
use crate::page::{Claim, Result, Section, project};
use crate::runs;
use crate::stats::Sample;

/// Name, log, relations, and the bounds for all relations: metres, degrees.
const RELATIONS: [(&str, &str, &str, f64, f64); 2] = [
    (
        "Intel",
        "../shared/data/radish_raw/intel.clf.bz2",
        "../shared/data/radish_raw/intel.relations",
        0.0130,
        0.22,
    ),
    ("ACES", "data/aces.clf.bz2", "data/aces.relations", 0.0340, 0.31),
];
/// Logs without relations: a reference trajectory, or none.
const OTHERS: [(&str, &str, Option<&str>); 3] = [
    (
        "CSAIL",
        "../shared/data/radish_raw/mit-csail.clf.bz2",
        Some("../shared/data/radish_ref/mit-csail.ref.csv"),
    ),
    ("hospital (fr-clinic)", "../shared/data/radish_raw/fr-clinic_robotlaser.clf.bz2", None),
    ("car on a campus (ual)", "../shared/data/ual/ual_2014_05_23.clf.bz2", None),
];
const SEEDS: u64 = 10;
const WORLDS: [Scenario; 5] =
    [Scenario::Loop, Scenario::Campus, Scenario::LostPoses, Scenario::OfficeBent, Scenario::OfficeKick];

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Re-association", name: "closures", ..Section::default() };
    section.body = "`hitl import LOG --front-end scan-match --close-loops`: from the raw log to the closed map, **no stroke**, the defaults. \
                    All relations; ATE against the reference after alignment.\n\n\
                    | log | scans, poses | automatic factors (disagree) | near passes | error | over 120 s | wall clock, s | memory, MB |\n\
                    |---|---|---|---|---|---|---|---|\n"
        .into();
    let scratch = Scratch::new()?;
    for (name, log, relations, bound_m, bound_deg) in RELATIONS {
        let Some(closed) = closed(&scratch, name, log, &mut section)? else { continue };
        let relations = io::relations::read(&project(relations))?.value;
        let errors =
            metrics::relation_errors(&closed.map.trajectory(), &relations, metrics::DEFAULT_TOLERANCE_S);
        let (m, deg) = (number(errors.translation_mean_m), number(errors.rotation_mean_deg));
        let long = &errors.by_span[3];
        let over =
            format!("{:.4} m / {:.3}°", number(long.translation_mean_m), number(long.rotation_mean_deg));
        section.body += &closed.row(name, &format!("{m:.4} m / {deg:.3}°"), &over);
        section.claims.extend([
            claim(format!("{name}, loops closed without a stroke: all relations"), m, bound_m, "m", 4),
            claim(format!("{name}, loops closed without a stroke: rotation"), deg, bound_deg, "°", 3),
        ]);
        if name == "Intel" {
            let what = "Intel, raw log to closed map: wall clock".into();
            section.claims.push(claim(what, closed.run.seconds, 10.0, "s", 1));
        }
    }
    for (name, log, reference) in OTHERS {
        let Some(closed) = closed(&scratch, name, log, &mut section)? else { continue };
        let error = match reference {
            Some(reference) => {
                let ate_m = ate_m(&closed.map.trajectory(), &project(reference))?;
                let what = format!("{name}, loops closed without a stroke: ATE to its reference");
                section.claims.push(claim(what, ate_m, 0.08, "m", 3));
                format!("ATE {ate_m:.3} m")
            }
            None => "no truth".into(),
        };
        section.body += &closed.row(name, &error, "–");
    }
    worlds(&mut section)?;
    Ok(section)
}

/// A log that became a closed map.
struct Closed {
    map: SlamMap,
    run: child::Run,
}

impl Closed {
    fn row(&self, name: &str, error: &str, over: &str) -> String {
        let Closed { map, run } = self;
        let disagree = map.automatic_factors.iter().filter(|a| a.disagrees()).count();
        // What a second look finds, so that nothing has to be read off a terminal.
        let passes = reassociated(map).map_or("–".into(), |(_, r)| r.near_passes.len().to_string());
        format!(
            "| {name} | {}, {} | {} ({disagree}) | {passes} | {error} | {over} | {:.1} | {:.0} |\n",
            map.scans.len(),
            map.poses.len(),
            map.automatic_factors.len(),
            run.seconds,
            run.peak_mb
        )
    }
}

fn closed(scratch: &Scratch, name: &str, log: &str, section: &mut Section) -> Result<Option<Closed>> {
    let log = project(log);
    if !log.exists() {
        section.body += &format!("| {name} | skipped: ../shared is absent | | | | | | |\n");
        return Ok(None);
    }
    let (log, output) = (log.display().to_string(), scratch.text("closed.npz"));
    let run = child::hitl(&["import", &log, "--front-end", "scan-match", "--close-loops", "-o", &output])?;
    let map = io::native::read(Path::new(&output))?.value;
    Ok(Some(Closed { map, run }))
}

fn reassociated(map: &SlamMap) -> Result<(SlamMap, closures::Report)> {
    let mut corrector = Corrector::new(map.clone(), Options::default())?;
    let never = AtomicBool::new(false);
    let found = corrector.reassociate(&closures::Options::default(), &|_| {}, &never)?;
    let report = found.ok_or("cancelled by nobody")?.report;
    Ok((corrector.into_map(), report))
}

/// Against a reference that names scans by their index.
fn ate_m(estimate: &Trajectory, reference: &Path) -> Result<f64> {
    let text = std::fs::read_to_string(reference)?;
    let mut pairs = Vec::new();
    for line in text.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?;
        pairs.push((estimate.poses[v[0] as usize].translation(), Vec2::new(v[2], v[3])));
    }
    let aligned = metrics::align(&pairs);
    let squared = pairs.iter().map(|(p, q)| (aligned.transform_point(*p) - q).norm_squared());
    Ok((squared.sum::<f64>() / pairs.len() as f64).sqrt())
}

/// Strokes alone against strokes with re-association, where the truth is known.
fn worlds(section: &mut Section) -> Result<()> {
    let _ = write!(
        section.body,
        "\n**Simulated worlds**, seeds 1–{SEEDS}, strokes with 2 cm of noise: ATE in m, mean ± 95 % interval (worst seed).\n\n\
         | world | before | strokes alone | strokes, re-association | re-association alone | withdrawn |\n|---|---|---|---|---|---|\n"
    );
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    for scenario in WORLDS {
        let all = runs::parallel(&seeds, |&seed| {
            let s = runs::simulated(scenario, seed, 0.02)?;
            let (strokes, _) = runs::corrected(&s.map, &s.corrections, Options::default())?;
            let ((both, report), (alone, _)) = (reassociated(&strokes)?, reassociated(&s.map)?);
            let ate = [&s.map, &strokes, &both, &alone].map(|m| runs::ate_m(&m.poses, &s.truth));
            Ok((ate, report.withdrawn))
        })?;
        let sample = |k: usize| Sample::of(all.iter().map(|(ate, _)| ate[k]));
        let cell = |k: usize| format!("{} ({:.3})", sample(k).with_interval(3), sample(k).largest());
        let withdrawn = all.iter().filter(|(_, withdrawn)| *withdrawn).count();
        let name = scenario.name();
        let cells = [0, 1, 2, 3].map(cell).join(" | ");
        section.body += &format!("| {name} | {cells} | {withdrawn} |\n");
        let what = format!("{name}, strokes with re-association: mean ATE");
        let why = "the same strokes without it, same runs";
        let (measured, bound) = (sample(2).mean(), sample(1).mean());
        section.claims.push(Claim { what, measured, bound, unit: "m", decimals: 3, why });
    }
    Ok(())
}

fn claim(what: String, measured: f64, bound: f64, unit: &'static str, decimals: usize) -> Claim {
    Claim { what, measured, bound, unit, decimals, why: "issue" }
}

fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}
