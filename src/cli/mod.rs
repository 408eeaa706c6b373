//! The edge: parses arguments, calls the library, prints, maps errors to exit codes. One file per subcommand.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hitl_slam::error::{Error, Result};

mod correct;
mod crosscheck;
mod evaluate;
mod export;
mod feetslam;
mod import;
mod inconsistency;
mod info;
mod load;
mod loss;
mod optimize;
mod options;
mod out;
mod outliers;
mod picture;
mod reassociate;
mod render;
mod replay;
mod report;
#[cfg(feature = "serve")]
mod serve;
mod simulate;
mod suggest;
mod tunables;
mod usage;

/// `--version`: the program's, and what it can solve with.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\nback ends: ", env!("HITL_BACK_ENDS"));

/// Repairs bent 2D lidar maps: draw two strokes, say how they relate, and the whole map follows.
#[derive(Parser)]
#[command(name = "hitl", version = VERSION, max_term_width = 100, after_help = FIRST_STEPS)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Info(info::Args),
    Import(import::Args),
    Correct(correct::Args),
    Crosscheck(crosscheck::Args),
    Optimize(optimize::Args),
    Evaluate(evaluate::Args),
    Inconsistency(inconsistency::Args),
    Render(render::Args),
    Export(export::Args),
    #[cfg(feature = "serve")]
    Serve(serve::Args),
    Replay(replay::Args),
    Suggest(suggest::Args),
    Simulate(simulate::Args),
    Feetslam(feetslam::Args),
}

const FIRST_STEPS: &str = "\
First steps: `hitl serve` opens the interactive tool in the browser. Or, on a simulated robot's run:
  hitl simulate loop -o run
  hitl correct run/map.npz -c run/corrections.jsonl -o run/corrected.npz
  hitl evaluate run/corrected.npz --truth run/truth.tum
  hitl render run/corrected.npz --before run/map.npz -o run/both.png

Exit codes: 0 done, 1 a check failed (correct --strict), 2 bad usage or input, 3 an internal error.
Metres, radians and seconds everywhere.";

/// How a job ended that did not fail.
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// The job ran and its check failed: exit code 1.
    CheckFailed,
}

/// Runs the command line.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage::answer(&error),
    };
    match run(cli.command) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Err(error) => {
            out::complain(&error);
            ExitCode::from(match error {
                Error::Internal(_) => 3,
                _ => 2,
            })
        }
    }
}

fn run(command: Command) -> Result<Outcome> {
    match command {
        Command::Info(args) => info::run(&args),
        Command::Import(args) => import::run(&args),
        Command::Correct(args) => correct::run(&args),
        Command::Crosscheck(args) => crosscheck::run(&args),
        Command::Optimize(args) => optimize::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Inconsistency(args) => inconsistency::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Export(args) => export::run(&args),
        #[cfg(feature = "serve")]
        Command::Serve(args) => serve::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Suggest(args) => suggest::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Feetslam(args) => feetslam::run(&args),
    }
}
