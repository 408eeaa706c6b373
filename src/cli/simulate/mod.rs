//! `hitl simulate`: a world, a robot's run through it, its truth and a simulated person's strokes.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::map::Trajectory;
use hitl_slam::simulate::{self, Scenario, Settings};

mod damage;
mod person;
mod plan;

use super::{Outcome, out};

/// Simulate a robot's run: a bent map, its truth, and the corrections a person would draw on it.
///
/// Writes into DIR: map.npz (the map as the drifting odometry makes it), truth.tum (the true poses),
/// corrections.jsonl (what a person would draw; input of `hitl correct`), walls.csv (the world) and pairs.csv (which walls
/// `hitl evaluate --walls` compares).
/// The same options always write the same files.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true
)]
#[command(
    subcommand_help_heading = "Real data, buildings, people",
    subcommand_value_name = "damage|person|plan"
)]
pub struct Args {
    #[command(subcommand)]
    other: Option<Other>,
    #[command(flatten)]
    run: Option<RunArgs>,
}

#[derive(clap::Subcommand)]
enum Other {
    Damage(damage::Args),
    Person(person::Args),
    Plan(plan::Args),
}

/// A scenario's run.
#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
struct RunArgs {
    /// loop: one lap of a ring of corridors, 650 poses. campus: three buildings, 3,100 poses.
    /// lost-poses: a room whose walls the laser sees only from 1.5 m. office-bent: two long corridors, severely bent.
    /// office-kick: the same, 30° of heading lost in one step
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
    /// The person goes on after the scenario's own corrections and draws every corridor straight
    #[arg(long)]
    thorough: bool,
}

/// Runs the command.
///
/// # Errors
/// Settings that make no sense, or files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    match (&args.other, &args.run) {
        (Some(Other::Damage(args)), _) => damage::run(args),
        (Some(Other::Person(args)), _) => person::run(args),
        (Some(Other::Plan(args)), _) => plan::run(args),
        (None, Some(args)) => scenario(args),
        (None, None) => Err(Error::input("<SCENARIO>", "found nothing, expected the name of a scenario")),
    }
}

fn scenario(args: &RunArgs) -> Result<Outcome> {
    let scenario: Scenario = args.scenario.parse()?;
    let settings = Settings {
        seed: args.seed,
        drift: args.drift,
        range_noise_m: args.range_noise_m,
        drawing_noise_m: args.drawing_noise_m,
        thorough: args.thorough,
    };
    io::check_map_path(&args.output.join("map.npz"))?;
    let simulation = simulate::run(scenario, &settings)?;
    let truth = Trajectory { poses: simulation.truth, ..simulation.map.trajectory() };

    let folder = &args.output;
    io::write_map(&folder.join("map.npz"), &simulation.map)?;
    io::tum::write(&folder.join("truth.tum"), &truth)?;
    io::corrections::write(&folder.join("corrections.jsonl"), &simulation.corrections)?;
    io::walls::write(&folder.join("walls.csv"), &simulation.walls)?;
    io::walls::write_pairs(&folder.join("pairs.csv"), &simulation.pairs)?;
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
