//! Our solver and other people's side by side: the same files, one run, one core, one evaluator.

use std::fs;
use std::path::{Path, PathBuf};

use hitl_slam::geometry::Pose2;
use hitl_slam::io;
use hitl_slam::joint::{self, Options};
use hitl_slam::map::SlamMap;
use hitl_slam::render::{Mark, Plot, Series};

use crate::child::Scratch;
use crate::cpu;
use crate::figures::save;
use crate::graphs::{independent_chi2, path};
use crate::page::{Claim, Result, Section};
use crate::peers::{self, Peer};
use crate::stats::Sample;

/// Files, and the share of the time of best-tuned Ceres and of GTSAM's Gauss–Newton that ours may take.
const GRAPHS: [(&str, Option<[f64; 2]>); 3] = [
    ("M3500", Some([1.0 / 11.0, 1.0 / 34.0])),
    ("INTEL", None),
    ("city10000", Some([1.0 / 18.0, 1.0 / 25.0])),
];
/// Files, and the time that reading them may take, ms.
const READ_BOUNDS_MS: [(&str, f64); 2] = [("M3500", 2.0), ("city10000", 6.0)];
const ROUNDS: usize = 5;
/// Solves within a round, of which the fastest counts.
const REPEATS: usize = 2;
const OURS: &str = "**hitl-slam**";
const TUNED: &str = "Ceres, best tuned";
const GTSAM: &str = "GTSAM, Gauss–Newton";
const SAMPLE: &str = "Ceres, as its example";

/// All rounds of one solver on one graph.
struct Column {
    name: &'static str,
    solve_ms: Vec<f64>,
    load_ms: Vec<f64>,
    iterations: usize,
    chi2: f64,
    failure: Option<String>,
}

impl Column {
    fn new(name: &'static str) -> Self {
        Column { name, solve_ms: vec![], load_ms: vec![], iterations: 0, chi2: f64::NAN, failure: None }
    }

    fn add(&mut self, graph: &SlamMap, run: Result<peers::Run>) {
        match run {
            Ok(run) => {
                self.solve_ms.push(run.cpu_ms);
                self.load_ms.push(run.load_ms);
                self.iterations = run.iterations;
                self.chi2 = independent_chi2(&SlamMap { poses: run.poses, ..graph.clone() });
            }
            Err(e) => self.failure = Some(e.to_string()),
        }
    }

    fn solve(&self) -> Sample {
        Sample(self.solve_ms.clone())
    }
}

/// Ours, as a peer: reading and the whole of `joint::optimize_graph`, of which the fastest counts.
fn ours(graph: &Path) -> Result<peers::Run> {
    let (mut load_ms, mut cpu_ms) = (f64::INFINITY, f64::INFINITY);
    let mut best: Option<(usize, Vec<Pose2>)> = None;
    for _ in 0..REPEATS {
        let (map, ms) = cpu::timed(|| io::g2o::read(graph));
        let mut map = map?.value;
        load_ms = load_ms.min(ms);
        let (report, ms) = cpu::timed(|| joint::optimize_graph(&mut map, &Options::default()));
        cpu_ms = cpu_ms.min(ms);
        best = Some((report?.solve.iterations.len(), map.poses));
    }
    let (iterations, poses) = best.ok_or("no repeats")?;
    Ok(peers::Run { cpu_ms, iterations, load_ms, poses })
}

/// Every solver in turn, round by round.
fn measure(graph: &Path, others: &[Peer], scratch: &Scratch) -> Result<Vec<Column>> {
    let map = io::g2o::read(graph)?.value;
    let mut columns = vec![Column::new(OURS)];
    columns.extend(others.iter().map(|p| Column::new(p.name)));
    for _ in 0..ROUNDS {
        let (first, rest) = columns.split_at_mut(1);
        first[0].add(&map, ours(graph));
        for (column, peer) in rest.iter_mut().zip(others) {
            if column.failure.is_none() {
                column.add(&map, peer.run(graph, REPEATS, &scratch.path("poses.txt")));
            }
        }
    }
    Ok(columns)
}

/// The graph as plain text: not every peer reads xz.
fn unpacked(name: &str, scratch: &Scratch) -> Result<PathBuf> {
    let plain = scratch.path(&format!("{name}.g2o"));
    let packed = std::io::BufReader::new(fs::File::open(path(name))?);
    std::io::copy(&mut lzma_rust2::XzReader::new(packed, true), &mut fs::File::create(&plain)?)?;
    Ok(plain)
}

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Solvers side by side", name: "solvers", ..Section::default() };
    if !path(GRAPHS[0].0).exists() {
        section.body = "skipped: the public graphs are absent\n".into();
        return Ok(section);
    }
    let scratch = Scratch::new()?;
    let (others, absent) = peers::find();
    section.body = format!(
        "The same files from the poses that stand in them, in one run, in turns: {ROUNDS} rounds, in each the fastest of {REPEATS} solves; median \
         (smallest–largest) of the rounds. CPU time of one core (`CLOCK_PROCESS_CPUTIME_ID`), ordering and symbolic analysis included, reading and building the problem not \
         (last column). χ² = Σ eᵀΩe computed anew from the poses that each hands back (`benches/results/graphs.rs`). Ours: the whole of `joint::optimize_graph`, to the last \
         digits. Ceres: `benches/peers/ceres_peer.cc`, once as its own example pose_graph_2d does it, once as well as we could tune it (poses as blocks of three, \
         analytic Jacobians, SUBSPACE_DOGLEG, EIGEN_SPARSE). GTSAM 4.3.0 and g2o (g2opy 2.3.0) from their Python wheels: `benches/peers/peer.py`. Peers stop at a relative \
         decrease of 1e-6 or 100 iterations, g2o after 10. GTSAM minimises the residual with the SE(2) logarithm: its χ² may differ in the last digits. {absent}\n\n"
    );
    let mut bars: Vec<Series> = Vec::new();
    for (category, (name, bounds)) in GRAPHS.into_iter().enumerate() {
        let columns = measure(&unpacked(name, &scratch)?, &others, &scratch)?;
        section.body += &table(name, &columns);
        let lowest = lowest_chi2(&columns);
        for column in columns.iter().filter(|c| c.chi2 <= lowest && c.name != "GTSAM, LM") {
            let label = column.name.replace('*', "");
            if !bars.iter().any(|b| b.label == label) {
                bars.push(Series {
                    label: label.clone(),
                    points: vec![],
                    intervals: vec![],
                    mark: Mark::Bars,
                });
            }
            let sample = column.solve();
            if let Some(bar) = bars.iter_mut().find(|b| b.label == label) {
                bar.points.push([category as f64, sample.median()]);
                bar.intervals.push([sample.smallest(), sample.largest()]);
            }
        }
        section.claims.extend(claims(name, bounds, &columns));
    }
    let plot = Plot {
        title: "CPU time to the lowest χ², one core, medians (no bar: not reached)".into(),
        y_label: "ms".into(),
        log_y: true,
        categories: GRAPHS.iter().map(|g| g.0.to_owned()).collect(),
        series: bars,
        size_px: (1100, 560),
        ..Plot::default()
    };
    section.body += &save("solvers.png", "CPU time of the solvers on three public graphs", &plot.draw())?;
    Ok(section)
}

/// The least that any reached, up to what leaves six digits the same.
fn lowest_chi2(columns: &[Column]) -> f64 {
    columns.iter().map(|c| c.chi2).fold(f64::INFINITY, f64::min) * 1.000_001
}

fn table(name: &str, columns: &[Column]) -> String {
    let lowest = lowest_chi2(columns);
    let ours = columns[0].solve().median();
    let mut text = format!(
        "**{name}**\n\n| solver | iterations | χ² | CPU ms | time ÷ ours | reading, CPU ms |\n|---|---|---|---|---|---|\n"
    );
    for c in columns {
        text += &match &c.failure {
            Some(failure) => format!("| {} | | fails: {} | | | |\n", c.name, complaint(failure)),
            None => format!(
                "| {} | {} | {:.4}{} | {} | {:.2} | {:.1} |\n",
                c.name,
                c.iterations,
                c.chi2,
                if c.chi2 <= lowest { "" } else { " (not the lowest)" },
                c.solve().with_range(1),
                c.solve().median() / ours,
                Sample(c.load_ms.clone()).median()
            ),
        };
    }
    text + "\n"
}

/// What a program in trouble says: the line after `…Error:`, as Python has it, or the last.
fn complaint(text: &str) -> &str {
    let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
    let named = lines.clone().skip_while(|l| !l.ends_with("Error:")).nth(1);
    named.or_else(|| lines.next_back()).unwrap_or("no message")
}

fn claims(name: &str, bounds: Option<[f64; 2]>, columns: &[Column]) -> Vec<Claim> {
    let find = |wanted: &str| columns.iter().find(|c| c.name == wanted && !c.solve_ms.is_empty());
    let mut claims = Vec::new();
    let ours = columns[0].solve().median();
    let same = columns[0].chi2 <= lowest_chi2(columns);
    for (peer, bound) in [TUNED, GTSAM].into_iter().zip(bounds.into_iter().flatten()) {
        let Some(column) = find(peer) else { continue };
        claims.push(Claim {
            what: format!("{name}: our CPU time, share of {peer} (median; same run, same χ²)"),
            // A fast way to somewhere else counts for nothing.
            measured: if same { ours / column.solve().median() } else { f64::INFINITY },
            bound,
            unit: "",
            decimals: 3,
            why: "issue: 1/11 and 1/34, city10000 1/18 and 1/25",
        });
    }
    if let Some((_, bound)) = READ_BOUNDS_MS.iter().find(|(graph, _)| *graph == name) {
        let read = Sample(columns[0].load_ms.clone()).median();
        claims.push(Claim {
            what: format!("{name}: CPU time of reading the g2o file (median)"),
            measured: read,
            bound: *bound,
            unit: "ms",
            decimals: 2,
            why: "issue",
        });
        if let Some(sample) = find(SAMPLE) {
            claims.push(Claim {
                what: format!("{name}: reading, share of the reader of Ceres' example"),
                measured: read / Sample(sample.load_ms.clone()).median(),
                bound: 1.0,
                unit: "",
                decimals: 2,
                why: "a peer, same run",
            });
        }
    }
    claims
}
