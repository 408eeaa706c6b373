//! `hitl feetslam`: maps from pedestrians' steps.

use clap::Subcommand;
use hitl_slam::error::Result;

use super::Outcome;

mod live;
mod options;
mod output;
mod pdr;
mod pictures;
mod report;
mod run;
mod simulate;

/// Pedestrian mapping: FootSLAM, FeetSLAM and successive collaborative mapping.
///
/// FootSLAM is covered by a patent (US 8,626,443 B2, DLR; listed active until 20 September 2030): check before
/// commercial use.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
#[allow(clippy::large_enum_variant)] // one value per run of the program
enum Command {
    Live(live::Args),
    Pdr(pdr::Args),
    Run(run::Args),
    Simulate(simulate::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of the subcommand.
pub fn run(args: &Args) -> Result<Outcome> {
    match &args.command {
        Command::Live(args) => live::run(args),
        Command::Pdr(args) => pdr::run(args),
        Command::Run(args) => run::run(args),
        Command::Simulate(args) => simulate::run(args),
    }
}
