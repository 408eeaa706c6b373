//! `hitl simulate damage`: a real log or map, made bad.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use hitl_slam::error::{Error, Result};
use hitl_slam::io::{self, Source};
use hitl_slam::simulate::damage::{self, Damage, Kind, Settings};
use serde::Serialize;

use crate::cli::{Outcome, load, options::at_least_one, out, report};

/// Make a real log or map bad: what a failing sensor or front end leaves.
///
/// Writes into DIR: log.clf (from a log) or map.npz (from a map), and damage.json (what was done, where). A log is damaged
/// in its odometry or scans; whether the map suffers is up to the front end (scan matching heals a kick where scans
/// overlap). A map is damaged in its relative factors: what a failed front end leaves. The same options always write the same files.
#[derive(clap::Args)]
pub struct Args {
    /// CARMEN log, or a map without corrections.
    input: PathBuf,
    /// kick: 30° of heading lost in one step. slip: a wheel slips for 20 m (34°). blind: the laser sees nothing for 60 s
    /// (logs only). drift: the odometry bends all the way. drop: 60 s of scans are missing (logs only)
    #[arg(long, value_parser = PossibleValuesParser::new(Kind::ALL.map(Kind::name)))]
    kind: String,
    /// Damages, apart from each other
    #[arg(long, value_name = "N", default_value_t = 1)]
    count: usize,
    /// Decides where and which way
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Folder for the files; made if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// damage.json.
#[derive(Serialize)]
struct Report<'a> {
    version: &'static str,
    seed: u64,
    damages: &'a [Damage],
}

/// Runs the command.
///
/// # Errors
/// Settings that make no sense, an input that has no room for the damages, or files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    at_least_one("--count", args.count)?;
    let settings = Settings { kind: args.kind.parse()?, count: args.count, seed: args.seed };
    let [log_path, map_path, report_path] =
        ["log.clf", "map.npz", "damage.json"].map(|name| args.output.join(name));
    io::atomic::check(&report_path)?;
    let (damages, written) = match load::source(&args.input)? {
        Source::Log(log) => {
            let (log, damages) = damage::log(&log, &settings)?;
            io::carmen_log::write(&log_path, &log)?;
            (damages, log_path)
        }
        Source::Map(map) => {
            let (map, damages) = damage::map(&map, &settings)?;
            io::write_map(&map_path, &map)?;
            (damages, map_path)
        }
        _ => return Err(Error::input(args.input.display(), "found a trajectory, expected a log or a map")),
    };
    let json = Report { version: env!("CARGO_PKG_VERSION"), seed: args.seed, damages: &damages };
    report::write(Some(&report_path), &json)?;
    let lines: String = damages.iter().map(line).collect();
    out::print(&format!("{lines}→ {}\n", written.display()))?;
    Ok(Outcome::Done)
}

fn line(d: &Damage) -> String {
    let stamps = match (d.from_s, d.to_s) {
        (Some(from_s), Some(to_s)) => format!(", {from_s:.2} to {to_s:.2} s"),
        _ => String::new(),
    };
    format!(
        "{:<6} {:>5} to {:<5} {:6.2} m, heading {:+.1}°, way {:+.2} m{stamps}\n",
        d.kind, d.first, d.last, d.path_m, d.heading_deg, d.stretch_m
    )
}
