//! `hitl correct`: the main job, in batch.

mod batch;
mod contradictions;
mod pictures;
mod report;
mod table;

use std::path::{Path, PathBuf};
use std::time::Instant;

use hitl_slam::error::{Error, Result};
use hitl_slam::joint::Backend;
use hitl_slam::map::{Correction, SlamMap};
use hitl_slam::pipeline::{Agreement, CorrectionReport, Corrector, Options, Reassociation};
use hitl_slam::{interpret, io, session};
use indicatif::{ProgressBar, ProgressStyle};

use super::options::at_least_one;
use super::{Outcome, load, out, reassociate, tunables};

/// Correct a map: apply two-stroke corrections in order, each optimised with all that came before.
///
/// Every correction says of two strokes, drawn on two stretches of wall, how the walls relate:
///   colocation     the same wall, and the same place along it
///   collinear      on one line, free to slide along it
///   parallel       same direction
///   perpendicular  at a right angle
/// Then visits that come near each other are matched with each other (re-association): what fits
/// becomes an automatic factor, found anew every time; --no-reassociate leaves it at the strokes.
/// A correction that cannot be applied (no wall under a stroke, say) is rejected with its reason; the rest go on.
/// `hitl correct MAP -c C.jsonl --interpret-only --pictures DIR` shows what the strokes catch before anything moves.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, allow_negative_numbers = true)]
pub struct Args {
    /// Native map, or any file that `hitl import` reads.
    input: PathBuf,

    /// Corrections, one JSON object a line: {"mode": "collinear", "a": STROKE, "b": STROKE}; a stroke is
    /// [[x, y], [x, y]] in the world, or {"pose": i, "points": …} or {"stamp": t, "points": …} in the robot's frame.
    /// A session of `hitl serve` does, too.
    #[arg(short, long, value_name = "C.jsonl")]
    corrections: PathBuf,

    /// Corrected map; the extension picks the format: .npz (everything), .g2o, .graph (TORO), .stfs.covars, .tum.
    #[arg(short, long, value_name = "OUT", required_unless_present = "interpret_only")]
    output: Option<PathBuf>,

    /// Who solves: our own solver, or Ceres (where built).
    #[arg(long, value_name = "rust|ceres", default_value = "rust")]
    solver: Backend,

    /// Show what every stroke catches on the map as it stands, and correct nothing.
    #[arg(long)]
    interpret_only: bool,

    #[command(flatten)]
    reassociate: reassociate::Args,

    /// Also keep corrections that contradict the rest. Otherwise they are named, and the map is corrected without them.
    #[arg(long)]
    keep_contradictions: bool,

    /// Corrected trajectory (TUM text), one line per scan of the log.
    #[arg(long, value_name = "T.tum")]
    trajectory: Option<PathBuf>,

    /// Report (JSON); - prints it to stdout.
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,

    /// Folder for pictures: before, after, and both side by side; with --interpret-only the strokes on the map.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,

    /// Many maps: with folders for MAP, --corrections and -o, correct this many at once [default: one a core].
    /// Maps and corrections are paired by file stem; -o gets STEM.npz and summary.json (elsewhere with --report), the
    /// pictures go to DIR/STEM. A map that fails leaves the others done.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,

    /// Exit with 1 if a correction was rejected.
    #[arg(long)]
    strict: bool,

    #[command(flatten)]
    tunables: tunables::Tunables,
}

/// A corrected map.
struct Corrected {
    corrector: Corrector,
    reports: Reports,
    contradictions: Vec<contradictions::Entry>,
    reassociation: Option<Reassociation>,
    /// The map as it was, if pictures are wanted.
    before: Option<SlamMap>,
    total_ms: f64,
}

/// Reads and corrects one map.
fn one(args: &Args, options: Options, map: &Path, corrections: &Path) -> Result<Corrected> {
    let file = corrections;
    let state = load::wanted(file)?;
    let session::State { corrections, straighten, .. } = &state;
    let place = map.display();
    let map = load::map(map)?;
    interpret::check(&map, corrections).map_err(|error| in_file(file, error))?;
    if map.observations.is_empty() {
        let message = "found a map without points, expected laser points for the strokes to catch";
        return Err(Error::input(place, message));
    }
    let before = args.pictures.is_some().then(|| map.clone());
    let start = Instant::now();
    let mut corrector = Corrector::new(map, options)?;
    let is_quiet = args.input.is_dir();
    let wanted = args.reassociate.options()?.filter(|_| !args.interpret_only);
    let (reports, contradictions, reassociation) = if args.interpret_only {
        (interpret_all(&corrector, corrections)?, Vec::new(), None)
    } else if let (Some(_), false) = (&wanted, state.closings.is_empty()) {
        // A session in which visits were matched says itself where.
        let (reports, found) = follow(&mut corrector, &state, is_quiet)?;
        let left = hitl_slam::contradictions::find(corrector.map(), &corrector.options().joint)?.named;
        let mut agreement = Agreement { reports, set_aside: Vec::new(), left };
        (std::mem::take(&mut agreement.reports), contradictions::entries(&mut agreement), found)
    } else {
        // What a person saw and left as it is, stays.
        let keep = args.keep_contradictions || session::is_session(file);
        let mut agreement = apply_all(&mut corrector, corrections, keep, is_quiet)?;
        let contradictions = contradictions::entries(&mut agreement);
        let found = match wanted {
            Some(options) => Some(reassociate::run(&mut corrector, &options, is_quiet)?),
            None => None,
        };
        (agreement.reports, contradictions, found)
    };
    if let Some(along) = straighten.filter(|_| !args.interpret_only) {
        corrector.turn(session::world_from_map(&corrector, &along)?);
    }
    let total_ms = start.elapsed().as_secs_f64() * 1e3;
    Ok(Corrected { corrector, reports, contradictions, reassociation, before, total_ms })
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    let is_batch = args.input.is_dir() && args.corrections.is_dir();
    if !is_batch {
        check_outputs(args)?;
        if args.jobs.is_some() {
            return Err(Error::input("--jobs", "found with a single map, expected a folder of maps"));
        }
    }
    args.solver.require()?;
    args.reassociate.options()?;
    let mut options = args.tunables.options()?;
    options.joint.backend = args.solver;
    if is_batch {
        at_least_one("--jobs", args.jobs.unwrap_or(1))?;
        return batch::run(args, options);
    }
    let done = one(args, options, &args.input, &args.corrections)?;
    let mut json = report::Report::new(&done, &args.tunables);
    let Corrected { corrector, reports, reassociation, before, .. } = done;
    if args.report.is_some() && !args.interpret_only {
        json.uncertainty = Some(super::report::Uncertainty::of(corrector.map(), &options.joint)?);
    }
    let map = corrector.into_map();
    write_outputs(args, &map, before.as_ref(), &reports)?;
    if !super::report::is_on_stdout(args.report.as_deref()) {
        let found = reassociation.map(|r| reassociate::text(&map, &r)).unwrap_or_default();
        out::print(&(table::text(&json, args.interpret_only) + &found))?;
    }
    super::report::write(args.report.as_deref(), &json)?;
    let rejected = reports.iter().any(|r| r.rejection.is_some() && r.enabled);
    Ok(if args.strict && rejected { Outcome::CheckFailed } else { Outcome::Done })
}

/// An error of a correction, with the file that it stands in.
fn in_file(file: &Path, error: Error) -> Error {
    match error {
        Error::Input { place, message } => {
            Error::Input { place: format!("{}: {place}", file.display()), message }
        }
        other => other,
    }
}

/// Whatever cannot be written must be known before the work begins, and no output may take another's place.
fn check_outputs(args: &Args) -> Result<()> {
    if let Some(output) = &args.output {
        io::check_map_path(output)?;
    }
    if let Some(trajectory) = &args.trajectory {
        io::atomic::check(trajectory)?;
    }
    if let Some(folder) = &args.pictures {
        io::atomic::check(&folder.join("before.png"))?;
    }
    super::report::check(args.report.as_deref())?;
    let report = args.report.as_ref().filter(|r| !super::report::is_on_stdout(Some(r)));
    let files = [
        ("--output", args.output.as_ref()),
        ("--trajectory", args.trajectory.as_ref()),
        ("--report", report),
    ];
    for (k, &(_, file)) in files.iter().enumerate() {
        if let Some((name, _)) = files[..k].iter().find(|(_, other)| file.is_some() && *other == file) {
            let message = format!("found the same file as for {name}, expected another");
            return Err(Error::input(files[k].0, message));
        }
    }
    Ok(())
}

/// One report per correction, in order.
type Reports = Vec<CorrectionReport>;

/// Takes the very steps of a session.
fn follow(
    corrector: &mut Corrector,
    state: &session::State,
    is_quiet: bool,
) -> Result<(Reports, Option<Reassociation>)> {
    let style = ProgressStyle::with_template("following the session {bar:30} {percent} %")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(0).with_style(style) };
    let done = session::apply(corrector, state, &mut |done, of| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        true
    });
    bar.finish_and_clear();
    done
}

fn apply_all(
    corrector: &mut Corrector,
    corrections: &[Correction],
    keep: bool,
    is_quiet: bool,
) -> Result<Agreement> {
    let style = ProgressStyle::with_template("correcting {bar:30} {pos}/{len} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(corrections.len() as u64) };
    let bar = bar.with_style(style);
    let agreement = corrector.apply_agreeing(corrections, keep, &|correction| {
        bar.set_message(correction.id.clone());
        bar.set_position((bar.position() + 1).min(corrections.len() as u64));
    })?;
    bar.finish_and_clear();
    let reports = &agreement.reports;
    let mut warnings: Vec<String> = Vec::new();
    for warning in reports.iter().filter_map(|r| r.solve.as_ref()).flat_map(|s| &s.warnings) {
        if !warnings.contains(warning) {
            warnings.push(warning.clone());
        }
    }
    load::remark(&warnings);
    Ok(agreement)
}

fn interpret_all(corrector: &Corrector, corrections: &[Correction]) -> Result<Reports> {
    corrections.iter().map(|c| corrector.preview(c)).collect()
}

fn write_outputs(
    args: &Args,
    map: &SlamMap,
    before: Option<&SlamMap>,
    reports: &[CorrectionReport],
) -> Result<()> {
    if !args.interpret_only {
        // The map first: its format may not be able to hold it.
        if let Some(path) = &args.output {
            io::write_map(path, map)?;
        }
        if let Some(path) = &args.trajectory {
            io::tum::write(path, &map.trajectory())?;
        }
    }
    match (&args.pictures, before) {
        (Some(folder), Some(before)) => pictures::write(folder, before, map, reports, args.interpret_only),
        _ => Ok(()),
    }
}
