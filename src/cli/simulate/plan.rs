//! `hitl simulate plan`: a robot's run through a given building.

use std::path::PathBuf;

use hitl_slam::error::Result;
use hitl_slam::io;
use hitl_slam::map::Trajectory;
use hitl_slam::simulate::{self, Settings};

use crate::cli::{Outcome, load, out};

/// Simulate a robot's run through a building given by its walls.
///
/// Writes into DIR: map.npz (the map as the drifting odometry makes it), truth.tum (the true poses) and walls.csv. For strokes,
/// let `hitl simulate person` repair it. The same options always write the same files.
#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// Walls: `x1, y1, x2, y2` a line, metres, or walls.csv
    walls: PathBuf,
    /// Length of the way
    #[arg(long, value_name = "M", default_value_t = 300.0)]
    length_m: f64,
    /// Decides all that is left to chance
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Factor on the odometry's errors: 1 is nominal, 0 a perfect chain
    #[arg(long, value_name = "F", default_value_t = Settings::default().drift)]
    drift: f64,
    /// Standard deviation of a laser range
    #[arg(long, value_name = "M", default_value_t = Settings::default().range_noise_m)]
    range_noise_m: f64,
    /// Folder for the files; made if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// Settings that make no sense, walls that leave no free space, or files that cannot be read or written.
pub fn run(args: &Args) -> Result<Outcome> {
    let settings = Settings {
        seed: args.seed,
        drift: args.drift,
        range_noise_m: args.range_noise_m,
        ..Settings::default()
    };
    let folder = &args.output;
    io::check_map_path(&folder.join("map.npz"))?;
    let read = io::floor_plan::read(&args.walls)?;
    load::remark(&read.warnings);
    let simulation = simulate::run_through(&read.value, args.length_m, &settings)?;
    let truth = Trajectory { poses: simulation.truth, ..simulation.map.trajectory() };
    io::write_map(&folder.join("map.npz"), &simulation.map)?;
    io::tum::write(&folder.join("truth.tum"), &truth)?;
    io::walls::write(&folder.join("walls.csv"), &simulation.walls)?;
    let (poses, points) = (simulation.map.poses.len(), simulation.map.observations.len());
    let line = format!("{poses} poses, {points} points → {}\n", folder.display());
    out::print(&line)?;
    Ok(Outcome::Done)
}
