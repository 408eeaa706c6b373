//! FeetSLAM on steps as they arrive, of several walkers at once.
//!
//! Every walker has a filter of its own, and as prior the maps that the *others* had published up to then: nothing is
//! known before it happened. A walker publishes its map, and is told the others', after every [`Settings::refresh_steps`]
//! of its own steps; one who comes late begins with what there is. [`Live::round`] closes a round, when asked to: every
//! walker is run again from its start with the others' maps, as in an iteration of [`super::feetslam`].
//!
//! [`Live::step`] is what a person waits for; [`Live::settle`] does what can be done after the answer. Everything
//! follows from the order of the calls: what is done depends on counts of steps, never on a clock.

mod walker;

use rayon::prelude::*;

use super::bend::{harmful_bend, harmful_curve};
use super::feetslam::FallBack;
use super::footslam::Estimate;
use super::grid;
use super::hex::HexGrid;
use super::layout::Layout;
use super::options::{GridChoice, Options, Start};
use super::random::Key;
use super::successive::Outcome;
use super::transition_map::{Prior, TransitionMap};
use super::walk::{LONGEST_STEP_M, Step, Walk};
use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2};
use walker::{Walker, World};

/// Bends that an aligned grid gets wrong are looked for after so many refreshes.
const REFRESHES_PER_BEND_CHECK: usize = 5;
/// A round that is closed before [`grid::ALIGN_WITHIN_M`] turns the grid if somebody has gone this far, metres.
const ENOUGH_FOR_A_ROUND_M: f64 = 5.0;

/// How a live run works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The mapper's. Iterations, window and own map belong to runs on whole walks and are not used.
    pub options: Options,
    /// Where walkers start who say nothing else.
    pub start: Start,
    /// A walker publishes its map and is told the others' after every so many of its steps, ≥ 1.
    pub refresh_steps: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { options: Options::default(), start: Start::default(), refresh_steps: 20 }
    }
}

/// Where a walker is after a step; world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// End of the step, seconds.
    pub time_s: f64,
    /// Steps of this walker so far.
    pub steps: usize,
    /// Weighted mean of the particles.
    pub mean: Pose2,
    /// Standard deviation of the particles' positions per axis, metres.
    pub sigma_m: f64,
    /// The particle with the greatest evidence.
    pub best: Vec2,
    /// Dead reckoning.
    pub reckoned: Pose2,
}

/// Something that a person should know.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The grid was turned, and everybody run again on it.
    Grid {
        /// Its angle against the world, radians.
        angle_rad: f64,
        /// Why it is not along the walkers' direction, if it is not.
        fall_back: Option<FallBack>,
    },
    /// A walker left the window of hexagons, and now shares some with the other side of it.
    Strayed {
        /// The walker's name.
        walker: String,
        /// Size of the window, metres.
        window_m: [f64; 2],
    },
}

/// What is known of the grid's direction.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Direction {
    /// Not yet: nobody has walked far enough.
    Unknown,
    /// Along the walkers' own.
    Aligned,
    /// As asked for.
    Given,
    /// There is none, or the building turns by a small angle.
    GivenUp(FallBack),
}

/// Walkers on their way.
#[derive(Debug)]
pub struct Live<'a> {
    settings: &'a Settings,
    world: World<'a>,
    direction: Direction,
    walkers: Vec<Walker<'a>>,
    /// Walker of the step that has not been settled yet.
    pending: Option<usize>,
    rounds: usize,
    particle_steps: u64,
}

impl<'a> Live<'a> {
    /// Nobody has come yet.
    ///
    /// # Errors
    /// [`Error::Input`] for settings out of range, or a grid that is drawn anew in every iteration: there are none.
    pub fn new(settings: &'a Settings) -> Result<Self> {
        settings.options.validate()?;
        if settings.refresh_steps == 0 {
            return Err(Error::input("refresh steps", "found 0, expected at least 1"));
        }
        let (direction, angle_rad) = match settings.options.grid {
            GridChoice::Aligned => (Direction::Unknown, settings.start.pose.theta_rad),
            GridChoice::Fixed(angle_rad) => (Direction::Given, angle_rad),
            GridChoice::Regrid => {
                let message =
                    "found regrid, expected aligned or fixed: live there are no iterations to draw it in";
                return Err(Error::input("grid", message));
            }
        };
        let origin = settings.start.pose.translation();
        let grid = HexGrid { radius_m: settings.options.hex_radius_m, angle_rad, origin };
        Ok(Live {
            settings,
            world: World { settings, grid, layout: Layout::largest(&grid, origin), round: 0 },
            direction,
            walkers: Vec::new(),
            pending: None,
            rounds: 0,
            particle_steps: 0,
        })
    }

    /// Says where a walker starts; walkers who do not start at [`Settings::start`].
    ///
    /// # Errors
    /// What was found and expected, if the walker has already come.
    pub fn begin(&mut self, name: &str, pose: Pose2) -> std::result::Result<(), String> {
        if self.index(name).is_some() {
            return Err(format!(
                "found a start of '{name}', who is already known, expected it before the first step"
            ));
        }
        self.add(name, Start { pose, ..self.settings.start });
        Ok(())
    }

    /// Takes a step; call [`Live::settle`] after it.
    ///
    /// # Errors
    /// What was found and expected, if the step cannot be; nothing has changed then.
    pub fn step(&mut self, name: &str, step: Step) -> std::result::Result<Position, String> {
        let known = self.index(name);
        let before_s = known.and_then(|j| self.walkers[j].walk.steps.last()).map(|s| s.time_s);
        if let Some(before_s) = before_s.filter(|&b| b >= step.time_s) {
            let found = format!("time_s: found {} after {before_s} of '{name}'", step.time_s);
            return Err(format!("{found}, expected a later time; are two walkers called so?"));
        }
        let longest_m = LONGEST_STEP_M.min(self.settings.options.longest_step_m());
        if !step.length_m().is_finite() || step.length_m() > longest_m {
            let found = format!("found a step of {:.1} m", step.length_m());
            return Err(format!("{found}, expected at most {longest_m} m: are steps missing?"));
        }
        let j = known.unwrap_or_else(|| self.add(name, self.settings.start));
        self.pending = Some(j);
        self.particle_steps += self.settings.options.particles as u64;
        Ok(self.walkers[j].advance(&self.world, step))
    }

    /// Does what the step before makes due: turns the grid, exchanges maps.
    pub fn settle(&mut self) -> Vec<Event> {
        let mut events = Vec::new();
        let Some(j) = self.pending.take() else { return events };
        let (steps, length_m) = (self.walkers[j].walk.steps.len(), self.walkers[j].length_m);
        if self.direction == Direction::Unknown && length_m >= grid::ALIGN_WITHIN_M {
            events.push(self.align());
        }
        if steps % self.settings.refresh_steps == 0 {
            self.walkers[j].publish(&self.world);
            self.walkers[j].prior = self.prior_of(Some(j));
            let check = steps % (self.settings.refresh_steps * REFRESHES_PER_BEND_CHECK) == 0;
            if check && self.direction == Direction::Aligned {
                events.extend(self.look_for_bends());
            }
        }
        let walker = &mut self.walkers[j];
        let here = walker.mean.last().map_or(Vec2::zeros(), |p| p.translation());
        if !walker.strayed && !self.world.layout.contains(&self.world.grid, here) {
            walker.strayed = true;
            let [columns, rows] = self.world.layout.sides().map(|n| n as f64);
            let radius_m = self.settings.options.hex_radius_m;
            let window_m = [columns * 3f64.sqrt() * radius_m, rows * 1.5 * radius_m];
            events.push(Event::Strayed { walker: walker.walk.name.clone(), window_m });
        }
        events
    }

    /// Closes a round: runs everybody again from the start, with the others' maps of now. Takes as long as that takes. A
    /// grid whose direction is not known yet is turned first: what a round finds out is lost when the grid turns.
    pub fn round(&mut self) -> Option<Event> {
        let longest_m = self.walkers.iter().map(|w| w.length_m).fold(0.0, f64::max);
        let is_early = self.direction == Direction::Unknown && longest_m >= ENOUGH_FOR_A_ROUND_M;
        let event = is_early.then(|| self.align());
        self.rounds += 1;
        self.world.round += 1;
        self.walkers.iter_mut().for_each(|w| w.publish(&self.world));
        let priors: Vec<_> = (0..self.walkers.len()).map(|j| self.prior_of(Some(j))).collect();
        self.run_again(priors);
        event
    }

    /// The sum of all walkers' maps.
    pub fn map(&self) -> TransitionMap {
        let mut total = TransitionMap::new(self.world.grid, self.world.layout);
        self.walkers.iter().for_each(|w| w.add_to(&mut total));
        total
    }

    /// Names of the walkers and where each is, in the order in which they came.
    pub fn positions(&self) -> impl Iterator<Item = (&str, Pose2, f64)> {
        self.walkers.iter().map(|w| {
            let (pose, sigma_m) = (w.mean.last().copied(), w.sigma_m.last().copied());
            (w.walk.name.as_str(), pose.unwrap_or(w.start.pose), sigma_m.unwrap_or(0.0))
        })
    }

    /// The walks so far and what came out, of those who took a step.
    pub fn outcome(&self) -> (Vec<Walk>, Outcome) {
        let walked = || self.walkers.iter().filter(|w| !w.walk.steps.is_empty());
        let estimates: Vec<Estimate> = walked().map(|w| w.estimate(&self.world)).collect();
        let outcome = Outcome {
            takes_part: vec![true; estimates.len()],
            evidence: None,
            scales: vec![1.0; estimates.len()],
            estimates,
            total: self.map(),
            rounds: self.rounds,
            iterations: 0,
            change: 1.0,
            particle_steps: self.particle_steps,
            fall_back: match self.direction {
                Direction::GivenUp(why) => Some(why),
                _ => None,
            },
            starts: walked().map(|w| w.start).collect(),
        };
        (walked().map(|w| w.walk.clone()).collect(), outcome)
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.walkers.iter().position(|w| w.walk.name == name)
    }

    fn add(&mut self, name: &str, start: Start) -> usize {
        let prior = self.prior_of(None);
        let walk = Walk { name: name.to_owned(), steps: Vec::new() };
        self.walkers.push(Walker::new(&self.world, walk, start, prior));
        self.walkers.len() - 1
    }

    /// What a walker is told: the maps that all others have published; `None`: nothing.
    fn prior_of(&self, walker: Option<usize>) -> Option<Prior> {
        let others = self.walkers.iter().enumerate().filter(|(j, _)| Some(*j) != walker);
        let mut maps = others.filter_map(|(_, w)| w.published.as_ref()).peekable();
        maps.peek()?;
        let mut total = TransitionMap::new(self.world.grid, self.world.layout);
        maps.for_each(|map| total.add_map(map));
        Some(Prior::new(&total, self.settings.options.gain, self.settings.options.alpha))
    }

    /// Turns the grid to the walkers' direction, if they have one.
    fn align(&mut self) -> Event {
        let heads: Vec<(Vec<Vec2>, f64)> = self
            .walkers
            .iter()
            .map(|w| {
                let steps = w.walk.steps_to_length(grid::ALIGN_WITHIN_M);
                (w.track.iter().take(steps + 1).map(|p| p.translation()).collect(), w.walk.typical_length_m())
            })
            .collect();
        match grid::group_direction(heads.iter().map(|(track, typical_m)| (&track[..], *typical_m))) {
            Some(d) if d.concentration >= grid::MIN_CONCENTRATION => {
                self.direction = Direction::Aligned;
                let grid = HexGrid { angle_rad: d.angle_rad, ..self.world.grid };
                self.turn(grid, None)
            }
            other => self.give_up(FallBack::NoDirection(other.map_or(0.0, |d| d.concentration))),
        }
    }

    fn look_for_bends(&mut self) -> Option<Event> {
        let tracks: Vec<Vec<Vec2>> =
            self.walkers.iter().map(|w| w.track.iter().map(|p| p.translation()).collect()).collect();
        let tracks: Vec<&[Vec2]> = tracks.iter().map(|t| &t[..]).collect();
        let harm = harmful_bend(&tracks).map(FallBack::Bend);
        harm.or_else(|| harmful_curve(&tracks).map(FallBack::Curve)).map(|why| self.give_up(why))
    }

    /// Goes on with a grid that prefers no direction: a random one.
    fn give_up(&mut self, why: FallBack) -> Event {
        self.direction = Direction::GivenUp(why);
        let key = Key::new(self.settings.options.seed).named("grid");
        let origin = self.settings.start.pose.translation();
        self.turn(grid::random_grid(self.settings.options.hex_radius_m, origin, key), Some(why))
    }

    /// Everybody again on another grid: alone, since what was published lies on the old one.
    fn turn(&mut self, grid: HexGrid, fall_back: Option<FallBack>) -> Event {
        self.world.grid = grid;
        self.world.layout = Layout::largest(&grid, self.settings.start.pose.translation());
        self.run_again(self.walkers.iter().map(|_| None).collect());
        self.walkers.iter_mut().filter(|w| !w.walk.steps.is_empty()).for_each(|w| w.publish(&self.world));
        for j in 0..self.walkers.len() {
            self.walkers[j].prior = self.prior_of(Some(j));
        }
        Event::Grid { angle_rad: grid.angle_rad, fall_back }
    }

    fn run_again(&mut self, priors: Vec<Option<Prior>>) {
        let world = &self.world;
        let old = std::mem::take(&mut self.walkers);
        self.walkers =
            old.into_par_iter().zip(priors).map(|(walker, prior)| walker.again(world, prior)).collect();
        let steps: usize = self.walkers.iter().map(|w| w.walk.steps.len()).sum();
        self.particle_steps += (steps * self.settings.options.particles) as u64;
    }
}
