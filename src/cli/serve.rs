//! `hitl serve`: the interactive tool in the browser.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use hitl_slam::error::Result;
use hitl_slam::serve::{self, Options};

use super::{Outcome, load, out};

/// Correct a map by hand, in the browser.
///
/// Draw a stroke on a wall, one on the wall it belongs to, and the map follows. Everything you do is written to
/// `session.jsonl` beside the map as you do it: start again and it is there; `hitl replay` repeats it. Without a map
/// a first page takes a file, or opens a demo. Only this computer can reach the page. Ctrl-C ends it.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Native map, any file that `hitl import` reads, or a folder of `hitl feetslam`.
    input: Option<PathBuf>,

    /// The session to go on with or to begin [default: session.jsonl beside the map].
    #[arg(long, value_name = "S.jsonl", requires = "input")]
    session: Option<PathBuf>,

    /// Do not open the browser.
    #[arg(long)]
    no_open: bool,

    /// Port on 127.0.0.1; 0: any free one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,

    /// Folder for maps that are dropped on the page, and for the demo.
    #[arg(long, value_name = "DIR", default_value = "hitl-maps")]
    folder: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Outcome> {
    let options = Options {
        input: args.input.clone(),
        session: args.session.clone(),
        folder: args.folder.clone(),
        port: args.port,
    };
    let server = serve::Server::start(&options)?;
    out::print(&format!("{}\n", server.address()))?;
    if !args.no_open {
        open(server.address());
    }
    load::remark(&["Ctrl-C ends it; everything you do is saved as you do it".into()]);
    server.wait()?;
    Ok(Outcome::Done)
}

/// The browser, if there is one: the address is on the terminal anyway.
fn open(address: &str) {
    let opener = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let mut command = Command::new(opener);
    let _ = command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
}
