//! `cargo bench --bench results`: measures everything that docs/RESULTS.md says, and writes that page and its pictures.
//! With section names as arguments (`-- accuracy time`) only those, printed instead of written; with `--page` too the page is
//! written all the same, its other chapters as they were last measured in this checkout.

mod ablations;
mod accuracy;
mod aces;
#[path = "../../tests/support/against_truth.rs"]
mod against_truth;
mod along_line;
mod backends;
mod baseline;
mod big;
mod calibration;
mod child;
mod closures;
mod cpu;
mod crosscheck;
mod effort;
mod false_closures;
mod figures;
mod formulations;
mod graphs;
mod growing;
mod inconsistency;
mod intel;
mod invariance;
mod page;
mod paper_figures;
mod path_match;
mod peers;
mod profile;
mod reweighing;
mod runs;
mod scan_match;
mod serve;
mod solver_scale;
mod solvers;
mod stats;
mod store;
mod strokes;
mod suggest;
mod table1;
mod time;
mod weights;
mod wrong_strokes;

use std::time::Instant;

use page::{Result, Section};
use store::Measured;

/// Measures one section.
type Measure = fn() -> Result<Section>;

/// In the order of the page.
const SECTIONS: &[(&str, Measure)] = &[
    ("accuracy", accuracy::section),
    ("invariance", invariance::section),
    ("along-line", along_line::section),
    ("time", time::section),
    ("size", big::section),
    ("weights", weights::section),
    ("aces", aces::section),
    ("scan-match", scan_match::section),
    ("calibration", calibration::section),
    ("intel", intel::section),
    ("closures", closures::section),
    ("suggest", suggest::section),
    ("strokes", strokes::section),
    ("effort", effort::section),
    ("wrong-strokes", wrong_strokes::section),
    ("crosscheck", crosscheck::section),
    ("backends", backends::section),
    ("paper", formulations::section),
    ("graphs", graphs::section),
    ("solvers", solvers::section),
    ("false-closures", false_closures::section),
    ("profile", profile::section),
    ("solver-scale", solver_scale::section),
    ("growing", growing::section),
    ("reweighing", reweighing::section),
    ("table1", table1::section),
    ("inconsistency", inconsistency::section),
    ("ablations", ablations::section),
    ("serve", serve::section),
    ("figures", paper_figures::section),
];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // `cargo test --benches` runs this too, without `--bench`: then there is nothing to do.
    if !arguments.iter().any(|a| a == "--bench") {
        println!("skipped: run it with `cargo bench --bench results`");
        return Ok(());
    }
    if let Some(poses) = arguments.iter().find_map(|a| a.strip_prefix("--size=")) {
        return solver_scale::one_size(poses.parse()?);
    }
    let wanted: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with('-')).collect();
    if let Some(unknown) = wanted.iter().find(|w| SECTIONS.iter().all(|(name, _)| name != *w)) {
        let names = SECTIONS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        return Err(format!("found section \"{unknown}\", expected some of {names}").into());
    }
    let rewrites = wanted.is_empty() || arguments.iter().any(|a| a == "--page");
    let mut measured = Vec::new();
    for &(name, measure) in SECTIONS {
        if wanted.is_empty() || wanted.contains(&name) {
            let begun = Instant::now();
            let chapter = Measured { section: measure()?, seconds: begun.elapsed().as_secs_f64() };
            eprintln!("{name}: {:.1} s", chapter.seconds);
            store::keep("results", name, &chapter)?;
            measured.push(chapter);
        } else if rewrites {
            measured.push(store::last("results", name)?);
        }
    }
    let seconds = measured.iter().map(|m| m.seconds).sum();
    let sections: Vec<Section> = measured.into_iter().map(|m| m.section).collect();
    let page = page::page(&sections, seconds);
    if rewrites {
        std::fs::write(page::project("docs/RESULTS.md"), page)?;
        println!("wrote docs/RESULTS.md, measured in {seconds:.0} s");
    } else {
        println!("{page}");
    }
    Ok(())
}
