//! The scenarios: each is a world, a way through it, a laser, an error model and what a person would correct.

mod campus;
mod corridor_loop;
mod lost_poses;
mod office;

use std::fmt;
use std::str::FromStr;

use super::drift::Drift;
use super::lidar::Lidar;
use super::strokes::Drawing;
use super::world::World;
use crate::error::Error;
use crate::geometry::Pose2;
use crate::map::WallPair;

/// A simulated situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scenario {
    /// One lap of a ring of corridors and a bit more: 650 poses.
    Loop,
    /// Three buildings at angles to each other and the walkways between them: more than 3,000 poses.
    Campus,
    /// A room of 6.33 m and a laser that sees 1.5 m: 270 poses, most of them out of sight of any wall.
    LostPoses,
    /// One floor with two long corridors, severely bent: 650 poses.
    OfficeBent,
    /// The same floor, little bent, with one heading failure of 30° between two poses: 650 poses.
    OfficeKick,
}

/// Everything about a scenario that chance has no part in.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub world: World,
    /// `world_from_robot`, in driving order.
    pub truth: Vec<Pose2>,
    pub lidar: Lidar,
    pub drift: Drift,
    pub drawings: Vec<Drawing>,
    /// Rows of wall pieces in one line each, which a patient person makes straight as well.
    pub rows: Vec<String>,
    /// A failure of the odometry in one step.
    pub kick: Option<Kick>,
    /// The samples of Table 1.
    pub pairs: Vec<WallPair>,
}

/// A heading failure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kick {
    /// Index of the relative factor that is wrong.
    pub step: usize,
    /// By how much, radians.
    pub heading_rad: f64,
}

impl Scenario {
    /// All scenarios.
    pub const ALL: [Scenario; 5] =
        [Scenario::Loop, Scenario::Campus, Scenario::LostPoses, Scenario::OfficeBent, Scenario::OfficeKick];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Scenario::Loop => "loop",
            Scenario::Campus => "campus",
            Scenario::LostPoses => "lost-poses",
            Scenario::OfficeBent => "office-bent",
            Scenario::OfficeKick => "office-kick",
        }
    }

    pub(super) fn plan(self) -> Plan {
        match self {
            Scenario::Loop => corridor_loop::plan(),
            Scenario::Campus => campus::plan(),
            Scenario::LostPoses => lost_poses::plan(),
            Scenario::OfficeBent => office::bent(),
            Scenario::OfficeKick => office::kick(),
        }
    }
}

impl fmt::Display for Scenario {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Scenario {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        Scenario::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| {
            let names = Scenario::ALL.map(Scenario::name).join(", ");
            Error::input("scenario", format_args!("found \"{name}\", expected one of {names}"))
        })
    }
}
