//! Scan matching on real logs: the chain before any closure, and what a few strokes make of it.

use std::time::Instant;

use hitl_slam::front_end::{self, Chain};
use hitl_slam::io;
use hitl_slam::map::{RawLog, Relation, SlamMap};
use hitl_slam::metrics::{self, RelationErrors};
use hitl_slam::pipeline::Options;

use crate::page::{Claim, Result, Section, project};
use crate::runs;

/// Name, log, relations, and the bounds for relations below 10 s: metres, degrees.
const LOGS: [(&str, &str, &str, f64, f64); 2] = [
    (
        "Intel",
        "../shared/data/radish_raw/intel.clf.bz2",
        "../shared/data/radish_raw/intel.relations",
        0.012,
        0.20,
    ),
    ("ACES", "data/aces.clf.bz2", "data/aces.relations", 0.034, 0.31),
];

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Scan matching", name: "scan-match", ..Section::default() };
    section.body = "`hitl import LOG --front-end scan-match`: every scan matched to a local map of recent keyframes, no loop closure. \
                    Mean error against the relations, by the time between their scans.\n\n\
                    | log | chain | scans | below 10 s | over 120 s | time (s) |\n|---|---|---|---|---|---|\n"
        .into();
    for (name, log, relations, bound_m, bound_deg) in LOGS {
        let [log, relations] = [log, relations].map(project);
        if !log.exists() {
            section.body += &format!("| {name} | skipped: ../shared is absent | | | | |\n");
            continue;
        }
        let (log, relations) = (io::carmen::read(&log)?.value, io::relations::read(&relations)?.value);
        let progress = |_| {};
        let wheels = chain(&log, Chain::Odometry, &front_end::Options::default())?;
        let matching = Chain::ScanMatch { progress: &progress };
        let matched = chain(&log, matching, &front_end::Options::for_scan_matching())?;
        for (kind, (map, seconds)) in [("wheels", &wheels), ("scan match", &matched)] {
            let errors = errors(map, &relations);
            section.body += &format!(
                "| {name} | {kind} | {} | {} | {} | {seconds:.1} |\n",
                map.scans.len(),
                cell(&errors, 0),
                cell(&errors, 3)
            );
        }
        let errors = errors(&matched.0, &relations);
        let short = &errors.by_span[0];
        section.claims.extend([
            claim(
                format!("{name}, scan-matched chain: relations below 10 s"),
                short.translation_mean_m,
                bound_m,
                "m",
                4,
            ),
            claim(
                format!("{name}, scan-matched chain: rotation below 10 s"),
                short.rotation_mean_deg,
                bound_deg,
                "°",
                3,
            ),
        ]);
        if name == "ACES" {
            strokes(&mut section, &matched.0, &relations)?;
        }
    }
    Ok(section)
}

/// The demo's strokes on the scan-matched chain: they hang on scans, so that they fit any map of the log.
fn strokes(section: &mut Section, map: &SlamMap, relations: &[Relation]) -> Result<()> {
    let corrections = io::corrections::read(&project("data/aces.corrections.jsonl"))?.value;
    let mut rows = String::new();
    for count in [0, 4, 8] {
        let (corrected, _) = runs::corrected(map, &corrections[..count], Options::default())?;
        let errors = errors(&corrected, relations);
        let (m, deg) = (errors.translation_mean_m, errors.rotation_mean_deg);
        rows += &format!(
            "| {count} | {:.4} m / {:.2}° | {} |\n",
            m.unwrap_or(0.0),
            deg.unwrap_or(0.0),
            cell(&errors, 3)
        );
        if count == 4 {
            section.claims.push(claim(
                "ACES, scan-matched chain, 4 strokes alone: all relations".into(),
                m,
                0.042,
                "m",
                4,
            ));
        }
    }
    section.body += &format!(
        "\n**Strokes on the scan-matched chain of ACES**, the first of `data/aces.corrections.jsonl` (drawn on the odometry map), \
         no loop closure:\n\n| strokes | all relations | over 120 s |\n|---|---|---|\n{rows}\n"
    );
    Ok(())
}

fn claim(what: String, measured: Option<f64>, bound: f64, unit: &'static str, decimals: usize) -> Claim {
    let why = "set before it was built";
    Claim { what, measured: measured.unwrap_or(f64::NAN), bound, unit, decimals, why }
}

fn chain(log: &RawLog, chain: Chain, options: &front_end::Options) -> Result<(SlamMap, f64)> {
    let start = Instant::now();
    let (map, _) = front_end::build(log, chain, options)?;
    Ok((map, start.elapsed().as_secs_f64()))
}

fn errors(map: &SlamMap, relations: &[Relation]) -> RelationErrors {
    metrics::relation_errors(&map.trajectory(), relations, metrics::DEFAULT_TOLERANCE_S)
}

fn cell(errors: &RelationErrors, span: usize) -> String {
    let s = &errors.by_span[span];
    match (s.translation_mean_m, s.rotation_mean_deg) {
        (Some(m), Some(deg)) => format!("{m:.4} m / {deg:.2}° ({})", s.count),
        _ => "–".into(),
    }
}
