//! TORO pose graphs, 2D part (docs/FORMATS.md, "TORO").
//!
//! ```text
//! VERTEX2 id x y theta
//! EDGE2 id_i id_j forward sideward rotate  ff fs ss rr fr sr      (pose j seen from pose i)
//! ```
//! Metres, radians. The information has the axes of g2o in another order: xx, xy, yy, θθ, xθ, yθ.

use std::path::Path;

use super::pose_graph::{self, Dialect};
use super::{Indefinite, Read};
use crate::error::Result;
use crate::map::SlamMap;

const TORO: Dialect = Dialect {
    vertex: "VERTEX2",
    edge: "EDGE2",
    numbers: ["forward", "sideward", "rotate", "ff", "fs", "ss", "rr", "fr", "sr"],
    places: [(0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2)],
    extended: false,
};

/// Reads a graph. The result has no points.
///
/// # Errors
/// As [`super::g2o::read`].
pub fn read(path: &Path) -> Result<Read<SlamMap>> {
    read_with(path, Indefinite::Refuse)
}

/// The same, with a choice of what happens to information that is not positive definite.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, indefinite: Indefinite) -> Result<Read<SlamMap>> {
    pose_graph::read(path, &TORO, indefinite)
}

/// Writes the poses and relative factors of a map. TORO cannot say which poses are held.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, map: &SlamMap) -> Result<()> {
    pose_graph::write(path, map, &TORO)
}
