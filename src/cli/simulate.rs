//! `hitl simulate`: a world, a robot's run through it, its truth and a simulated person's strokes.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use hitl_slam::error::Result;
use hitl_slam::io;
use hitl_slam::map::Trajectory;
use hitl_slam::simulate::{self, Scenario, Settings, Wall};

use super::{Outcome, out};

/// Simulate a robot's run: a bent map, its truth, and the corrections a person would draw on it.
///
/// Writes into DIR: map.npz (the map as the drifting odometry makes it), truth.tum (the true poses),
/// corrections.jsonl (what a person would draw; input of `hitl correct`) and walls.csv (the world).
/// The same options always write the same files.
#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct Args {
    /// loop: one lap of a ring of corridors, 650 poses. campus: three buildings, 3,100 poses
    #[arg(value_parser = PossibleValuesParser::new(Scenario::ALL.map(Scenario::name)))]
    scenario: String,
    /// Decides all that is left to chance
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Folder for the files; made if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Factor on the odometry's errors: 1 is nominal, 0 a perfect chain
    #[arg(long, value_name = "F", default_value_t = Settings::default().drift)]
    drift: f64,
    /// Standard deviation of a laser range
    #[arg(long, value_name = "M", default_value_t = Settings::default().range_noise_m)]
    range_noise_m: f64,
    /// Standard deviation of a drawn end point, per axis
    #[arg(long, value_name = "M", default_value_t = Settings::default().drawing_noise_m)]
    drawing_noise_m: f64,
}

/// Runs the command.
///
/// # Errors
/// Settings that make no sense, or files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    let scenario: Scenario = args.scenario.parse()?;
    let settings = Settings {
        seed: args.seed,
        drift: args.drift,
        range_noise_m: args.range_noise_m,
        drawing_noise_m: args.drawing_noise_m,
    };
    io::check_map_path(&args.output.join("map.npz"))?;
    let simulation = simulate::run(scenario, &settings)?;
    let truth = Trajectory { poses: simulation.truth, ..simulation.map.trajectory() };

    let folder = &args.output;
    io::write_map(&folder.join("map.npz"), &simulation.map)?;
    io::tum::write(&folder.join("truth.tum"), &truth)?;
    io::corrections::write(&folder.join("corrections.jsonl"), &simulation.corrections)?;
    write_walls(&folder.join("walls.csv"), &simulation.walls)?;
    let line = format!(
        "{scenario}, seed {}: {} poses, {} points, {} corrections → {}\n",
        settings.seed,
        simulation.map.poses.len(),
        simulation.map.observations.len(),
        simulation.corrections.len(),
        folder.display()
    );
    out::print(&line)?;
    Ok(Outcome::Done)
}

/// `name,x1_m,y1_m,x2_m,y2_m`, one wall a line.
fn write_walls(path: &Path, walls: &[Wall]) -> Result<()> {
    io::atomic::write(path, |out: &mut dyn Write| {
        writeln!(out, "name,x1_m,y1_m,x2_m,y2_m")?;
        for wall in walls {
            let [p, q] = wall.segment.ends();
            writeln!(out, "{},{},{},{},{}", wall.name, p.x, p.y, q.x, q.y)?;
        }
        Ok(())
    })
}
