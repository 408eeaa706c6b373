//! Writes pictures: the extension says whether as PNG or as SVG.

use std::path::Path;

use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::render::Picture;

/// A file format for pictures.
#[derive(Clone, Copy)]
enum Format {
    Png,
    Svg,
}

/// Checks that `path` names a picture that can be written, before any work is done for it.
///
/// # Errors
/// If its extension is neither `.png` nor `.svg`, or its folder cannot be written to.
pub fn check(path: &Path) -> Result<()> {
    format(path)?;
    io::atomic::check(path)
}

/// Writes `picture` to `path`.
///
/// # Errors
/// As [`check`]; or if the file cannot be written.
pub fn write(path: &Path, picture: &Picture) -> Result<()> {
    let bytes = match format(path)? {
        Format::Png => picture.to_png(),
        Format::Svg => picture.to_svg().into_bytes(),
    };
    io::atomic::write(path, |out| out.write_all(&bytes))
}

fn format(path: &Path) -> Result<Format> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "png" => Ok(Format::Png),
        "svg" => Ok(Format::Svg),
        other => {
            let found = if other.is_empty() { "no extension".into() } else { format!(".{other}") };
            Err(Error::input(path.display(), format_args!("found {found}, expected .png or .svg")))
        }
    }
}
