//! Writes corrections as JSON Lines: one a line, in the order in which they are applied.
//!
//! `{"mode": …, "a": STROKE, "b": STROKE, "weight": …, "id": …, "enabled": …}`; a STROKE is `[[x, y], [x, y]]` in the
//! world frame, or `{"pose": i, "points": …}` or `{"stamp": t, "points": …}` in the robot frame. Numbers are shortest
//! round-trip.

use std::path::Path;

use serde_json::{Value, json};

use super::atomic;
use crate::error::Result;
use crate::geometry::Vec2;
use crate::map::{Correction, Stroke};

/// Writes `corrections` to `path`.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, corrections: &[Correction]) -> Result<()> {
    atomic::write(path, |out| corrections.iter().try_for_each(|c| writeln!(out, "{}", to_json_line(c))))
}

/// One correction as one line of JSON, without the line's end.
pub fn to_json_line(correction: &Correction) -> String {
    json!({
        "mode": correction.mode.name(),
        "a": stroke(&correction.a),
        "b": stroke(&correction.b),
        "weight": correction.weight,
        "id": correction.id,
        "enabled": correction.enabled,
    })
    .to_string()
}

fn stroke(stroke: &Stroke) -> Value {
    let coordinates = |points: &[Vec2; 2]| points.map(|p| [p.x, p.y]);
    match stroke {
        Stroke::World(points) => json!(coordinates(points)),
        Stroke::Pose { pose, points } => json!({ "pose": pose, "points": coordinates(points) }),
        Stroke::Stamp { stamp_s, points } => json!({ "stamp": stamp_s, "points": coordinates(points) }),
    }
}
