//! `hitl info`: what is in a file.

use std::path::PathBuf;

use hitl_slam::error::Result;
use hitl_slam::geometry::Pose2;
use hitl_slam::io::{self, Source};
use hitl_slam::map::{AutomaticFactor, RawLog, SlamMap, Trajectory};
use hitl_slam::pedestrian::{Step, Walk};

use super::{Outcome, load, out};

/// Indices shown in a list.
const MAX_LISTED: usize = 10;

/// Say what is in a file: poses, scans, factors, closures, bounds, stamps, frame offsets.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Log, map, pose graph or trajectory.
    input: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    let (format, read) = io::read(&args.input)?;
    load::remark(&read.warnings);
    let mut page = Page::default();
    page.line("format", format.name());
    match &read.value {
        Source::Log(log) => describe_log(&mut page, log),
        Source::Map(map) => describe_map(&mut page, map),
        Source::Trajectory(trajectory) => describe_trajectory(&mut page, trajectory),
        Source::Walks { walks, starts } => {
            for (k, walk) in walks.iter().enumerate() {
                describe_walk(&mut page, walk, starts.get(k).copied().unwrap_or(Pose2::IDENTITY));
            }
        }
        _ => {}
    }
    out::print(&page.text)?;
    Ok(Outcome::Done)
}

fn describe_log(page: &mut Page, log: &RawLog) {
    let poses: Vec<Pose2> = log.scans.iter().map(|s| s.odometry_from_robot).collect();
    let returns =
        |s: &hitl_slam::map::LogScan| s.ranges_m.iter().filter(|&&r| f64::from(r) < s.max_range_m).count();
    page.line("scans", log.scans.len());
    page.line("beams", span(log.scans.iter().map(|s| s.ranges_m.len() as f64)));
    page.line("readings", log.scans.iter().map(returns).sum::<usize>());
    page.line("max range", span(log.scans.iter().map(|s| s.max_range_m)) + " m");
    page.line("field of view", span(log.scans.iter().map(|s| field_of_view(s).to_degrees().round())) + "°");
    page.line("laser on robot", offset(log.robot_from_laser));
    describe_path(page, &poses);
    describe_stamps(page, &log.scans.iter().map(|s| s.stamp_s).collect::<Vec<_>>());
}

fn field_of_view(scan: &hitl_slam::map::LogScan) -> f64 {
    scan.bearing_step_rad * scan.ranges_m.len().saturating_sub(1) as f64
}

fn describe_map(page: &mut Page, map: &SlamMap) {
    let closures = map.relative_factors.iter().filter(|f| f.i.abs_diff(f.j) != 1).count();
    page.line("poses", map.poses.len());
    page.line("scans", map.scans.len());
    page.line("points", map.observations.len());
    page.line("relative factors", format!("{}, of which {closures} close loops", map.relative_factors.len()));
    page.line("automatic factors", automatic(&map.automatic_factors));
    page.line("human factors", map.human_factors.len());
    for factor in &map.human_factors {
        let (a, b) = (&factor.a, &factor.b);
        let (mode, points) = (factor.mode.name(), [a.points.len(), b.points.len()]);
        let poses = [a.sightings.len(), b.sightings.len()];
        page.line(
            "",
            format!(
                "{}: {mode}, {} points of {} poses with {} points of {} poses",
                factor.id, points[0], poses[0], points[1], poses[1]
            ),
        );
    }
    page.line("held poses", listed(&map.held_or_first()));
    page.line("laser on robot", offset(map.robot_from_laser));
    describe_path(page, &map.poses);
    match &map.stamps_s {
        Some(_) => describe_stamps(page, &map.trajectory().stamps_s),
        None => page.line("stamps", "none"),
    }
}

fn automatic(factors: &[AutomaticFactor]) -> String {
    let disagree = factors.iter().filter(|a| a.disagrees()).count();
    match (factors.len(), disagree) {
        (0, _) => "0".into(),
        (n, 0) => format!("{n}, all in agreement"),
        (n, disagree) => format!("{n}, of which {disagree} disagree with the rest"),
    }
}

fn describe_trajectory(page: &mut Page, trajectory: &Trajectory) {
    page.line("poses", trajectory.poses.len());
    describe_path(page, &trajectory.poses);
    describe_stamps(page, &trajectory.stamps_s);
}

fn describe_walk(page: &mut Page, walk: &Walk, start: Pose2) {
    page.line("walker", &walk.name);
    page.line("steps", walk.steps.len());
    page.line(
        "longest step",
        span(walk.steps.iter().map(Step::length_m).reduce(f64::max).into_iter()) + " m",
    );
    page.line("standstills", walk.standstills().len());
    describe_path(page, &walk.track(start));
    describe_stamps(page, &walk.steps.iter().map(|s| s.time_s).collect::<Vec<_>>());
}

fn describe_path(page: &mut Page, poses: &[Pose2]) {
    let length: f64 =
        poses.windows(2).map(|w| (w[1].translation() - w[0].translation()).norm()).fold(0.0, |a, b| a + b);
    page.line("path", format!("{length:.1} m"));
    let x = span(poses.iter().map(|p| (p.x_m * 100.0).round() / 100.0));
    let y = span(poses.iter().map(|p| (p.y_m * 100.0).round() / 100.0));
    page.line("bounds of poses", format!("x {x} m, y {y} m"));
}

fn describe_stamps(page: &mut Page, stamps_s: &[f64]) {
    let backwards = stamps_s.windows(2).filter(|w| w[1] <= w[0]).count();
    page.line("stamps", span(stamps_s.iter().copied()) + " s");
    if backwards > 0 {
        page.line("", format!("{backwards} do not increase"));
    }
}

/// The first of many.
fn listed(indices: &[usize]) -> String {
    let shown: Vec<String> = indices.iter().take(MAX_LISTED).map(ToString::to_string).collect();
    match indices.len().saturating_sub(MAX_LISTED) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

fn offset(pose: Pose2) -> String {
    format!("x {} m, y {} m, {:.2}°", pose.x_m, pose.y_m, pose.theta_rad.to_degrees())
}

fn span(values: impl Iterator<Item = f64>) -> String {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low == high { format!("{low}") } else { format!("{low} to {high}") }
}

/// What is printed.
#[derive(Default)]
struct Page {
    text: String,
}

impl Page {
    fn line(&mut self, name: &str, value: impl std::fmt::Display) {
        self.text.push_str(&format!("{name:<18}  {value}\n"));
    }
}
