//! `hitl feetslam run`: from walks to a map and better paths.

use std::path::PathBuf;
use std::time::Instant;

use clap::ValueEnum;
use hitl_slam::error::{Error, Result};
use hitl_slam::geometry::Segment;
use hitl_slam::io;
use hitl_slam::pedestrian::feetslam::Snapshot;
use hitl_slam::pedestrian::successive::{self, Ends, Mode};
use hitl_slam::pedestrian::{TruthPoint, Walk};

use super::options::Tunables;
use super::output;
use super::pictures::Gallery;
use super::report::Report;
use crate::cli::{Outcome, report};

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModeName {
    /// Every walker alone.
    Footslam,
    /// All walkers together, once, on the whole walks.
    Feetslam,
    /// FeetSLAM again and again on ever longer parts of the walks (needs --ends-m or --ends-s).
    Successive,
}

/// Build a map from pedestrians' steps, and correct their paths with it.
///
/// Writes into OUT: paths.csv (corrected and reckoned positions after every step), map.json and map.npz (expected
/// crossings of every hexagon edge), report.json. FootSLAM is covered by a patent (US 8,626,443 B2, DLR; listed active
/// until 20 September 2030): check before commercial use.
#[derive(clap::Args)]
pub struct Args {
    /// Walks: time_s,forward_m,left_m,turn_rad; a walker's name is its file's stem
    #[arg(value_name = "WALK.csv", required = true)]
    walks: Vec<PathBuf>,
    /// Who maps with whom
    #[arg(long, value_enum)]
    mode: ModeName,
    /// Ends of the rounds: path lengths from the start, ascending
    #[arg(long, value_name = "M,…", value_delimiter = ',')]
    ends_m: Vec<f64>,
    /// Ends of the rounds: times since each walker's start, ascending
    #[arg(long, value_name = "S,…", value_delimiter = ',', conflicts_with = "ends_m")]
    ends_s: Vec<f64>,
    #[command(flatten)]
    tunables: Tunables,
    /// Walkers' start poses are unknown: find them by overlapping the maps; the first walker is at --start
    #[arg(long)]
    align: bool,
    /// With --align: walkers' lengths may be in different scales too; each gets its own, the first walker's is 1
    #[arg(long, requires = "align")]
    align_scale: bool,
    /// True positions, for the errors: walker,time_s,x_m,y_m
    #[arg(long, value_name = "TRUTH.csv")]
    truth: Option<PathBuf>,
    /// A floor plan, for pictures and the crossed-wall ratio: `x1, y1, x2, y2` a line
    #[arg(long, value_name = "WALLS")]
    plan: Option<PathBuf>,
    /// Folder for the results; made if missing
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Write the report as JSON here too; - for the standard output
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,
    /// Draw maps, paths and errors into this folder
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Threads; 0: one per core. The results are the same
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

/// What was read, checked as a whole before anything is written.
struct Input {
    walks: Vec<Walk>,
    truth: Vec<TruthPoint>,
    walls: Vec<Segment>,
}

/// Runs the command.
///
/// # Errors
/// Bad input as the contract says, or files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    let started = Instant::now();
    let mode = mode(args)?;
    let (mut options, start) = (args.tunables.options(), args.tunables.filter.start()?);
    options.align_scale = args.align_scale;
    let input = read(args)?;
    let threads = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build()
        .map_err(|e| Error::Internal(e.to_string()))?;
    let mut gallery = args.pictures.as_ref().map(|_| Gallery::default());
    let bar = indicatif::ProgressBar::new_spinner();
    let outcome = threads.install(|| {
        let mut observe = |snapshot: &Snapshot| {
            bar.set_message(format!("round {}, iteration {}", snapshot.round + 1, snapshot.iteration));
            bar.tick();
            if let Some(gallery) = &mut gallery {
                gallery.keep(snapshot);
            }
        };
        successive::run(&input.walks, start, args.align, &mode, &options, &mut observe)
    })?;
    bar.finish_and_clear();

    let mut result = Report::new(&input.walks, &outcome, &input.truth, &input.walls, &options);
    result.settings.grid = args.tunables.filter.grid_name();
    result.wall_ms = started.elapsed().as_secs_f64() * 1e3;
    output::write(&args.output, &input.walks, &outcome)?;
    if args.plan.is_some() {
        io::floor_plan::write(&args.output.join("walls.csv"), &input.walls)?;
    }
    if let (Some(gallery), Some(folder)) = (&gallery, &args.pictures) {
        gallery.write(folder, &input.walks, &outcome, &result, &input.walls)?;
    }
    result.peak_rss_mb = report::peak_rss_mb();
    report::write(Some(&args.output.join("report.json")), &result)?;
    report::write(args.report.as_deref(), &result)?;
    match args.report.as_deref() {
        Some(path) if path.as_os_str() == "-" => eprint!("{}", result.table()),
        _ => print!("{}", result.table()),
    }
    Ok(Outcome::Done)
}

fn mode(args: &Args) -> Result<Mode> {
    Ok(match args.mode {
        ModeName::Footslam => Mode::FootSlam,
        ModeName::Feetslam => Mode::FeetSlam,
        ModeName::Successive => {
            let (name, ends) = match args.ends_s.is_empty() {
                true => ("--ends-m", Ends::Lengths(args.ends_m.clone())),
                false => ("--ends-s", Ends::Times(args.ends_s.clone())),
            };
            if args.ends_m.is_empty() && args.ends_s.is_empty() {
                return Err(Error::input("--ends-m", "found none, expected the ends of the rounds"));
            }
            ends.validate().map_err(|e| match e {
                Error::Input { message, .. } => Error::input(name, message),
                other => other,
            })?;
            Mode::Successive(ends)
        }
    })
}

fn read(args: &Args) -> Result<Input> {
    let walks = io::walk::read_all(&args.walks)?;
    walks.warnings.iter().for_each(|w| eprintln!("hitl: {w}"));
    let mut input = Input { walks: walks.value, truth: Vec::new(), walls: Vec::new() };
    if let Some(path) = &args.truth {
        input.truth = io::walk::read_truth(path)?.value;
        if !input.truth.iter().any(|t| input.walks.iter().any(|w| w.name == t.walker)) {
            let names: Vec<&str> = input.walks.iter().map(|w| w.name.as_str()).collect();
            let message = format!("found no line of {}, expected true positions of them", names.join(", "));
            return Err(Error::input(path.display(), message));
        }
    }
    if let Some(path) = &args.plan {
        let walls = io::floor_plan::read(path)?;
        walls.warnings.iter().for_each(|w| eprintln!("hitl: {w}"));
        input.walls = walls.value;
    }
    Ok(input)
}
