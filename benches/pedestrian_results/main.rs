//! `cargo bench --bench pedestrian_results`: writes docs/RESULTS-pedestrian.md and docs/img/pedestrian-*.png.
//!
//! Ten seeds, 10,000 particles unless a line says otherwise. With names of chapters (`-- laps controls`) it measures these
//! and prints them; with `--page` too it writes the page, the other chapters as they were last measured in this checkout.

mod controls;
#[allow(dead_code)] // the other page's parts
#[path = "../results/cpu.rs"]
mod cpu;
mod experiments;
mod figures;
mod laps;
mod live;
mod maps;
mod meet;
#[allow(dead_code)] // the other page's parts
#[path = "../results/page.rs"]
mod page;
mod real;
mod scale;
#[path = "../results/store.rs"]
mod store;
mod unknown_starts;

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::pedestrian::feetslam::Snapshot;
use hitl_slam::pedestrian::footslam::Estimate;
use hitl_slam::pedestrian::successive::{self, Ends, Mode, Outcome};
use hitl_slam::pedestrian::{GridChoice, Options, Start, Walk, metrics};
use hitl_slam::simulate::walkers::{Scenario, Settings, Simulation};
use page::{Claim, Section};
use rayon::prelude::*;
use store::Measured;

const SEEDS: u64 = 10;

/// Measures a chapter: its text goes to the page, its bounds into the summary.
type Measure = fn(&mut String) -> Vec<Claim>;

/// In the order of the page.
const CHAPTERS: &[(&str, Measure)] = &[
    ("speed", scale::speed),
    ("many", scale::many),
    ("experiments", experiments::chapter),
    ("controls", controls::chapter),
    ("laps", laps::chapter),
    ("maps", maps::chapter),
    ("unknown-starts", unknown_starts::chapter),
    ("live", live::chapter),
    ("meet", meet::chapter),
    ("foot", real::foot),
    ("foot-loops", real::foot_loops),
    ("phone", real::phone),
    ("figures", figures::chapter),
];

/// `-- --quick`: fewer particles and cases, for a busy machine; the page says so.
fn is_quick() -> bool {
    std::env::args().any(|a| a == "--quick")
}

/// Particles of the corridor experiments.
fn particles() -> usize {
    if is_quick() { 2_000 } else { 10_000 }
}

fn rounds() -> Mode {
    Mode::Successive(Ends::Lengths(vec![14.0, 24.0, 34.0]))
}

fn run(simulation: &Simulation, mode: &Mode, options: &Options) -> Outcome {
    run_seen(simulation, mode, options, &mut |_| ())
}

fn run_seen(
    simulation: &Simulation,
    mode: &Mode,
    options: &Options,
    see: &mut dyn FnMut(&Snapshot),
) -> Outcome {
    let start = Start { pose: simulation.starts[0], ..Start::default() };
    successive::run(&simulation.walks, start, false, mode, options, see).expect("simulated walks are fine")
}

fn positions(poses: &[Pose2]) -> Vec<Vec2> {
    poses.iter().map(|p| p.translation()).collect()
}

/// Errors at every true position: best particle, weighted mean, dead reckoning.
fn errors(simulation: &Simulation, walk: &Walk, estimate: &Estimate, start: Pose2) -> [Vec<f64>; 3] {
    [estimate.best.clone(), positions(&estimate.mean), positions(&walk.track(start))]
        .map(|path| metrics::errors_m(walk, &path, &simulation.truth))
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// Median and quartiles.
fn median(values: &[f64]) -> String {
    format!("{:.2} [{:.2}–{:.2}]", quantile(values, 0.5), quantile(values, 0.25), quantile(values, 0.75))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn claim(what: impl Into<String>, measured: f64, bound: f64, unit: &'static str, why: &'static str) -> Claim {
    let decimals = if bound >= 20.0 { 0 } else { 2 };
    Claim { what: what.into(), measured, bound, unit, decimals, why }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(["--child", job @ ..]) = arguments.iter().map(String::as_str).collect::<Vec<_>>().get(..) {
        return scale::child(job);
    }
    // `cargo test --benches` runs this too, without `--bench`: then there is nothing to do.
    if !arguments.iter().any(|a| a == "--bench") {
        return println!("skipped: run it with `cargo bench --bench pedestrian_results`");
    }
    let wanted: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with('-')).collect();
    if let Some(unknown) = wanted.iter().find(|w| CHAPTERS.iter().all(|(name, _)| name != *w)) {
        let names = CHAPTERS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        eprintln!("found chapter \"{unknown}\", expected some of {names}");
        std::process::exit(2);
    }
    let rewrites = wanted.is_empty() || arguments.iter().any(|a| a == "--page");
    let kept = if is_quick() { "pedestrian-quick" } else { "pedestrian" };
    let mut chapters = Vec::new();
    for &(name, measure) in CHAPTERS {
        if wanted.is_empty() || wanted.contains(&name) {
            let (begun, mut body) = (Instant::now(), String::new());
            let section = Section { name, claims: measure(&mut body), body, ..Section::default() };
            let chapter = Measured { section, seconds: begun.elapsed().as_secs_f64() };
            eprintln!("{name}: {:.1} s", chapter.seconds);
            store::keep(kept, name, &chapter).expect("target/results can be written");
            chapters.push(chapter);
        } else if rewrites {
            chapters.push(store::last(kept, name).expect("every other chapter was measured before"));
        }
    }
    let seconds = chapters.iter().map(|c| c.seconds).sum();
    let sections: Vec<Section> = chapters.into_iter().map(|c| c.section).collect();
    let page = page_of(&sections, seconds);
    if !rewrites {
        return println!("{page}");
    }
    let path = page::project("docs/RESULTS-pedestrian.md");
    io::atomic::write(&path, |out| out.write_all(page.as_bytes())).expect("docs can be written");
    println!("wrote docs/RESULTS-pedestrian.md, measured in {seconds:.0} s");
}

fn page_of(sections: &[Section], seconds: f64) -> String {
    let mut page = format!(
        "# Results: pedestrians\n\nWritten by `make results` (= `cargo bench --bench pedestrian_results`) in {seconds:.0} s; edit nothing here. {} \
         Every number outside the last chapters, on real walks, is from simulated walks (`hitl feetslam simulate`), seeds 1–{SEEDS}, 10,000 particles unless a line says \
         otherwise. Read docs/MATH-pedestrian.md, \"What the aligned grid is\", before quoting any of the small numbers: they come \
         from a straight-corridor prior and not from the map.\n\n",
        page::machine()
    );
    if is_quick() {
        page +=
            "**This page is a `--quick` run: 2,000 particles in the corridor experiments and controls.**\n\n";
    }
    page += "Every bound is an upper bound.\n\n## Summary\n\n| claim | measured | bound | met | where the bound comes from |\n|---|---|---|---|---|\n";
    sections.iter().for_each(|s| page += &s.rows(false));
    let missed: String = sections.iter().map(|s| s.rows(true)).collect();
    if !missed.is_empty() {
        page += "\n## Aims not reached yet\n\n| aim | measured | bound | met | where the bound comes from |\n|---|---|---|---|---|\n";
        page += &missed;
    }
    sections.iter().for_each(|s| page += &s.body);
    page
}
