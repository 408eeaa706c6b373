//! A map for other people's tools: every format that can be written, by the extension of the file.

use std::path::Path;

use super::{atomic, carmen_log, occupancy, ply, walks_of_map};
use crate::error::{Error, Result};
use crate::map::{RawLog, SlamMap};

/// What some formats need to be told.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// `.pgm`: side of a cell, metres.
    pub resolution_m: f64,
    /// `.pgm`: the map is turned by this before it is drawn.
    pub yaw_rad: f64,
    /// `.clf`, `.log`: the log that the map was made from; without it the beams are put together from the points.
    pub log: Option<&'a RawLog>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options { resolution_m: 0.05, yaw_rad: 0.0, log: None }
    }
}

/// The extension of a file, in small letters.
pub fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// Checks, before any work is done for it, that a map can be exported under this name.
///
/// # Errors
/// [`Error::Input`] if the extension is unknown; else as [`atomic::check`].
pub fn check(path: &Path) -> Result<()> {
    match extension(path).as_str() {
        "clf" | "log" | "ply" | "csv" => atomic::check(path),
        "pgm" => {
            atomic::check(path)?;
            atomic::check(&occupancy::yaml_path(path))
        }
        "npz" | "g2o" | "covars" | "stfs" | "tum" | "txt" | "graph" | "toro" => super::check_map_path(path),
        _ => {
            let message = "found no known extension, expected .npz, .g2o, .stfs.covars, .tum, .txt, .clf, .log, .csv, .ply or .pgm";
            Err(Error::input(path.display(), message))
        }
    }
}

/// Writes a map; `.pgm` writes its `.yaml`, too.
///
/// # Errors
/// [`Error::Input`] if the extension is unknown or the format cannot hold the map; [`Error::Io`].
pub fn write(path: &Path, map: &SlamMap, options: &Options<'_>) -> Result<()> {
    match extension(path).as_str() {
        "clf" | "log" => {
            let log = match options.log {
                Some(log) => carmen_log::corrected(log, &map.trajectory())?,
                None => carmen_log::of_map(map),
            };
            carmen_log::write(path, &log)
        }
        "csv" => walks_of_map::write(path, map, &[]).map(drop),
        "ply" => ply::write(path, map),
        "pgm" => occupancy::write(path, &occupancy::draw(map, options.resolution_m, options.yaw_rad)?),
        _ => super::write_map(path, map),
    }
}
