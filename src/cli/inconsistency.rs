//! `hitl inconsistency`: how much a map contradicts itself.

use std::path::PathBuf;

use hitl_slam::error::Result;
use hitl_slam::metrics::{self, InconsistencyOptions};

use super::{Outcome, load, out, report};

/// Measure how much a map contradicts itself: the area that one pose saw free and a later one occupied, in m².
///
/// Summed over all pairs of poses, as the paper does. A ray shows free space up to the margin before its own return, and
/// nowhere nearer than that to any return of its pose. The true map does not score zero: compare maps, or take the
/// excess over the truth. `hitl render MAP --inconsistency -o X.png` shows where.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// Map or log to measure.
    input: PathBuf,

    /// Side of a cell, metres.
    #[arg(long, value_name = "M", default_value_t = InconsistencyOptions::default().resolution_m)]
    resolution_m: f64,

    /// How far a free cell must be from the returns, metres.
    #[arg(long, value_name = "M", default_value_t = InconsistencyOptions::default().free_margin_m)]
    free_margin_m: f64,

    /// Write the numbers as JSON; - for the standard output.
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,
}

/// The numbers of docs/FORMATS.md.
#[derive(serde::Serialize)]
struct Numbers {
    inconsistency_m2: f64,
    resolution_m: f64,
    free_margin_m: f64,
    pairs: u64,
}

/// Runs the command.
///
/// # Errors
/// Bad options, or files that cannot be read or written.
pub fn run(args: &Args) -> Result<Outcome> {
    super::options::positive("--resolution-m", args.resolution_m)?;
    report::check(args.report.as_deref())?;
    let map = load::map(&args.input)?;
    let options = InconsistencyOptions { resolution_m: args.resolution_m, free_margin_m: args.free_margin_m };
    let found = metrics::inconsistency(&map, &options)?;
    let numbers = Numbers {
        inconsistency_m2: found.area_m2,
        resolution_m: args.resolution_m,
        free_margin_m: args.free_margin_m,
        pairs: found.pairs,
    };
    report::write(args.report.as_deref(), &numbers)?;
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&format!(
            "inconsistency       {:.3} m²\ncells of            {} m, free up to {} m before a return\n\
             contradictions      {} (cell, pair of poses)\n",
            found.area_m2, args.resolution_m, args.free_margin_m, found.pairs
        ))?;
    }
    Ok(Outcome::Done)
}
