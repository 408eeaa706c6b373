//! g2o pose graphs, 2D part (docs/FORMATS.md, "g2o").
//!
//! ```text
//! VERTEX_SE2 id x y theta
//! FIX id …
//! EDGE_SE2 id_i id_j x y theta  xx xy xt yy yt tt      (pose j seen from pose i; upper triangle of Ω)
//! ROBOTLASER1 …                                        (after a vertex: only its stamp is used)
//! ```
//! Metres, radians.

use std::path::Path;

use super::pose_graph::{self, Dialect};
use super::{Indefinite, Read};
use crate::error::Result;
use crate::map::SlamMap;

const G2O: Dialect = Dialect {
    vertex: "VERTEX_SE2",
    edge: "EDGE_SE2",
    numbers: ["x", "y", "theta", "xx", "xy", "xt", "yy", "yt", "tt"],
    places: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)],
    extended: true,
};

/// Reads a graph. The result has no points.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line: cut-off or garbled lines, duplicate or unknown ids, numbers that are
/// not finite, information that is not positive definite.
pub fn read(path: &Path) -> Result<Read<SlamMap>> {
    read_with(path, Indefinite::Refuse)
}

/// The same, with a choice of what happens to information that is not positive definite.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, indefinite: Indefinite) -> Result<Read<SlamMap>> {
    pose_graph::read(path, &G2O, indefinite)
}

/// Writes the poses, held poses, relative and automatic factors of a map.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, map: &SlamMap) -> Result<()> {
    pose_graph::write(path, map, &G2O)
}
