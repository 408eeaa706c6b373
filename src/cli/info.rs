//! `hitl info`: what is in a file.

use std::path::PathBuf;

use hitl_slam::error::Result;
use hitl_slam::geometry::Pose2;
use hitl_slam::io::{self, Source};
use hitl_slam::map::{RawLog, SlamMap, Trajectory};

use super::{Outcome, load};

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
    line("format", format.name());
    match &read.value {
        Source::Log(log) => describe_log(log),
        Source::Map(map) => describe_map(map),
        Source::Trajectory(trajectory) => describe_trajectory(trajectory),
        _ => {}
    }
    Ok(Outcome::Done)
}

fn describe_log(log: &RawLog) {
    let poses: Vec<Pose2> = log.scans.iter().map(|s| s.odometry_from_robot).collect();
    let returns =
        |s: &hitl_slam::map::LogScan| s.ranges_m.iter().filter(|&&r| f64::from(r) < s.max_range_m).count();
    line("scans", log.scans.len());
    line("beams", span(log.scans.iter().map(|s| s.ranges_m.len() as f64)));
    line("readings", log.scans.iter().map(returns).sum::<usize>());
    line("max range", span(log.scans.iter().map(|s| s.max_range_m)) + " m");
    line("field of view", span(log.scans.iter().map(|s| field_of_view(s).to_degrees().round())) + "°");
    line("laser on robot", offset(log.robot_from_laser));
    describe_path(&poses);
    describe_stamps(&log.scans.iter().map(|s| s.stamp_s).collect::<Vec<_>>());
}

fn field_of_view(scan: &hitl_slam::map::LogScan) -> f64 {
    scan.bearing_step_rad * scan.ranges_m.len().saturating_sub(1) as f64
}

fn describe_map(map: &SlamMap) {
    let closures = map.relative_factors.iter().filter(|f| f.i.abs_diff(f.j) != 1).count();
    line("poses", map.poses.len());
    line("scans", map.scans.len());
    line("points", map.observations.len());
    line("relative factors", format!("{}, of which {closures} close loops", map.relative_factors.len()));
    line("human factors", map.human_factors.len());
    for factor in &map.human_factors {
        let (a, b) = (&factor.a, &factor.b);
        println!(
            "                    {}: {}, {} points of {} poses with {} points of {} poses",
            factor.id,
            factor.mode.name(),
            a.points.len(),
            a.sightings.len(),
            b.points.len(),
            b.sightings.len()
        );
    }
    line("held poses", format!("{:?}", map.held_or_first()));
    line("laser on robot", offset(map.robot_from_laser));
    describe_path(&map.poses);
    match &map.stamps_s {
        Some(_) => describe_stamps(&map.trajectory().stamps_s),
        None => line("stamps", "none"),
    }
}

fn describe_trajectory(trajectory: &Trajectory) {
    line("poses", trajectory.poses.len());
    describe_path(&trajectory.poses);
    describe_stamps(&trajectory.stamps_s);
}

fn describe_path(poses: &[Pose2]) {
    let length: f64 = poses.windows(2).map(|w| (w[1].translation() - w[0].translation()).norm()).sum();
    line("path", format!("{length:.1} m"));
    let x = span(poses.iter().map(|p| (p.x_m * 100.0).round() / 100.0));
    let y = span(poses.iter().map(|p| (p.y_m * 100.0).round() / 100.0));
    line("bounds of poses", format!("x {x} m, y {y} m"));
}

fn describe_stamps(stamps_s: &[f64]) {
    let backwards = stamps_s.windows(2).filter(|w| w[1] <= w[0]).count();
    line("stamps", span(stamps_s.iter().copied()) + " s");
    if backwards > 0 {
        line("", format!("{backwards} do not increase"));
    }
}

fn offset(pose: Pose2) -> String {
    format!("x {} m, y {} m, {:.2}°", pose.x_m, pose.y_m, pose.theta_rad.to_degrees())
}

fn span(values: impl Iterator<Item = f64>) -> String {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low == high { format!("{low}") } else { format!("{low} to {high}") }
}

fn line(name: &str, value: impl std::fmt::Display) {
    println!("{name:<18}  {value}");
}
