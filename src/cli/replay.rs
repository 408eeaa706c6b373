//! `hitl replay`: a recorded session once more, without a browser.

use std::path::{Path, PathBuf};

use hitl_slam::error::Result;
use hitl_slam::io;
use hitl_slam::session::{self, Source};
use indicatif::{ProgressBar, ProgressStyle};

use super::{Outcome, load, out};

/// Run a session of `hitl serve` again: the very map that was last on screen.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The session (`session.jsonl` beside the map).
    session: PathBuf,

    /// Map to write; the extension picks the format, as for `hitl export`.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// Where the map of the session is, if no longer where the session's first line says.
    #[arg(long, value_name = "INPUT")]
    map: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    io::export::check(&args.output)?;
    let content = session::read(&args.session)?;
    load::remark(content.remark.as_slice());
    let folder = args.session.parent().unwrap_or(Path::new(""));
    let input = args.map.clone().unwrap_or_else(|| folder.join(&content.header.map));
    let source = Source::of(&input)?;
    source.check(&content.header, &args.session)?;
    let map = load::map(&input)?;
    let style = ProgressStyle::with_template("correcting {bar:30} {pos}/{len}");
    let bar = ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut progress = |done: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        true
    };
    let (solved, state) = session::replay(map, &source, &content, &args.session, &mut progress)?;
    bar.finish_and_clear();
    for report in solved.reports().filter(|r| r.enabled) {
        if let Some(reason) = &report.rejection {
            load::remark(&[format!("{} is not applied: {reason}", report.id)]);
        }
    }
    io::export::write(&args.output, &solved.map(), &io::export::Options::default())?;
    out::print(&format!(
        "{}: {} events, {} of {} corrections applied\n",
        args.output.display(),
        content.entries.len(),
        solved.reports().filter(|r| r.accepted()).count(),
        state.corrections.len()
    ))?;
    Ok(Outcome::Done)
}
