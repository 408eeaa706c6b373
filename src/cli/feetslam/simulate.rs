//! `hitl feetslam simulate`: walks with truth.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::simulate::walkers::{Scenario, Settings};

use crate::cli::Outcome;

/// Simulate walkers: their steps as a drifting dead reckoning has them, and where they truly were.
///
/// Writes into DIR: w1.csv, w2.csv, … (the walks), truth.csv, walls.csv, and start.txt (the argument of
/// `hitl feetslam run --start`; in `building` and `office` every walker starts elsewhere: one line each). The same options always write
/// the same files.
#[derive(clap::Args)]
pub struct Args {
    /// six: the paper's six walkers. opposite, one-sided, corner, curve: its controls. rooms: some enter a room. loops: laps of a ring. building: between places of a building (needs --plan). office: the same in a building made of the seed
    #[arg(value_parser = PossibleValuesParser::new(Scenario::ALL.map(Scenario::name)))]
    scenario: String,
    /// Decides all that is left to chance
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Folder for the files; made if missing
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of walkers; the scenario's own number if absent
    #[arg(long, value_name = "N", default_value_t = 0)]
    walkers: usize,
    /// Length of a walk in loops, building and office
    #[arg(long, value_name = "MIN", default_value_t = Settings::default().minutes)]
    minutes: f64,
    /// Factor on all errors of the dead reckoning
    #[arg(long, value_name = "F", default_value_t = Settings::default().drift)]
    drift: f64,
    /// Turns the whole world
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    turn_deg: f64,
    /// corner: the corridor's bend to the left
    #[arg(long, value_name = "DEG", default_value_t = Settings::default().bend_deg, allow_negative_numbers = true)]
    bend_deg: f64,
    /// corner: metres of corridor before the bend
    #[arg(long, value_name = "M", default_value_t = Settings::default().bend_at_m)]
    bend_at_m: f64,
    /// curve: radius, negative to the right
    #[arg(long, value_name = "M", default_value_t = Settings::default().radius_m, allow_negative_numbers = true)]
    radius_m: f64,
    /// building, office: walkers who stay where nobody else goes
    #[arg(long, value_name = "N", default_value_t = 0)]
    strangers: usize,
    /// building, office: walkers, before the strangers, who go with the others for half of the time and like the strangers for the other half
    #[arg(long, value_name = "N", default_value_t = 0)]
    half_strangers: usize,
    /// building: its walls, `x1, y1, x2, y2` a line
    #[arg(long, value_name = "WALLS")]
    plan: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Settings that make no sense, a plan that cannot be read, or files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    let scenario: Scenario = args.scenario.parse()?;
    let settings = Settings {
        seed: args.seed,
        walkers: args.walkers,
        minutes: args.minutes,
        drift: args.drift,
        turn_deg: args.turn_deg,
        bend_deg: args.bend_deg,
        bend_at_m: args.bend_at_m,
        radius_m: args.radius_m,
        strangers: args.strangers,
        half_strangers: args.half_strangers,
    };
    let walls = match &args.plan {
        Some(path) => io::floor_plan::read(path)?.value,
        None if scenario == Scenario::Building => {
            return Err(Error::input("--plan", "found none, expected the walls of the building"));
        }
        None => Vec::new(),
    };
    let simulation = scenario.run(&settings, &walls)?;
    let folder = &args.output;
    for walk in &simulation.walks {
        io::walk::write(&folder.join(format!("{}.csv", walk.name)), walk)?;
    }
    io::walk::write_truth(&folder.join("truth.csv"), &simulation.truth)?;
    io::floor_plan::write(&folder.join("walls.csv"), &simulation.walls)?;
    let mut starts: Vec<String> = simulation
        .starts
        .iter()
        .map(|s| format!("{},{},{}\n", s.x_m, s.y_m, s.theta_rad.to_degrees()))
        .collect();
    if starts.iter().all(|s| *s == starts[0]) {
        starts.truncate(1);
    }
    io::atomic::write(&folder.join("start.txt"), |out| out.write_all(starts.concat().as_bytes()))?;
    let steps: usize = simulation.walks.iter().map(|w| w.steps.len()).sum();
    println!(
        "{scenario}, seed {}: {} walkers, {steps} steps, start {} → {}",
        settings.seed,
        simulation.walks.len(),
        starts[0].trim_end(),
        folder.display()
    );
    Ok(Outcome::Done)
}
