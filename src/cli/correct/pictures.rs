//! Pictures of a correction: before, after, and both side by side; every stroke as drawn.

use std::path::Path;

use hitl_slam::error::Result;
use hitl_slam::map::SlamMap;
use hitl_slam::pipeline::CorrectionReport;
use hitl_slam::render::{self, MapPictureOptions};

use crate::cli::picture;

/// Writes the pictures into a folder.
pub fn write(
    folder: &Path,
    before: &SlamMap,
    after: &SlamMap,
    reports: &[CorrectionReport],
    interpret_only: bool,
) -> Result<()> {
    let strokes = reports.iter().flat_map(|r| r.strokes.iter());
    let _ = strokes;
    let options = |title: &str| MapPictureOptions { title: Some(title.to_owned()), ..Default::default() };
    picture::write(&folder.join("before.png"), &render::map(before, &options("before")))?;
    if interpret_only {
        return Ok(());
    }
    let title = format!("after {} corrections", after.human_factors.len());
    picture::write(&folder.join("after.png"), &render::map(after, &options(&title)))?;
    let both = render::before_after(before, after, &MapPictureOptions::default());
    picture::write(&folder.join("before-after.png"), &both)
}
