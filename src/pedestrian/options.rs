//! What a run of the pedestrian mapper can be told; every number with its unit and range.

use super::history::CROSSINGS_PER_STEP;
use crate::error::{Error, Result};
use crate::geometry::Pose2;

/// How a crossing probability (N_h^e + G·P_h^e + α)/(N_h + G·P_h + 6α) becomes a factor of the weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Norm {
    /// Divided by its value in fresh ground, α/(1 + 6α): unexplored ground says nothing, and the filter is the PDR there.
    #[default]
    Fresh,
    /// Times 6: relative to an even choice among the six edges.
    Uniform,
    /// As published. Every crossing of fresh ground costs weight, so paths along a grid axis win: an artefact.
    Literal,
}

/// Which hexagon grid a run uses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum GridChoice {
    /// Turned to the group's own walking direction in the first round: a straight-corridor prior.
    #[default]
    Aligned,
    /// A fixed angle of the grid's x axis against the world, radians.
    Fixed(f64),
    /// A new random grid in every iteration: no direction is preferred.
    Regrid,
}

/// How the prior's gain G goes over the iterations of a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GainSchedule {
    /// G from the first iteration on.
    #[default]
    Constant,
    /// G·i/i_max in iteration i.
    Annealed,
}

/// The errors of a walker's dead reckoning, per [`OdometryNoise::STEP_M`] walked; standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryNoise {
    /// White noise of the heading, radians.
    pub heading_rad: f64,
    /// Heading drift at the start, radians per step.
    pub drift_start_rad: f64,
    /// Change of the heading drift, radians per step and step.
    pub drift_rad: f64,
    /// White noise of the position, per axis, metres.
    pub position_m: f64,
    /// Scale error of the walk.
    pub scale: f64,
}

impl OdometryNoise {
    /// The step for which the numbers stand, metres; white noise grows with √(length/STEP_M), drift with length/STEP_M.
    pub const STEP_M: f64 = 0.7;
}

impl Default for OdometryNoise {
    fn default() -> Self {
        OdometryNoise {
            heading_rad: 0.5f64.to_radians(),
            drift_start_rad: 0.05f64.to_radians(),
            drift_rad: 0.005f64.to_radians(),
            position_m: 0.02,
            scale: 0.005,
        }
    }
}

/// Where walkers start, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// World pose.
    pub pose: Pose2,
    /// Standard deviation of the position, per axis, metres.
    pub position_sigma_m: f64,
    /// Standard deviation of the heading, radians (the paper: 1°).
    pub heading_sigma_rad: f64,
}

impl Default for Start {
    fn default() -> Self {
        Start { pose: Pose2::IDENTITY, position_sigma_m: 0.05, heading_sigma_rad: 1f64.to_radians() }
    }
}

/// Settings of the mapper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Particles per walker, 2..=1,000,000.
    pub particles: usize,
    /// Independent filters that share the particles of a walker who is mapped alone, 1..=100: `footslam::run_islands`.
    pub islands: usize,
    /// Decides all that is left to chance.
    pub seed: u64,
    /// Circumradius of the hexagons, metres, 0.2..=5.
    pub hex_radius_m: f64,
    /// Which grid.
    pub grid: GridChoice,
    /// Dirichlet parameter α of every edge, > 0.
    pub alpha: f64,
    /// Normalisation of the crossing probability.
    pub norm: Norm,
    /// Errors of the dead reckoning.
    pub noise: OdometryNoise,
    /// Resample when the effective number of particles falls below this share, 0..=1.
    pub resample_below: f64,
    /// Iterations after iteration 0, 0..=10.
    pub iterations: usize,
    /// Gain G on the other walkers' counts, ≥ 0.
    pub gain: f64,
    /// How the gain goes over the iterations.
    pub gain_schedule: GainSchedule,
    /// Stop a round when the total map changes by less than this share from one iteration to the next; 0: never.
    pub converged_below: f64,
    /// In a later round of successive mapping, iteration 0 has the walker's own earlier map in its prior too.
    pub own_map_in_prior: bool,
    /// In later rounds re-run only the last metres of each walk (Kaiser 2020); what was before stays as it was.
    pub window_m: Option<f64>,
    /// Walks whose start frames are unknown may also have step lengths in other units: estimate a scale for each.
    pub align_scale: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            particles: 10_000,
            islands: 1,
            seed: 1,
            hex_radius_m: 0.5,
            grid: GridChoice::Aligned,
            alpha: 0.8,
            norm: Norm::Fresh,
            noise: OdometryNoise::default(),
            resample_below: 0.5,
            iterations: 10,
            gain: 1.0,
            gain_schedule: GainSchedule::Constant,
            converged_below: 0.0,
            own_map_in_prior: false,
            window_m: None,
            align_scale: false,
        }
    }
}

impl Options {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Input`] at the first setting out of range.
    pub fn validate(&self) -> Result<()> {
        let noise = &self.noise;
        let angle_rad = if let GridChoice::Fixed(angle) = self.grid { angle } else { 0.0 };
        for (name, value, low, high) in [
            ("particles", self.particles as f64, 2.0, 1e6),
            ("islands", self.islands as f64, 1.0, 100.0),
            ("particles of an island", (self.particles / self.islands.max(1)) as f64, 2.0, 1e6),
            ("hexagon radius", self.hex_radius_m, 0.2, 5.0),
            ("grid angle", angle_rad, -1e3, 1e3),
            ("alpha", self.alpha, 1e-6, 1e6),
            ("heading noise", noise.heading_rad, 0.0, 3.0),
            ("drift at start", noise.drift_start_rad, 0.0, 3.0),
            ("drift noise", noise.drift_rad, 0.0, 3.0),
            ("position noise", noise.position_m, 0.0, 3.0),
            ("scale noise", noise.scale, 0.0, 0.5),
            ("resampling share", self.resample_below, 0.0, 1.0),
            ("iterations", self.iterations as f64, 0.0, 10.0),
            ("gain", self.gain, 0.0, 1e6),
            ("convergence", self.converged_below, 0.0, 1.0),
            ("window", self.window_m.unwrap_or(1.0), 1.0, 1e6),
        ] {
            if !(low..=high).contains(&value) {
                let message = format_args!("found {value}, expected a number from {low} to {high}");
                return Err(Error::input(name, message));
            }
        }
        Ok(())
    }

    /// The longest step that is sure to cross no more edges than a path has room for, metres.
    pub fn longest_step_m(&self) -> f64 {
        // No line crosses more than two edges per 1.5 R; a few more where it starts.
        (CROSSINGS_PER_STEP - 4) as f64 * 0.75 * self.hex_radius_m
    }

    /// What a crossing probability is multiplied by.
    pub fn norm_factor(&self) -> f64 {
        match self.norm {
            Norm::Fresh => (1.0 + 6.0 * self.alpha) / self.alpha,
            Norm::Uniform => 6.0,
            Norm::Literal => 1.0,
        }
    }
}
