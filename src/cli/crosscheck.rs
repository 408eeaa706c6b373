//! `hitl crosscheck`: both solvers on the identical problems.

use std::fmt::Write as _;
use std::path::PathBuf;

use hitl_slam::crosscheck::{self, Check, CrossCheck, Place, Totals};
use hitl_slam::error::Result;
use hitl_slam::joint::Backend;
use hitl_slam::solver::{Iteration, Report};

use super::{Outcome, load, out, report, tunables};

/// Solve the same problems with both solvers and compare them.
///
/// Every correction is interpreted once; the joint problem that follows goes to the Rust solver and to Ceres, and the
/// Rust result is carried on. Exit code 1 if they disagree: residuals beyond 1e-9, Jacobians beyond 1e-7 or, in the
/// formulation `smooth`, costs beyond 1e-8, poses beyond 1e-6 m or 1e-6 rad.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The map: a native map or any file that can be imported.
    input: PathBuf,
    /// The corrections, one JSON object a line.
    #[arg(short, long, value_name = "C.jsonl")]
    corrections: PathBuf,
    /// Write the numbers as JSON; `-` is stdout.
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,
    #[command(flatten)]
    tunables: tunables::Tunables,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    Backend::Ceres.require()?;
    let map = load::map(&args.input)?;
    let corrections = load::corrections(&args.corrections)?;
    hitl_slam::interpret::check(&map, &corrections)?;
    let options = args.tunables.options()?;
    let found = crosscheck::run(map, &corrections, &options)?;
    report::write(args.report.as_deref(), &found)?;
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&text(&found))?;
    }
    Ok(if found.agree { Outcome::Done } else { Outcome::CheckFailed })
}

/// The report for a person.
fn text(found: &CrossCheck) -> String {
    let mut out = String::new();
    let width = found.corrections.iter().map(|c| c.id.chars().count()).max().unwrap_or(0).max(10);
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "{:<width$} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>4} {:>10} {:>4}  verdict",
        "correction",
        "residual",
        "jacobian",
        "poses m",
        "angle rad",
        "cost rel",
        "rust ms",
        "it",
        "ceres ms",
        "it"
    );
    for check in &found.corrections {
        match &check.rejected {
            Some(reason) => {
                let _ = writeln!(out, "{:<width$} rejected: {reason}", check.id);
            }
            None => row(&mut out, width, &check.id, &check.totals, check.agree),
        }
    }
    row(&mut out, width, "all", &found.total, found.agree);
    for check in found.corrections.iter().filter(|c| c.rejected.is_none()) {
        details(&mut out, check);
    }
    let verdict = if found.agree { "agree" } else { "DISAGREE" };
    let _ = writeln!(out, "\nformulation {}: the two solvers {verdict}", found.formulation.name());
    out
}

fn row(out: &mut String, width: usize, name: &str, t: &Totals, agree: bool) {
    let _ = writeln!(
        out,
        "{name:<width$} {:>9.1e} {:>9.1e} {:>9.1e} {:>9.1e} {:>9.1e} {:>10.2} {:>4} {:>10.2} {:>4}  {}",
        t.max_residual_difference,
        t.max_jacobian_difference,
        t.max_pose_difference_m,
        t.max_angle_difference_rad,
        t.relative_cost_difference,
        t.rust_ms,
        t.rust_iterations,
        t.ceres_ms,
        t.ceres_iterations,
        if agree { "agree" } else { "DISAGREE" },
    );
}

/// Where the largest differences sit and what both solvers did, side by side.
fn details(out: &mut String, check: &Check) {
    let _ = writeln!(out, "\n{}", check.id);
    for (what, place) in [("residual", check.worst_residual), ("jacobian", check.worst_jacobian)] {
        if let Some(place) = place {
            let _ = writeln!(out, "  largest difference of a {what}: {}", describe(&place));
        }
    }
    let (Some(rust), Some(ceres)) = (&check.rust, &check.ceres) else { return };
    let _ = writeln!(out, "  {:>4}  {:<44}  {:<44}", "step", "rust", "ceres");
    let _ = writeln!(out, "  {:>4}  {:<44}  {:<44}", "", HEADER, HEADER);
    let rows = rust.iterations.len().max(ceres.iterations.len());
    let start = |r: &Report| format!("{:>17.10e} {:>8} {:>8}  start", r.initial_cost, "", "");
    let _ = writeln!(out, "  {:>4}  {:<44}  {:<44}", 0, start(rust), start(ceres));
    for k in 0..rows {
        let cell = |r: &Report| r.iterations.get(k).map(iteration).unwrap_or_default();
        let _ = writeln!(out, "  {:>4}  {:<44}  {:<44}", k + 1, cell(rust), cell(ceres));
    }
    let digits = |r: &Report| match r.polish.steps {
        0 => "no step".to_owned(),
        steps => format!("{steps} Gauss-Newton, the last {:.0e}", r.polish.last_step),
    };
    let _ = writeln!(out, "  {:>4}  {:<44}  {:<44}", "fine", digits(rust), digits(ceres));
    let end = |r: &Report| r.termination.name().replace('_', " ");
    let _ = writeln!(out, "  {:>4}  {:<44}  {:<44}", "end", end(rust), end(ceres));
    for warning in rust.warnings.iter().chain(&ceres.warnings) {
        let _ = writeln!(out, "  {warning}");
    }
}

const HEADER: &str = "             cost     step   lambda";

fn iteration(i: &Iteration) -> String {
    let verdict = if i.accepted { "" } else { "refused" };
    format!("{:>17.10e} {:>8.1e} {:>8.1e}  {verdict}", i.cost, i.step_max, i.damping)
}

fn describe(place: &Place) -> String {
    let mut text = format!("{} {}, row {}", place.kind.name().replace('_', " "), place.index, place.row);
    if let (Some(block), Some(column)) = (place.block, place.column) {
        let _ = write!(text, ", block {block}, column {column}");
    }
    text
}
