//! `hitl simulate person`: someone who repairs a map from what a reference says.

use std::path::PathBuf;

use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::pipeline::{CorrectionReport, Corrector, Options};
use hitl_slam::simulate::person::{self, Drawn, Person, Reference, Settings};

use crate::cli::{Outcome, load, options::at_least_one, out};

/// Let a simulated person repair a map: look, draw two strokes, see the map heal, look again.
///
/// The person draws where the map is visibly apart from what the reference says, worst first, until nothing is or the strokes
/// are used up. Writes the corrections; --map also writes the repaired map
/// (what `hitl correct --no-reassociate --keep-contradictions` makes of them). Scores against the same
/// reference flatter: it is known to the person.
#[derive(clap::Args)]
pub struct Args {
    /// Map to repair.
    input: PathBuf,
    /// True trajectory (TUM), matched by stamp
    #[arg(long, value_name = "T.tum", conflicts_with = "relations", required_unless_present = "relations")]
    reference: Option<PathBuf>,
    /// Hand-checked relations between scans
    #[arg(long, value_name = "FILE")]
    relations: Option<PathBuf>,
    /// Corrections at most
    #[arg(long, value_name = "N", default_value_t = 10)]
    strokes: usize,
    /// Standard deviation of a drawn end point, per coordinate
    #[arg(long, value_name = "M", default_value_t = Settings::default().drawing_noise_m)]
    drawing_noise_m: f64,
    /// Probability that stroke b lies on another wall near the right one
    #[arg(long, value_name = "P", default_value_t = Settings::default().wrong)]
    wrong: f64,
    /// What is less apart is not seen
    #[arg(long, value_name = "M", default_value_t = Settings::default().visible_m)]
    visible_m: f64,
    /// Decides all that is left to chance
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Corrections to write
    #[arg(short, long, value_name = "C.jsonl")]
    output: PathBuf,
    /// The repaired map, to write as well
    #[arg(long, value_name = "MAP")]
    map: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Settings that make no sense, files that cannot be read or written, or a reference of another log.
pub fn run(args: &Args) -> Result<Outcome> {
    at_least_one("--strokes", args.strokes)?;
    let settings = Settings {
        seed: args.seed,
        drawing_noise_m: args.drawing_noise_m,
        wrong: args.wrong,
        visible_m: args.visible_m,
    };
    settings.validate()?;
    io::atomic::check(&args.output)?;
    args.map.as_deref().map_or(Ok(()), io::check_map_path)?;
    let map = load::map(&args.input)?;
    let truth = args.reference.as_deref().map(load::trajectory).transpose()?;
    let relations = args.relations.as_deref().map(load::relations).transpose()?;
    let reference = match (&truth, &relations) {
        (Some(truth), _) => Reference::Truth(truth),
        (None, Some(relations)) => Reference::Relations(relations),
        (None, None) => return Err(Error::input("--reference", "found none, expected it or --relations")),
    };
    let mut person = Person::new(&map, reference, &settings)?;
    let mut corrector = Corrector::new(map, Options::default())?;
    let done = person::repair(&mut corrector, &mut person, args.strokes)?;
    let corrections: Vec<_> = done.iter().map(|(drawn, _)| drawn.correction.clone()).collect();
    io::corrections::write(&args.output, &corrections)?;
    if let Some(path) = &args.map {
        io::write_map(path, corrector.map())?;
    }
    let lines: String = done.iter().map(|(drawn, report)| line(drawn, report)).collect();
    let end = match person.look(corrector.map()) {
        Some(next) => format!("still {:.2} m apart", next.apart_m),
        None => format!("nothing is {} m apart any more", settings.visible_m),
    };
    out::print(&format!("{lines}{} strokes, {end} → {}\n", done.len(), args.output.display()))?;
    Ok(Outcome::Done)
}

fn line(drawn: &Drawn, report: &CorrectionReport) -> String {
    let Drawn { correction: c, is_wrong, apart_m, .. } = drawn;
    let wrong = if *is_wrong { ", on the wrong wall" } else { "" };
    let insists = if c.weight > 1.0 { format!(", weight {}", c.weight) } else { String::new() };
    let end = report.rejection.as_ref().map_or(String::new(), |reason| format!(", rejected: {reason}"));
    format!("  {:<4} {:<10} {apart_m:6.2} m apart{insists}{wrong}{end}\n", c.id, c.mode.name())
}
