//! `hitl evaluate`: how good a map or trajectory is.

use std::path::PathBuf;

use hitl_slam::error::{Error, Result};
use hitl_slam::map::SlamMap;
use hitl_slam::metrics::{
    self, DEFAULT_TOLERANCE_S, Evaluation, PoseError, Reference, RelationErrors, WallErrors,
};
use hitl_slam::render::{self, MapPictureOptions, Mark, PlacedErrors, Plot, Series};

use super::{Outcome, load, out, picture, report};

/// Measure a map or trajectory: against a true trajectory, hand-checked relations, its own measurements.
///
/// ATE is taken after rigid alignment without scale, RPE from each matched pose to the next. The worst edge is the
/// relative factor that the poses contradict most; a map with a tear has a large one.
#[derive(Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// Map, graph, log or TUM trajectory to measure.
    #[arg(value_name = "INPUT|T.tum")]
    input: PathBuf,

    /// The true trajectory; poses are matched by stamp, or by index where there are no stamps.
    #[arg(long, value_name = "T.tum")]
    truth: Option<PathBuf>,

    /// Hand-checked relations between scans (Kümmerle et al. 2009).
    #[arg(long, value_name = "FILE")]
    relations: Option<PathBuf>,

    /// The true walls (needs --truth): angles and distances between named pairs of them, as in the paper's Table 1.
    #[arg(long, value_name = "WALLS.csv", requires = "truth")]
    walls: Option<PathBuf>,

    /// Which walls to compare [default: pairs.csv beside WALLS.csv].
    #[arg(long, value_name = "PAIRS.csv", requires = "walls")]
    wall_pairs: Option<PathBuf>,

    /// Stamps closer than this are the same moment, seconds.
    #[arg(long, value_name = "S", default_value_t = DEFAULT_TOLERANCE_S)]
    tolerance_s: f64,

    /// Write the numbers as JSON; - for the standard output.
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,

    /// Draw the error over time (needs --truth); .png or .svg.
    #[arg(long, value_name = "X.png|X.svg", requires = "truth")]
    plot: Option<PathBuf>,

    /// Draw the map with the errors coloured along the trajectory: of each pose (--truth), else of each relation at both its
    /// poses; .png or .svg.
    #[arg(long, value_name = "X.png|X.svg")]
    picture: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Bad options, files that cannot be read or written, or that share no stamp.
pub fn run(args: &Args) -> Result<Outcome> {
    if !(args.tolerance_s.is_finite() && args.tolerance_s >= 0.0) {
        return Err(Error::input(
            "--tolerance-s",
            format_args!("found {}, expected a number ≥ 0", args.tolerance_s),
        ));
    }
    if args.picture.is_some() && args.truth.is_none() && args.relations.is_none() {
        return Err(Error::input("--picture", "found neither --truth nor --relations, expected one of them"));
    }
    for path in args.plot.iter().chain(&args.picture) {
        picture::check(path)?;
    }
    report::check(args.report.as_deref())?;
    let map = load::map(&args.input)?;
    let truth = args.truth.as_deref().map(load::trajectory).transpose()?;
    let relations = args.relations.as_deref().map(load::relations).transpose()?;
    let walls = args.walls.as_deref().map(load::walls).transpose()?;
    let beside = || args.walls.as_ref().map(|walls| walls.with_file_name("pairs.csv"));
    let pairs = args.wall_pairs.clone().or_else(beside);
    let pairs = pairs.as_deref().map(load::wall_pairs).transpose()?;
    let reference = Reference {
        truth: truth.as_ref(),
        relations: relations.as_deref(),
        walls: walls.as_deref().zip(pairs.as_deref()),
        tolerance_s: args.tolerance_s,
    };
    let evaluation = metrics::evaluate(&map, &reference)?;
    if let Some(path) = &args.plot {
        picture::write(path, &error_plot(&evaluation.errors).draw())?;
    }
    if let Some(path) = &args.picture {
        let options = MapPictureOptions { errors: Some(placed(&map, &evaluation)), ..Default::default() };
        picture::write(path, &render::map(&map, &options))?;
    }
    report::write(args.report.as_deref(), &evaluation)?;
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&table(&evaluation))?;
    }
    Ok(Outcome::Done)
}

/// The numbers of the report for a person; lines whose number is absent are left out.
fn table(evaluation: &Evaluation) -> String {
    let mut table = Table::default();
    table.line("poses", evaluation.poses.to_string());
    table.maybe("  with a true pose", evaluation.matched_poses.map(|n| n.to_string()));
    table.pair("ATE, position", evaluation.ate_rmse_m, evaluation.ate_max_m, "m", 4);
    table.maybe("ATE, heading", evaluation.heading_rmse_rad.map(|v| format!("{v:.5} rad rmse")));
    table.pair("RPE, translation", evaluation.rpe_trans_rmse_m, evaluation.rpe_trans_max_m, "m", 4);
    table.pair("RPE, rotation", evaluation.rpe_rot_rmse_rad, evaluation.rpe_rot_max_rad, "rad", 5);
    table.maybe("worst edge", evaluation.worst_edge_m.map(|v| format!("{v:.4} m")));
    table.maybe("worst edge, in its σ", evaluation.worst_edge_sigma.map(|v| format!("{v:.2}")));
    if let Some(relations) = &evaluation.relations {
        table.relations(relations);
    }
    if let Some(walls) = &evaluation.walls {
        table.walls(walls);
    }
    table.text
}

#[derive(Default)]
struct Table {
    text: String,
}

impl Table {
    fn line(&mut self, name: &str, value: String) {
        self.text.push_str(&format!("{name:<24}{value}\n"));
    }

    fn maybe(&mut self, name: &str, value: Option<String>) {
        if let Some(value) = value {
            self.line(name, value);
        }
    }

    fn pair(&mut self, name: &str, rmse: Option<f64>, max: Option<f64>, unit: &str, decimals: usize) {
        if let (Some(rmse), Some(max)) = (rmse, max) {
            self.line(name, format!("{rmse:.decimals$} {unit} rmse, {max:.decimals$} {unit} max"));
        }
    }

    fn walls(&mut self, walls: &WallErrors) {
        let unseen = match walls.unseen {
            0 => String::new(),
            n => format!(" ({n} left out: a wall that was never seen)"),
        };
        self.line("wall pairs", format!("{}{unseen}", walls.samples.len()));
        if let (Some(mean), Some(worst)) = (walls.angle_mean_deg, walls.angle_worst_deg) {
            self.line("  angle", format!("{mean:.3} ° mean of {}, {worst:.3} ° worst", walls.angle_count));
        }
        if let (Some(mean), Some(worst)) = (walls.distance_mean_m, walls.distance_worst_m) {
            self.line(
                "  distance",
                format!("{mean:.4} m mean of {}, {worst:.4} m worst", walls.distance_count),
            );
        }
    }

    fn relations(&mut self, relations: &RelationErrors) {
        let unmatched = match relations.unmatched {
            0 => String::new(),
            n => format!(" ({n} left out: no pose at their stamps)"),
        };
        self.line("relations", format!("{}{unmatched}", relations.count));
        if let (Some(mean), Some(std)) = (relations.translation_mean_m, relations.translation_std_m) {
            self.line("  translation", format!("{mean:.4} ± {std:.4} m"));
        }
        if let (Some(median), Some(worst)) = (relations.translation_median_m, relations.translation_worst_m) {
            self.line("", format!("{median:.4} m median, {worst:.4} m worst"));
        }
        if let (Some(mean), Some(std)) = (relations.rotation_mean_deg, relations.rotation_std_deg) {
            self.line("  rotation", format!("{mean:.3} ± {std:.3} °"));
        }
        for span in &relations.by_span {
            let (Some(translation), Some(rotation)) = (span.translation_mean_m, span.rotation_mean_deg)
            else {
                continue;
            };
            let name = match span.to_s {
                Some(to) => format!("  {}–{to} s apart", span.from_s),
                None => format!("  over {} s apart", span.from_s),
            };
            self.line(&name, format!("{translation:.4} m, {rotation:.3} ° ({})", span.count));
        }
    }
}

/// Where on the map the errors are: every pose that has a true one, else both poses of every relation.
fn placed(map: &SlamMap, evaluation: &Evaluation) -> PlacedErrors {
    let trajectory = map.trajectory();
    let at = |pose: usize, error_m: f64| (trajectory.poses[pose].translation(), error_m);
    match &evaluation.relations {
        Some(relations) if evaluation.errors.is_empty() => PlacedErrors {
            what: "error of a relation at its two poses".into(),
            errors: relations.errors.iter().flat_map(|e| e.poses.map(|k| at(k, e.translation_m))).collect(),
        },
        _ => PlacedErrors {
            what: "position error after alignment".into(),
            errors: evaluation.errors.iter().map(|e| at(e.pose, e.translation_m)).collect(),
        },
    }
}

/// Position error over the time since the first matched pose.
fn error_plot(errors: &[PoseError]) -> Plot {
    let start_s = errors.first().map_or(0.0, |e| e.stamp_s);
    let points = errors.iter().map(|e| [e.stamp_s - start_s, e.translation_m]).collect();
    let position = Series { label: String::new(), points, intervals: Vec::new(), mark: Mark::Line };
    Plot {
        title: "Position error along the trajectory".into(),
        x_label: "time since the first pose (s)".into(),
        y_label: "error after alignment (m)".into(),
        series: vec![position],
        ..Plot::default()
    }
}
