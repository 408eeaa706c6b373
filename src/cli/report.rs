//! Machine-readable reports: JSON to a file, or to stdout where the path is `-`.

use std::path::Path;

use hitl_slam::error::{Error, Result};
use hitl_slam::io;

/// Writes `report` where the user asked for it, if anywhere.
pub fn write(path: Option<&Path>, report: &impl serde::Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let mut text = serde_json::to_string_pretty(report).map_err(|e| Error::Internal(e.to_string()))?;
    text.push('\n');
    if path == Path::new("-") {
        print!("{text}");
        return Ok(());
    }
    io::atomic::write(path, |out| out.write_all(text.as_bytes()))
}
