//! Simulated walkers with truth: the paper's corridor and its controls, loops, and buildings with many walkers.
//!
//! A scenario gives each walker a [`Route`] and a drift; [`gait`] turns both into a walk. All chance comes from keys
//! (seed, walker), so one walker more leaves the others as they were.

mod building;
mod corridor;
pub mod gait;
mod loops;
mod office;

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};
use crate::geometry::{Pose2, Segment, Vec2};
use crate::pedestrian::random::Key;
use crate::pedestrian::{TruthPoint, Walk};

/// A way through the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// Corners, at least two, no two consecutive ones alike.
    pub points: Vec<Vec2>,
    /// Indices of corners where the walker stands for some seconds.
    pub marked: Vec<usize>,
}

impl Route {
    /// The start: at the first corner, looking at the second.
    pub fn start(&self) -> Pose2 {
        let d = self.points[1] - self.points[0];
        Pose2::new(self.points[0].x, self.points[0].y, d.y.atan2(d.x))
    }

    /// The route in a world turned and moved by `motion`.
    fn moved(mut self, motion: Pose2) -> Route {
        self.points.iter_mut().for_each(|p| *p = motion.transform_point(*p));
        self
    }
}

/// A simulated situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Scenario {
    /// The paper's six walkers: 4 m, a turn, 38 m of corridor; drifts mostly to one side.
    Six,
    /// The same with drifts that cancel: ±3, ±2, ±1 m.
    Opposite,
    /// The same with +3 m for all.
    OneSided,
    /// The same, the corridor bent by `bend_deg` after `bend_at_m` metres.
    Corner,
    /// The same, the corridor an arc of `radius_m`.
    Curve,
    /// The same; every second walker enters a room on the way.
    Rooms,
    /// Laps of a ring of corridors and its cross passage, for `minutes`.
    Loops,
    /// Walks between random places of a building given by its walls, for `minutes`.
    Building,
    /// The same in a building made of the seed.
    Office,
}

/// Numbers of a scenario; each uses those it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The same seed and settings give the same walks, to the byte.
    pub seed: u64,
    /// Walkers; 0: as many as the scenario has by itself.
    pub walkers: usize,
    /// Length of a walk in `loops`, `building` and `office`, minutes.
    pub minutes: f64,
    /// Factor on all errors of the dead reckoning.
    pub drift: f64,
    /// The whole world is turned by this, degrees.
    pub turn_deg: f64,
    /// `corner`: the bend, degrees, to the left.
    pub bend_deg: f64,
    /// `corner`: metres of corridor before the bend.
    pub bend_at_m: f64,
    /// `curve`: radius, metres; negative: to the right.
    pub radius_m: f64,
    /// `building`, `office`: how many of the walkers, the last ones, stay in a part of it where nobody else goes.
    pub strangers: usize,
    /// `building`, `office`: how many of those before the strangers go with the others for one half of the time, and for the other half where the strangers go.
    pub half_strangers: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            seed: 1,
            walkers: 0,
            minutes: 10.0,
            drift: 1.0,
            turn_deg: 0.0,
            bend_deg: 90.0,
            bend_at_m: 20.0,
            radius_m: 100.0,
            strangers: 0,
            half_strangers: 0,
        }
    }
}

/// What a scenario makes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Simulation {
    /// The walks.
    pub walks: Vec<Walk>,
    /// True positions, per walker in time order.
    pub truth: Vec<TruthPoint>,
    /// True start of each walker; the same for all but in `building` and `office`.
    pub starts: Vec<Pose2>,
    /// The walls.
    pub walls: Vec<Segment>,
}

impl Scenario {
    /// All scenarios.
    pub const ALL: [Scenario; 9] = [
        Scenario::Six,
        Scenario::Opposite,
        Scenario::OneSided,
        Scenario::Corner,
        Scenario::Curve,
        Scenario::Rooms,
        Scenario::Loops,
        Scenario::Building,
        Scenario::Office,
    ];

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Scenario::Six => "six",
            Scenario::Opposite => "opposite",
            Scenario::OneSided => "one-sided",
            Scenario::Corner => "corner",
            Scenario::Curve => "curve",
            Scenario::Rooms => "rooms",
            Scenario::Loops => "loops",
            Scenario::Building => "building",
            Scenario::Office => "office",
        }
    }

    /// Simulates; `walls` are those of a building and only used there.
    ///
    /// # Errors
    /// [`Error::Input`] for settings out of range, or a building in which nobody can walk.
    pub fn run(self, settings: &Settings, walls: &[Segment]) -> Result<Simulation> {
        settings.validate()?;
        let key = Key::new(settings.seed).named("walkers");
        let turn = Pose2::new(0.0, 0.0, settings.turn_deg.to_radians());
        let plan = match self {
            Scenario::Loops => loops::plan(settings, key),
            Scenario::Building => building::plan(settings, walls, key)?,
            Scenario::Office => building::plan(settings, &office::walls(key.named("office")), key)?,
            _ => corridor::plan(self, settings, key),
        };
        let mut simulation = Simulation {
            walls: plan.walls.iter().map(|wall| wall.transformed(turn)).collect(),
            ..Simulation::default()
        };
        for (k, (route, drift)) in plan.walkers.into_iter().enumerate() {
            let route = route.moved(turn);
            let name = format!("w{}", k + 1);
            let drift = gait::Drift {
                rate_rad_per_m: drift.rate_rad_per_m * settings.drift,
                start_rad: drift.start_rad * settings.drift,
                heading_rad: drift.heading_rad * settings.drift,
                position_m: drift.position_m * settings.drift,
                scale: drift.scale * settings.drift,
                ..drift
            };
            let (walk, truth) =
                gait::walk(&name, &route, &drift, plan.truth_every, key.named("gait").with(k as u64));
            simulation.starts.push(route.start());
            simulation.walks.push(walk);
            simulation.truth.extend(truth);
        }
        Ok(simulation)
    }
}

/// Routes and drifts, before chance shakes the steps.
struct Plan {
    walkers: Vec<(Route, gait::Drift)>,
    walls: Vec<Segment>,
    /// Truth every so many steps; 0: only where walkers stand.
    truth_every: usize,
}

impl Settings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Input`] at the setting that is out of range.
    pub fn validate(&self) -> Result<()> {
        for (name, value, low, high) in [
            ("walkers", self.walkers as f64, 0.0, 10_000.0),
            ("minutes", self.minutes, 0.1, 600.0),
            ("drift", self.drift, 0.0, 100.0),
            ("turn", self.turn_deg, -360.0, 360.0),
            ("bend", self.bend_deg, -120.0, 120.0),
            ("place of the bend", self.bend_at_m, 1.0, 37.0),
            ("strangers", self.strangers as f64, 0.0, 10_000.0),
            ("half strangers", self.half_strangers as f64, 0.0, 10_000.0),
        ] {
            if !(low..=high).contains(&value) {
                let message = format_args!("found {value}, expected a number from {low} to {high}");
                return Err(Error::input(name, message));
            }
        }
        if !(self.radius_m.abs() >= 10.0 && self.radius_m.is_finite()) {
            let message = format_args!("found {}, expected at least 10 m, either way", self.radius_m);
            return Err(Error::input("radius", message));
        }
        Ok(())
    }
}

impl fmt::Display for Scenario {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Scenario {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Scenario::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| {
            let names = Scenario::ALL.map(Scenario::name).join(", ");
            Error::input("scenario", format_args!("found \"{name}\", expected one of {names}"))
        })
    }
}
