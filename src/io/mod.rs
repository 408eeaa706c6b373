//! Reading and writing: one file per format. What a file is, is told from its content.

pub mod atomic;
pub mod carmen;
pub mod carmen_log;
pub mod corrections;
pub mod detect;
pub mod export;
pub mod floor_plan;
pub mod g2o;
mod ids;
pub mod imu;
pub mod journal;
pub mod lock;
pub mod native;
pub mod occupancy;
pub mod paths;
pub mod ply;
mod pose_graph;
pub mod relations;
mod source;
pub mod step_lines;
pub mod stfs;
mod text;
pub mod toro;
pub mod transition_map;
pub mod tum;
pub mod walk;
pub mod walks_of_map;
pub mod walls;

use std::path::Path;

use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::{RawLog, SlamMap, Trajectory};
use crate::pedestrian::Walk;
pub use detect::Format;

/// What a reader returns: the content, and remarks that a person should see.
#[derive(Debug, Clone, PartialEq)]
pub struct Read<T> {
    /// What was read.
    pub value: T,
    /// Remarks such as skipped tags, each with its place.
    pub warnings: Vec<String>,
}

impl<T> Read<T> {
    fn map<U>(self, convert: impl FnOnce(T) -> U) -> Read<U> {
        Read { value: convert(self.value), warnings: self.warnings }
    }
}

/// What a reader of pose graphs does about an information matrix that is not positive definite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Indefinite {
    /// An error on its line: no measurement has such a matrix.
    #[default]
    Refuse,
    /// Takes [`crate::geometry::Information::nearest`], and remarks on it once.
    Repair,
}

/// What an input file holds.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
// One value per file: its size on the stack does not matter.
#[allow(clippy::large_enum_variant)]
pub enum Source {
    /// A recording, before any pose graph: give it to [`crate::front_end`].
    Log(RawLog),
    /// A map or a pose graph (which is a map without points).
    Map(SlamMap),
    /// Stamped poses only.
    Trajectory(Trajectory),
    /// Pedestrians' steps: give them to [`crate::front_end`].
    Walks {
        /// The walks.
        walks: Vec<Walk>,
        /// Where each begins; empty where the file does not say.
        starts: Vec<Pose2>,
    },
}

/// Reads any input file, and says which format it was.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Input`] with the line or field if it is not as it should be.
pub fn read(path: &Path) -> Result<(Format, Read<Source>)> {
    read_with(path, Indefinite::Refuse)
}

/// The same, with a choice of what happens to a pose graph's information that is not positive definite.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, indefinite: Indefinite) -> Result<(Format, Read<Source>)> {
    let format = detect::format(path)?;
    let read = match format {
        Format::Carmen => carmen::read(path)?.map(Source::Log),
        Format::G2o => g2o::read_with(path, indefinite)?.map(Source::Map),
        Format::Stfs => stfs::read(path)?.map(Source::Map),
        Format::Tum => tum::read(path)?.map(Source::Trajectory),
        Format::Walk => walk::read(path)?.map(|walk| Source::Walks { walks: vec![walk], starts: Vec::new() }),
        Format::Paths => paths::read(path)?.map(|(walks, starts)| Source::Walks { walks, starts }),
        Format::Native => native::read(path)?.map(Source::Map),
        Format::Toro => toro::read_with(path, indefinite)?.map(Source::Map),
    };
    Ok((format, read))
}

/// What a map can be written as.
#[derive(Clone, Copy)]
enum MapFormat {
    Native,
    G2o,
    Toro,
    Stfs,
    Tum,
}

fn map_format(path: &Path) -> Result<MapFormat> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("npz") => Ok(MapFormat::Native),
        Some("g2o") => Ok(MapFormat::G2o),
        Some("graph" | "toro") => Ok(MapFormat::Toro),
        Some("covars" | "stfs") => Ok(MapFormat::Stfs),
        Some("tum" | "txt") => Ok(MapFormat::Tum),
        _ => {
            let message =
                "found no known extension, expected .npz, .g2o, .graph, .toro, .stfs.covars, .tum or .txt";
            Err(Error::input(path.display(), message))
        }
    }
}

/// Checks, before any work is done for it, that a map can be written under this name.
///
/// # Errors
/// [`Error::Input`] if the extension is unknown; else as [`atomic::check`].
pub fn check_map_path(path: &Path) -> Result<()> {
    map_format(path)?;
    atomic::check(path)
}

/// Writes a map in the format of the extension: `.npz` everything, `.g2o` the graph, `.graph` or `.toro` the graph
/// without its held poses, `.stfs.covars` chain and points, `.tum` or `.txt` the trajectory of every scan.
///
/// # Errors
/// [`Error::Input`] if the extension is unknown; or if the format cannot hold the map or the file cannot be written.
pub fn write_map(path: &Path, map: &SlamMap) -> Result<()> {
    match map_format(path)? {
        MapFormat::Native => native::write(path, map),
        MapFormat::G2o => g2o::write(path, map),
        MapFormat::Toro => toro::write(path, map),
        MapFormat::Stfs => stfs::write(path, map),
        MapFormat::Tum => tum::write(path, &map.trajectory()),
    }
}
