//! What a person says: two strokes and how they relate (Definition 1 of Nashed & Biswas 2018, before interpretation).

use crate::geometry::Vec2;

/// How two features relate; the paper's modes M.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Same place, same direction (full rank).
    Colocation,
    /// On one line; free along it.
    Collinear,
    /// At a right angle; free in position.
    Perpendicular,
    /// Same direction; free in position.
    Parallel,
}

impl Mode {
    /// All modes, in the order of the file formats' codes 0..=3.
    pub const ALL: [Mode; 4] = [Mode::Colocation, Mode::Collinear, Mode::Perpendicular, Mode::Parallel];

    /// The name used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Colocation => "colocation",
            Mode::Collinear => "collinear",
            Mode::Perpendicular => "perpendicular",
            Mode::Parallel => "parallel",
        }
    }
}

/// A drawn line segment: its two end points, in metres, in one of three frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stroke {
    /// World frame of the map as it stands when the correction is applied.
    World([Vec2; 2]),
    /// Robot frame of a pose of the graph.
    Pose {
        /// Index of the pose.
        pose: usize,
        /// End points, robot frame.
        points: [Vec2; 2],
    },
    /// Robot frame at the scan with this stamp; between scans interpolated along the chain.
    Stamp {
        /// Seconds, the log's clock.
        stamp_s: f64,
        /// End points, robot frame.
        points: [Vec2; 2],
    },
}

/// One user input.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// Name used in reports; unique in a file.
    pub id: String,
    /// How `a` and `b` relate.
    pub mode: Mode,
    /// One stroke; which of the two comes first makes no difference.
    pub a: Stroke,
    /// The other stroke.
    pub b: Stroke,
    /// Multiplies the factor's cost; > 0.
    pub weight: f64,
    /// Disabled corrections are listed in the report and otherwise skipped.
    pub enabled: bool,
}
