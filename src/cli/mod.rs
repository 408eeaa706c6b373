//! The edge: parses arguments, calls the library, prints, maps errors to exit codes. One file per subcommand.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hitl_slam::error::{Error, Result};

mod correct;
mod evaluate;
mod feetslam;
mod import;
mod info;
mod load;
mod picture;
mod render;
mod report;
mod simulate;

/// Repairs bent 2D lidar maps: draw two strokes, say how they relate, and the whole map follows.
#[derive(Parser)]
#[command(name = "hitl", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Info(info::Args),
    Import(import::Args),
    Correct(correct::Args),
    Evaluate(evaluate::Args),
    Render(render::Args),
    Simulate(simulate::Args),
    Feetslam(feetslam::Args),
}

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
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    match run(cli.command) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Err(error) => {
            eprintln!("hitl: {error}");
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
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Feetslam(args) => feetslam::run(&args),
    }
}
