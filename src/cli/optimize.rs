//! `hitl optimize`: plain pose-graph optimisation.

use std::path::PathBuf;
use std::time::Instant;

use hitl_slam::error::Result;
use hitl_slam::io::{self, Indefinite};
use hitl_slam::joint::{self, Backend};
use hitl_slam::solver::Termination;

use super::{Outcome, load, out, outliers, report};

/// Optimise a pose graph: relative factors only, human factors left out.
///
/// The first vertex is held unless the graph says which (FIX); a graph in separate parts has one vertex held in each.
/// False loop closures: `--gnc` finds and leaves them out, `--loss` weakens them.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The graph: g2o, TORO or a native map.
    graph: PathBuf,
    /// Where to write the result; the name's ending picks the format.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Who solves it.
    #[arg(long, default_value = "rust", value_name = "rust|ceres")]
    solver: Backend,
    /// At most so many accepted steps.
    #[arg(long, default_value_t = 50, value_name = "N")]
    max_iterations: usize,
    /// Take the nearest positive definite matrix where an edge's information is not (else: refused at its line).
    #[arg(long)]
    repair_information: bool,
    #[command(flatten)]
    robust: outliers::Args,
    /// Write the numbers as JSON; `-` is stdout.
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,
}

/// The numbers of docs/FORMATS.md.
#[derive(serde::Serialize)]
struct Numbers {
    vertices: usize,
    edges: usize,
    initial_chi2: f64,
    final_chi2: f64,
    iterations: usize,
    termination: Termination,
    load_ms: f64,
    order_ms: f64,
    optimize_ms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    robust: Option<outliers::Found>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    args.solver.require()?;
    super::options::at_least_one("--max-iterations", args.max_iterations)?;
    io::check_map_path(&args.output)?;
    let clock = Instant::now();
    let mut options = joint::Options { backend: args.solver, ..Default::default() };
    options.solver.max_iterations = args.max_iterations;
    args.robust.set(&mut options)?;
    let indefinite = if args.repair_information { Indefinite::Repair } else { Indefinite::Refuse };
    let mut map = load::map_with(&args.graph, indefinite)?;
    let load_ms = milliseconds(clock);
    let clock = Instant::now();
    let done = args.robust.optimize(&mut map, &options)?;
    let all_ms = milliseconds(clock);
    let numbers = Numbers {
        vertices: map.poses.len(),
        edges: map.every_relative_factor().count(),
        initial_chi2: done.initial_chi2,
        final_chi2: done.final_chi2,
        iterations: done.solve.iterations.len(),
        termination: done.solve.termination,
        load_ms,
        order_ms: done.solve.timings.order_ms,
        optimize_ms: all_ms - done.solve.timings.order_ms,
        robust: args.robust.found(&map, &options),
    };
    io::write_map(&args.output, &map)?;
    load::remark(&done.solve.warnings);
    report::write(args.report.as_deref(), &numbers)?;
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&text(&numbers))?;
    }
    Ok(Outcome::Done)
}

fn text(n: &Numbers) -> String {
    let converged = if n.termination.converged() { "" } else { ", not converged" };
    format!(
        "{} vertices, {} edges\nchi2 {:.6} -> {:.6} in {} iterations ({}{converged})\n\
         {}load {:.1} ms, order {:.1} ms, optimize {:.1} ms\n",
        n.vertices,
        n.edges,
        n.initial_chi2,
        n.final_chi2,
        n.iterations,
        n.termination.name().replace('_', " "),
        n.robust.as_ref().map(outliers::Found::text).unwrap_or_default(),
        n.load_ms,
        n.order_ms,
        n.optimize_ms,
    )
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
