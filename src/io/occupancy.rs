//! Occupancy grids for the ROS map server: a PGM raster and the YAML that says where it lies.
//!
//! Black (0) occupied, white (254) free, grey (205) unknown; the first row is the north edge. A cell is occupied if
//! at least [`OCCUPIED_SHARE`] of the rays that came to it ended there. The origin's yaw is always 0, since readers of
//! these files ignore it: whoever wants the map turned has it turned before it is drawn.

use std::path::{Path, PathBuf};

use super::atomic;
use super::text::Shortest;
use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2, walk_cells};
use crate::map::SlamMap;

/// Share of rays that must end in a cell to make it occupied.
pub const OCCUPIED_SHARE: f64 = 0.2;
/// Value of an occupied cell.
pub const OCCUPIED: u8 = 0;
/// Value of a cell nobody looked at.
pub const UNKNOWN: u8 = 205;
/// Value of a free cell.
pub const FREE: u8 = 254;
/// Unknown cells around the map.
const BORDER: f64 = 10.0;
const MOST_CELLS: f64 = 4e8;

/// A raster of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Occupancy {
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// Lower left corner, world frame after the turn.
    pub origin: Vec2,
    /// Cells in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// [`OCCUPIED`], [`FREE`] or [`UNKNOWN`]; the first row is the **southern**most.
    pub cells: Vec<u8>,
}

/// Draws a map turned by `yaw_rad` about the world's origin.
///
/// # Errors
/// [`Error::Input`] if the map has no points or is too large for cells of that size.
pub fn draw(map: &SlamMap, resolution_m: f64, yaw_rad: f64) -> Result<Occupancy> {
    if map.observations.is_empty() {
        return Err(Error::input("map: points", "found none, expected laser points to draw"));
    }
    let turn = Pose2::new(0.0, 0.0, yaw_rad);
    let (mut low, mut high) = (Vec2::repeat(f64::INFINITY), Vec2::repeat(f64::NEG_INFINITY));
    let mut rays = Vec::with_capacity(map.observations.len());
    for (i, &pose) in map.poses.iter().enumerate() {
        let pose = turn.compose(pose);
        let laser = pose.transform_point(map.robot_from_laser.translation());
        for k in map.observations.range(i) {
            let end = pose.transform_point(map.observations.point(k));
            (low, high) = (low.inf(&end).inf(&laser), high.sup(&end).sup(&laser));
            rays.push((laser, end));
        }
    }
    // On whole cells, so that the same wall falls on the same cells in two maps of one place.
    let first = (low / resolution_m).map(|v| v.floor() - BORDER);
    let size = (high / resolution_m).map(|v| v.floor() + 1.0 + BORDER) - first;
    let cells = size.x * size.y;
    if cells.is_nan() || cells > MOST_CELLS {
        let message = format_args!(
            "found {:.0} × {:.0} cells, expected fewer: try a coarser resolution",
            size.x, size.y
        );
        return Err(Error::input("map: extent", message));
    }
    let (columns, rows) = (size.x as usize, size.y as usize);
    let (mut ended, mut passed) = (vec![0_u32; columns * rows], vec![0_u32; columns * rows]);
    for (laser, end) in rays {
        let [from, to] = [laser, end].map(|p| p / resolution_m - first);
        let last = [to.x as usize, to.y as usize];
        ended[last[1] * columns + last[0]] += 1;
        let way = to - from;
        if way.norm() > 0.0 {
            walk_cells(from, way.normalize(), way.norm(), |column, row| {
                if column < columns && row < rows && [column, row] != last {
                    passed[row * columns + column] += 1;
                }
            });
        }
    }
    let value = |(&ended, &passed): (&u32, &u32)| match (ended, passed) {
        (0, 0) => UNKNOWN,
        (e, p) if f64::from(e) >= OCCUPIED_SHARE * (f64::from(e) + f64::from(p)) => OCCUPIED,
        _ => FREE,
    };
    let cells = ended.iter().zip(&passed).map(value).collect();
    let origin = (first * resolution_m).map(|v| (v * 1e9).round() / 1e9);
    Ok(Occupancy { resolution_m, origin, columns, rows, cells })
}

/// The YAML that goes with a raster.
pub fn yaml_path(path: &Path) -> PathBuf {
    path.with_extension("yaml")
}

/// Writes the raster to `path` and the YAML beside it.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written.
pub fn write(path: &Path, grid: &Occupancy) -> Result<()> {
    atomic::write(path, |out| {
        write!(out, "P5\n{} {}\n255\n", grid.columns, grid.rows)?;
        grid.cells.chunks(grid.columns).rev().try_for_each(|row| out.write_all(row))
    })?;
    let image = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    atomic::write(&yaml_path(path), |out| {
        let [resolution, x, y] = [grid.resolution_m, grid.origin.x, grid.origin.y].map(Shortest);
        writeln!(out, "image: {image}\nmode: trinary\nresolution: {resolution}\norigin: [{x}, {y}, 0.0]")?;
        writeln!(out, "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196")
    })
}
