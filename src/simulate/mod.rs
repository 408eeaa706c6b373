//! Simulated worlds with truth: a robot's run through them, the bent map it makes, and a person's strokes on it.
//!
//! [`run`] drives a [`Scenario`]'s route, scans its walls from the **true** poses, measures every step with a bent
//! odometry ([`drift`]), composes the measurements to the map's poses, and draws the scenario's corrections
//! ([`strokes`]). Everything follows from the seed; drift, ranges and drawing have random streams of their own, so
//! that changing one setting leaves the rest of the run as it was.

mod building;
pub mod damage;
pub mod drift;
pub mod floor_plan;
pub mod lidar;
pub mod person;
mod planner;
pub mod ring;
pub mod route;
mod scenario;
pub mod strokes;
pub mod walkers;
pub mod world;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

pub use scenario::Scenario;
pub use world::Wall;

use crate::error::{Error, Result};
use crate::geometry::{Pose2, Segment};
use crate::map::{Correction, Observations, SlamMap, WallPair};

/// Seconds from one pose to the next.
const STEP_S: f64 = 0.5;

/// What chance does in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The same seed and settings give the same run, to the byte.
    pub seed: u64,
    /// Factor on all errors of the odometry, 0..=100; 1 is nominal, 0 a perfect chain.
    pub drift: f64,
    /// Standard deviation of a range, metres, 0..=10.
    pub range_noise_m: f64,
    /// Standard deviation of a stroke's end point, per axis, metres, 0..=10.
    pub drawing_noise_m: f64,
    /// The person goes on where the map is closed already, and draws every corridor straight.
    pub thorough: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { seed: 1, drift: 1.0, range_noise_m: 0.01, drawing_noise_m: 0.02, thorough: false }
    }
}

/// A run: what a mapping system would have, and what only a simulation knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// The map as the drifting odometry makes it.
    pub map: SlamMap,
    /// The true `world_from_robot` of every pose. The first pose of the map is true.
    pub truth: Vec<Pose2>,
    /// What a person would draw on that map, in that order.
    pub corrections: Vec<Correction>,
    /// The world.
    pub walls: Vec<Wall>,
    /// Which walls to compare: the samples of Table 1.
    pub pairs: Vec<WallPair>,
}

/// The independent sources of chance; the numbers are part of the format: they decide what a seed means.
#[derive(Debug, Clone, Copy)]
enum Stream {
    Drift = 0,
    Range = 1,
    Drawing = 2,
    Route = 3,
}

impl Settings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Input`] at the setting that is out of range.
    pub fn validate(&self) -> Result<()> {
        for (name, value, most) in [
            ("drift", self.drift, 100.0),
            ("range noise", self.range_noise_m, 10.0),
            ("drawing noise", self.drawing_noise_m, 10.0),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(Error::input(
                    name,
                    format_args!("found {value}, expected a number from 0 to {most}"),
                ));
            }
        }
        Ok(())
    }

    fn random(&self, stream: Stream) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(stream as u64);
        random
    }
}

/// Simulates one run of a scenario.
///
/// # Errors
/// [`Error::Input`] for settings that make no sense; [`Error::Internal`] where a scenario plans what nobody can see.
pub fn run(scenario: Scenario, settings: &Settings) -> Result<Simulation> {
    settings.validate()?;
    drive(scenario.plan(), settings)
}

/// Simulates a run between a few places of a building given by its walls, `length_m` metres long. The way follows from the
/// seed. There are no corrections: nobody planned any ([`person`] finds them).
///
/// # Errors
/// [`Error::Input`] for settings that make no sense, or walls that leave no free space.
pub fn run_through(walls: &[Segment], length_m: f64, settings: &Settings) -> Result<Simulation> {
    settings.validate()?;
    drive(building::plan(walls, length_m, &mut settings.random(Stream::Route))?, settings)
}

fn drive(plan: scenario::Plan, settings: &Settings) -> Result<Simulation> {
    let truth = plan.truth;

    let (mut observations, mut seen) = (Observations::default(), Vec::new());
    let mut random = settings.random(Stream::Range);
    for &pose in &truth {
        plan.lidar.scan(&plan.world, pose, settings.range_noise_m, &mut random, &mut observations, &mut seen);
    }

    let drift = plan.drift.times(settings.drift);
    let mut relative_factors = drift.measure(&truth, &mut settings.random(Stream::Drift))?;
    if let Some(kick) = plan.kick {
        // The odometry does not notice: its covariance stays the usual one.
        let step = &mut relative_factors[kick.step].i_from_j;
        *step = step.compose(Pose2::new(0.0, 0.0, kick.heading_rad * settings.drift));
    }
    let mut poses = vec![truth[0]];
    for (i, factor) in relative_factors.iter().enumerate() {
        poses.push(poses[i].compose(factor.i_from_j));
    }

    let scene =
        strokes::Scene { world: &plan.world, truth: &truth, observations: &observations, seen: &seen };
    let mut drawings = plan.drawings;
    if settings.thorough {
        drawings.extend(plan.rows.iter().flat_map(|row| scene.straighten(row)));
    }
    let corrections =
        scene.draw(&drawings, settings.drawing_noise_m, &mut settings.random(Stream::Drawing))?;

    let map = SlamMap {
        stamps_s: Some((0..poses.len()).map(|i| i as f64 * STEP_S).collect()),
        poses,
        relative_factors,
        observations,
        robot_from_laser: plan.lidar.robot_from_laser,
        ..SlamMap::default()
    };
    let walls = plan.world.walls().to_vec();
    Ok(Simulation { map, truth, corrections, walls, pairs: plan.pairs })
}
