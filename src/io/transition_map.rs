//! The pedestrian map as files: `.json` for reading, `.npz` for numpy (docs/FORMATS-walks.md, field by field).

use std::path::Path;

use super::atomic;
use super::native::write_arrays;
use crate::error::{Error, Result};
use crate::pedestrian::TransitionMap;

/// The map as JSON: the grid, then one entry per crossed edge.
pub fn to_json(map: &TransitionMap) -> serde_json::Value {
    let edges: Vec<_> = map
        .edges()
        .map(
            |(cell, edge, count)| serde_json::json!({"q": cell.q, "r": cell.r, "edge": edge, "count": count}),
        )
        .collect();
    serde_json::json!({
        "hex_radius_m": map.grid.radius_m,
        "grid_angle_rad": map.grid.angle_rad,
        "origin_m": [map.grid.origin.x, map.grid.origin.y],
        "crossings": map.total(),
        "edges": edges,
    })
}

/// Writes [`to_json`].
///
/// # Errors
/// [`Error::Io`] if the file cannot be written.
pub fn write_json(path: &Path, map: &TransitionMap) -> Result<()> {
    let text = serde_json::to_string(&to_json(map)).map_err(|e| Error::Internal(e.to_string()))?;
    atomic::write(path, |out| writeln!(out, "{text}"))
}

/// Writes the map as numpy arrays `grid` (radius, angle, origin x, y), `edges` (q, r, edge) and `counts`.
///
/// # Errors
/// As [`write_json`].
pub fn write_npz(path: &Path, map: &TransitionMap) -> Result<()> {
    let g = &map.grid;
    let count = map.edges().count();
    let edges = map.edges().flat_map(|(cell, edge, _)| [i32::from(cell.q), i32::from(cell.r), edge as i32]);
    write_arrays(path, |arrays| {
        arrays.put("grid", &[4], [g.radius_m, g.angle_rad, g.origin.x, g.origin.y])?;
        arrays.put("edges", &[count, 3], edges)?;
        arrays.put("counts", &[count], map.edges().map(|(_, _, n)| n))
    })
}
