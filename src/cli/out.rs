//! The standard streams. A reader that goes away (`hitl info MAP | head -1`) is no failure of ours, and no panic.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use hitl_slam::error::{Error, Result};

/// Prints to stdout.
///
/// # Errors
/// If it cannot be written for another reason than that nobody reads it.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::io(Path::new("standard output"), e)),
        _ => Ok(()),
    }
}

/// Prints one line to stderr, under the name of the program. Where stderr is closed there is nobody to tell.
pub fn complain(message: impl Display) {
    let line = message.to_string().replace('\n', " ");
    let _ = writeln!(io::stderr(), "hitl: {line}");
}
