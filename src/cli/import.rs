//! `hitl import`: a log or graph becomes a native map.

use std::path::PathBuf;

use clap::ValueEnum;
use hitl_slam::error::{Error, Result};
use hitl_slam::front_end::{self, Chain, Visits, WalkOptions};
use hitl_slam::geometry::Pose2;
use hitl_slam::io::{self, Source};
use hitl_slam::map::{RawLog, SlamMap};
use hitl_slam::pedestrian::Walk;
use hitl_slam::pipeline::Corrector;
use indicatif::{ProgressBar, ProgressStyle};

use super::{Outcome, load, options::positive, out, reassociate, report};

/// Turn a log or a graph into a map.
///
/// A raw log becomes a chain of keyframes joined by odometry. With --graph or --initial its scans hang on the poses
/// (and factors, closures included) of another SLAM's result.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// CARMEN log (also .gz, .bz2, .xz), 16-column text, g2o or native map; or walks (CSV), several of which make one map.
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,

    /// Map to write; the extension picks the format: .npz (everything), .g2o, .graph (TORO), .stfs.covars, .tum.
    #[arg(short, long, value_name = "MAP")]
    output: PathBuf,

    /// Where the poses of a raw log come from [default: odometry].
    #[arg(long, value_enum)]
    front_end: Option<FrontEnd>,

    /// Pose graph of another SLAM (g2o): its vertices and factors, the log's scans.
    #[arg(long, value_name = "G.g2o", conflicts_with = "front_end")]
    graph: Option<PathBuf>,

    /// Trajectory of another SLAM (TUM), matched by stamp; with --graph: the stamps of its vertices, in order.
    #[arg(long, value_name = "T.tum", conflicts_with = "front_end")]
    initial: Option<PathBuf>,

    /// Match visits that come near each other, without any stroke: what fits closes a loop.
    #[arg(long)]
    close_loops: bool,

    #[command(flatten)]
    refused: reassociate::Refused,

    /// Report of --close-loops (JSON): every automatic factor, and where visits pass each other unmatched; - prints it.
    #[arg(long, value_name = "R.json", requires = "close_loops")]
    report: Option<PathBuf>,

    #[command(flatten)]
    keyframes: Keyframes,

    #[command(flatten)]
    walks: Walks,
}

/// Options of walks.
#[derive(Debug, clap::Args)]
struct Walks {
    /// Where a walk begins: x_m,y_m,heading_deg; once for all walks, or once for each, in their order [default: 0,0,0].
    #[arg(long, value_name = "X,Y,DEG", allow_hyphen_values = true)]
    start: Vec<String>,

    /// Steps that make a pose of the map.
    #[arg(long, value_name = "N", default_value_t = WalkOptions::default().steps_per_pose)]
    steps_per_pose: usize,
}

impl Walks {
    /// The options; `known`: where a file says that its walks begin.
    fn options(&self, known: &[Pose2]) -> Result<WalkOptions> {
        let given: Vec<Pose2> =
            self.start.iter().map(|text| super::options::start_pose(text)).collect::<Result<_>>()?;
        Ok(WalkOptions::starting(if given.is_empty() { known } else { &given }))
    }
}

/// Where the poses come from.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum FrontEnd {
    /// The log's own poses as they stand (for corrected logs).
    None,
    /// The wheels.
    Odometry,
    /// Every scan matched to a local map of the ones before it; no loop closure.
    ScanMatch,
}

/// Options of the front end.
#[derive(Debug, clap::Args)]
struct Keyframes {
    /// A new pose after this distance, metres [default: 0.25; scan-match: 0.4].
    #[arg(long, value_name = "M")]
    keyframe_distance_m: Option<f64>,

    /// A new pose after this turn, degrees [default: 10; scan-match: 17].
    #[arg(long, value_name = "DEG")]
    keyframe_angle_deg: Option<f64>,

    /// Drop returns nearer than this, metres.
    #[arg(long, value_name = "M", default_value_t = front_end::Options::default().min_range_m)]
    min_range_m: f64,

    /// Drop returns at or beyond this, metres.
    #[arg(long, value_name = "M", default_value_t = front_end::Options::default().max_range_m)]
    max_range_m: f64,
}

impl Keyframes {
    /// The options of the front end that was chosen.
    fn options(&self, chosen: Option<FrontEnd>) -> Result<front_end::Options> {
        let defaults = match chosen {
            Some(FrontEnd::ScanMatch) => front_end::Options::for_scan_matching(),
            _ => front_end::Options::default(),
        };
        let keyframe_distance_m = self.keyframe_distance_m.unwrap_or(defaults.keyframe_distance_m);
        let keyframe_angle_deg = self.keyframe_angle_deg.unwrap_or(defaults.keyframe_angle_rad.to_degrees());
        positive("--keyframe-distance-m", keyframe_distance_m)?;
        positive("--keyframe-angle-deg", keyframe_angle_deg)?;
        positive("--max-range-m", self.max_range_m)?;
        if !(self.min_range_m >= 0.0 && self.min_range_m < self.max_range_m) {
            let message =
                format!("found {}, expected a number from 0 to below --max-range-m", self.min_range_m);
            return Err(Error::input("--min-range-m", message));
        }
        Ok(front_end::Options {
            keyframe_distance_m,
            keyframe_angle_rad: keyframe_angle_deg.to_radians(),
            min_range_m: self.min_range_m,
            max_range_m: self.max_range_m,
            ..defaults
        })
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    io::check_map_path(&args.output)?;
    report::check(args.report.as_deref())?;
    args.refused.options()?;
    let first = &args.logs[0];
    let (log, mut map) = match load::source(first)? {
        Source::Walks { walks, starts } => (None, from_walks(walks, starts, args)?),
        _ if args.logs.len() > 1 => {
            let message = format!("found {} files, expected one, or walks only", args.logs.len());
            return Err(Error::input(args.logs[1].display(), message));
        }
        Source::Log(log) => {
            let map = from_log(&log, args)?;
            (Some(log), map)
        }
        Source::Map(map) if args.front_end.is_none() && args.graph.is_none() && args.initial.is_none() => {
            (None, map)
        }
        Source::Map(_) => {
            let message = "found a map, expected a log: --front-end, --graph and --initial need scans";
            return Err(Error::input(first.display(), message));
        }
        _ => return Err(Error::input(first.display(), "found a trajectory, expected a log or a map")),
    };
    if args.close_loops {
        map = closed(map, log.as_ref(), args)?;
    }
    io::write_map(&args.output, &map)?;
    let line = format!(
        "{}: {} poses, {} points, {} relative factors, {} scans\n",
        args.output.display(),
        map.poses.len(),
        map.observations.len(),
        map.relative_factors.len(),
        map.scans.len()
    );
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&line)?;
    }
    Ok(Outcome::Done)
}

/// Walks; several files are walks of one walker each.
fn from_walks(walks: Vec<Walk>, starts: Vec<Pose2>, args: &Args) -> Result<SlamMap> {
    if args.front_end.is_some() || args.graph.is_some() || args.initial.is_some() {
        let message = "found a walk, expected a log: --front-end, --graph and --initial need scans";
        return Err(Error::input(args.logs[0].display(), message));
    }
    let mut options = args.walks.options(&starts)?;
    options.steps_per_pose = args.walks.steps_per_pose;
    if args.logs.len() == 1 {
        return front_end::map_of_walks(&walks, &options);
    }
    let walks = io::walk::read_all(&args.logs)?;
    load::remark(&walks.warnings);
    front_end::map_of_walks(&walks.value, &options)
}

fn from_log(log: &RawLog, args: &Args) -> Result<SlamMap> {
    let mut options = args.keyframes.options(args.front_end)?;
    options.second_look = !args.close_loops;
    let initial = args.initial.as_deref().map(load::trajectory).transpose()?;
    let graph = args.graph.as_deref().map(load::graph).transpose()?;
    let bar = bar("matching scans", log);
    let progress = |done: usize| bar.set_position(done as u64);
    let chain = match (&graph, &initial, args.front_end) {
        (Some(graph), stamps, _) => Chain::Graph { graph, stamps: stamps.as_ref() },
        (None, Some(initial), _) => Chain::Initial(initial),
        (None, None, Some(FrontEnd::ScanMatch)) => Chain::ScanMatch { progress: &progress },
        (None, None, Some(FrontEnd::None)) => Chain::LoggedPoses,
        (None, None, Some(FrontEnd::Odometry) | None) => Chain::Odometry,
    };
    let map = load::map_of(log, chain, &options);
    bar.finish_and_clear();
    map
}

/// Loops closed without a stroke; then every scan of the log is matched to the walls as all visits saw them.
fn closed(map: SlamMap, log: Option<&RawLog>, args: &Args) -> Result<SlamMap> {
    let mut corrector = Corrector::new(map, Default::default())?;
    let found = reassociate::run(&mut corrector, &args.refused.options()?, false)?;
    let mut map = corrector.into_map();
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&reassociate::text(&map, &found))?;
    }
    report::write(args.report.as_deref(), &reassociate::Summary::new(&map, Some(&found)))?;
    if let Some(log) = log {
        // On a map that is still bent other visits lie beside each other.
        let visits = if found.report.withdrawn { Visits::Own } else { Visits::All };
        let bar = bar("matching scans again", log);
        let options = args.keyframes.options(args.front_end)?;
        front_end::rematch(&mut map, log, visits, &options, &|done| bar.set_position(done as u64))?;
        bar.finish_and_clear();
    }
    Ok(map)
}

fn bar(what: &str, log: &RawLog) -> ProgressBar {
    let style = ProgressStyle::with_template(&format!("{what} {{bar:30}} {{pos}}/{{len}}"))
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(log.scans.len() as u64).with_style(style)
}
