//! Pictures of a correction: before, after, and both side by side; of a mere interpretation, the strokes on the map.

use std::path::Path;

use hitl_slam::error::Result;
use hitl_slam::geometry::Vec2;
use hitl_slam::map::SlamMap;
use hitl_slam::pipeline::CorrectionReport;
use hitl_slam::render::{self, Colour, MapPictureOptions, Overlay};

use crate::cli::picture;

/// Writes the pictures into a folder.
pub fn write(
    folder: &Path,
    before: &SlamMap,
    after: &SlamMap,
    reports: &[CorrectionReport],
    interpret_only: bool,
) -> Result<()> {
    let mut options = MapPictureOptions { title: Some("before".into()), ..Default::default() };
    if interpret_only {
        options.overlays = reports.iter().flat_map(overlays).collect();
    }
    picture::write(&folder.join("before.png"), &render::map(before, &options))?;
    if interpret_only {
        return Ok(());
    }
    let count = after.human_factors.len().saturating_sub(before.human_factors.len());
    options.title = Some(match count {
        1 => "after 1 correction".into(),
        n => format!("after {n} corrections"),
    });
    picture::write(&folder.join("after.png"), &render::map(after, &options))?;
    let both = render::before_after(before, after, &MapPictureOptions::default());
    picture::write(&folder.join("before-after.png"), &both)
}

/// Every stroke as drawn (black) and the wall it was taken for (red a, blue b), with its name.
fn overlays(report: &CorrectionReport) -> Vec<Overlay> {
    let mut overlays = Vec::new();
    for (stroke, colour) in report.strokes.iter().zip([Colour::RED, Colour::BLUE]) {
        let overlay = |ends: [Vec2; 2], label: String, colour| Overlay { ends, label, colour, width_px: 4.0 };
        overlays.push(overlay(stroke.drawn, format!("{} {}", report.id, stroke.name), Colour::INK));
        if let Some(caught) = &stroke.caught {
            overlays.push(overlay(caught.fit.segment.ends(), String::new(), colour));
        }
    }
    overlays
}
