//! True walls and what to compare between them: Table 1 of Nashed & Biswas 2018.

use crate::geometry::Segment;

/// A straight piece of wall, named so that people and tests can speak of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unique in its world, such as `ring/south-outer/3`.
    pub name: String,
    /// Where it stands, world frame.
    pub segment: Segment,
}

/// What is compared between two walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// The angle between them.
    Angle,
    /// The distance across, of walls that are parallel.
    Distance,
}

impl Measure {
    /// Both, in the order of Table 1.
    pub const ALL: [Measure; 2] = [Measure::Angle, Measure::Distance];

    /// The name used in files.
    pub fn name(self) -> &'static str {
        match self {
            Measure::Angle => "angle",
            Measure::Distance => "distance",
        }
    }
}

/// One sample of Table 1: two named walls and what is measured between them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WallPair {
    /// Name of one wall.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// What is compared.
    pub measure: Measure,
}

impl WallPair {
    /// A pair.
    pub fn new(a: &str, b: &str, measure: Measure) -> Self {
        WallPair { a: a.into(), b: b.into(), measure }
    }
}
