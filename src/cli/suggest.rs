//! `hitl suggest`: where would a correction help most?

use std::path::PathBuf;

use hitl_slam::error::Result;
use hitl_slam::geometry::Vec2;
use hitl_slam::io;
use hitl_slam::map::SlamMap;
use hitl_slam::render::{self, Colour, MapPictureOptions, Overlay};
use hitl_slam::suggest::{self, Options, Suggestion};
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use serde::Serialize;

use super::{Outcome, load, options::at_least_one, options::positive, out, picture, report};

/// Say where a correction would help most: ranked places, each with two strokes and their likely mode.
///
/// Three things are looked for: a break (the chain's own scans contradict it beyond its covariance), one wall that stands
/// there twice, and visits of one place that lie apart. Every suggestion is a guess: look at it (--picture), drop the lines that are
/// wrong, and give the rest to `hitl correct`. They build on each other: apply them in order.
#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// Map, graph with scans, or log.
    input: PathBuf,

    /// Suggestions at most.
    #[arg(long, value_name = "N", default_value_t = Options::default().most)]
    most: usize,

    /// What is less apart than this is no reason to draw, metres.
    #[arg(long, value_name = "M", default_value_t = Options::default().visible_m)]
    visible_m: f64,

    /// Write them as corrections, one a line, for `hitl correct`.
    #[arg(short, long, value_name = "C.jsonl")]
    corrections: Option<PathBuf>,

    /// Draw the map with the suggested strokes, numbered; .png or .svg.
    #[arg(long, value_name = "X.png|X.svg")]
    picture: Option<PathBuf>,

    /// Report (JSON); - prints it to stdout.
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report<'a> {
    version: &'static str,
    poses: usize,
    visible_m: f64,
    suggestions: &'a [Suggestion],
    total_ms: f64,
}

/// Runs the command.
///
/// # Errors
/// Bad options, files that cannot be read or written, a map without points.
pub fn run(args: &Args) -> Result<Outcome> {
    at_least_one("--most", args.most)?;
    positive("--visible-m", args.visible_m)?;
    if let Some(path) = &args.picture {
        picture::check(path)?;
    }
    args.corrections.as_deref().map_or(Ok(()), io::atomic::check)?;
    report::check(args.report.as_deref())?;
    let map = load::map(&args.input)?;
    let start = std::time::Instant::now();
    let options = Options { most: args.most, visible_m: args.visible_m, ..Options::default() };
    let found = {
        let bar = bar(args.most);
        suggest::suggest(&map, &options, &|found| {
            bar.set_position(found as u64);
            true
        })?
    };
    let total_ms = start.elapsed().as_secs_f64() * 1e3;
    if let Some(path) = &args.corrections {
        let lines: Vec<_> = found.iter().map(|s| s.correction.clone()).collect();
        io::corrections::write(path, &lines)?;
    }
    if let Some(path) = &args.picture {
        picture::write(path, &drawn(&map, &found))?;
    }
    let json = Report {
        version: env!("CARGO_PKG_VERSION"),
        poses: map.poses.len(),
        visible_m: args.visible_m,
        suggestions: &found,
        total_ms,
    };
    report::write(args.report.as_deref(), &json)?;
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&text(&found, args.visible_m))?;
    }
    Ok(Outcome::Done)
}

/// Cleared when it goes; hidden where there is no terminal.
fn bar(most: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("looking for places {bar:30} {pos}/{len}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(most as u64).with_style(style).with_finish(ProgressFinish::AndClear);
    bar.tick();
    bar
}

fn text(found: &[Suggestion], visible_m: f64) -> String {
    if found.is_empty() {
        return format!("nothing to suggest: no two visits that could be matched are {visible_m} m apart\n");
    }
    let mut text = format!("{:>2}  {:<13}{:<12}{:>7}  {:<11}why\n", "", "what", "mode", "apart", "poses");
    for s in found {
        let [i, j] = s.poses;
        text += &format!(
            "{:>2}  {:<13}{:<12}{:>5.2} m  {:<11}{}\n",
            s.rank,
            s.kind.name(),
            s.correction.mode.name(),
            s.apart_m,
            format!("{i}, {j}"),
            s.reason
        );
    }
    text
}

/// The map with both strokes of every suggestion on it, where the map shows them now.
fn drawn(map: &SlamMap, found: &[Suggestion]) -> render::Picture {
    let mut overlays = Vec::new();
    for s in found {
        for (stroke, colour) in [(&s.correction.a, Colour::RED), (&s.correction.b, Colour::BLUE)] {
            let hitl_slam::map::Stroke::Pose { pose, points } = *stroke else { continue };
            let ends: [Vec2; 2] = points.map(|p| map.poses[pose].transform_point(p));
            overlays.push(Overlay { ends, label: s.rank.to_string(), colour, width_px: 5.0 });
        }
    }
    let title = match found.len() {
        0 => "nothing to suggest".into(),
        n => format!("{n} suggestions, the most helpful first"),
    };
    let options =
        MapPictureOptions { title: Some(title), overlays, with_grid: true, ..MapPictureOptions::default() };
    render::map(map, &options)
}
