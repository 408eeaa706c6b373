//! Strokes alone, drawn by the simulated person on undamaged scan-matched chains of real logs.

use std::fmt::Write;

use hitl_slam::io;
use hitl_slam::simulate::person::Reference;

use crate::effort;
use crate::page::{Claim, Result, Section, project};
use crate::runs;
use crate::stats::Sample;

/// The bounds for 4 strokes, of the logs in their order.
const BOUNDS_M: [f64; 2] = [0.065, 0.042];
const SEEDS: u64 = 20;
const STROKES: usize = 4;

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Strokes alone", name: "strokes", ..Section::default() };
    let _ = write!(
        section.body,
        "Scan-matched chains, no loop closure (`--no-reassociate`), a simulated person with 3 cm of drawing noise per coordinate \
         (`hitl simulate person`), seeds 1–{SEEDS}: mean error over all relations in m, mean over seeds ± 95 % interval (worst).\n\n\
         | log | before | after 1 stroke | after 2 | after 3 | after 4 |\n|---|---|---|---|---|---|\n"
    );
    for ((name, log, relations), bound) in runs::REAL_LOGS.into_iter().zip(BOUNDS_M) {
        let [log, relations] = [log, relations].map(project);
        if !log.exists() {
            let _ = writeln!(section.body, "| {name} | skipped: ../shared is absent | | | | |");
            continue;
        }
        let chain = effort::scan_matched(&io::carmen::read(&log)?.value)?;
        let relations = io::relations::read(&relations)?.value;
        let seeds: Vec<u64> = (1..=SEEDS).collect();
        let courses = runs::parallel(&seeds, |&seed| {
            let error_m = |map: &_| effort::relation_error_m(map, &relations);
            effort::course(&chain, Reference::Relations(&relations), seed, STROKES, error_m)
        })?;
        let _ = write!(section.body, "| {name} ");
        for k in 0..=STROKES {
            let errors = Sample::of(courses.iter().map(|c| c[k]));
            let _ = write!(section.body, "| {} ({:.3}) ", errors.with_interval(4), errors.largest());
        }
        section.body.push_str("|\n");
        section.claims.push(Claim {
            what: format!("{name}, scan-matched chain, {STROKES} simulated strokes alone: all relations"),
            measured: Sample::of(courses.iter().map(|c| c[STROKES])).mean(),
            bound,
            unit: "m",
            decimals: 4,
            why: "issue",
        });
    }
    Ok(section)
}
