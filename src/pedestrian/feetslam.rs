//! FeetSLAM: walkers map together. Iteration 0 is FootSLAM alone; from then on each walker is run again with the sum of
//! all *other* walkers' maps as its prior, until the total map stays as it is or the iterations are used up.
//!
//! M_j^i = FootSLAM(D_j, G_i · Σ_{l≠j} M_l^{i−1}): a walker's M holds its own crossings only. One group is one state
//! ([`Group`]); [`super::successive`] calls [`Group::round`] with ever longer parts of the walks.

use rayon::prelude::*;

use super::bend::{Bend, Curve, harmful_bend, harmful_curve};
use super::footslam::{self, Estimate, Pass};
use super::grid;
use super::hex::HexGrid;
use super::layout::Layout;
use super::options::{GainSchedule, GridChoice, Options, Start};
use super::path_tree::PathTree;
use super::random::Key;
use super::transition_map::{Prior, TransitionMap};
use super::walk::Walk;
use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2};

/// Equally weighted paths that walkers exchange where counts cannot be (another grid, another frame).
pub const EXCHANGED_PATHS: usize = 400;

/// Why a run did not keep to the aligned grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FallBack {
    /// The first steps have no common direction; its concentration.
    NoDirection(f64),
    /// The building turns by a small angle.
    Bend(Bend),
    /// The building begins to curve.
    Curve(Curve),
}

impl std::fmt::Display for FallBack {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FallBack::NoDirection(r) => write!(f, "no common direction (concentration {r:.2})"),
            FallBack::Bend(bend) => {
                let deg = bend.angle_rad.to_degrees();
                write!(f, "all walkers turn by {deg:.1}° after {:.1} m", bend.at_m)
            }
            FallBack::Curve(curve) => {
                let radius_m = 1.0 / curve.rate_rad_per_m.abs();
                let side = if curve.rate_rad_per_m > 0.0 { "left" } else { "right" };
                write!(f, "all tracks bend {side} after {:.0} m (radius {radius_m:.0} m)", curve.at_m)
            }
        }
    }
}

/// What an iteration found out, for those who want to see it happen.
#[derive(Debug)]
pub struct Snapshot<'a> {
    /// Round, from 0.
    pub round: usize,
    /// Iteration, from 0.
    pub iteration: usize,
    /// Sum of all walkers' maps.
    pub total: &'a TransitionMap,
    /// What each walker's pass gave.
    pub estimates: &'a [Estimate],
    /// Change of the total map since the iteration before, 0..=1; 1 in iteration 0.
    pub change: f64,
}

/// What the walkers of a group know together before an iteration.
struct Shared {
    /// The sum of the maps of those who take part.
    total: TransitionMap,
    /// Each walker's own.
    own: Vec<TransitionMap>,
    gain: f64,
    /// A walker's own map belongs to its prior.
    with_own: bool,
}

/// Walkers who map together.
#[derive(Debug, Clone)]
pub struct Group<'a> {
    walks: &'a [Walk],
    /// Where each walker starts.
    pub starts: Vec<Start>,
    /// Who takes part; others are mapped alone, and give nothing to the rest.
    pub takes_part: Vec<bool>,
    options: &'a Options,
    tracks: Vec<Vec<Vec2>>,
    /// Each walker's latest result.
    latest: Vec<Estimate>,
    aligned_rad: Option<f64>,
    /// Why the aligned grid was given up, if it was.
    pub fall_back: Option<FallBack>,
    /// Particles times steps so far.
    pub particle_steps: u64,
}

impl<'a> Group<'a> {
    /// A group before its first round; all walkers start alike.
    ///
    /// # Errors
    /// [`Error::Input`] for options out of range, no walks, two of the same name, or a step too long for the hexagons.
    pub fn new(walks: &'a [Walk], start: Start, options: &'a Options) -> Result<Self> {
        options.validate()?;
        if walks.is_empty() {
            return Err(Error::input("walks", "found none, expected at least one"));
        }
        let mut names: Vec<&str> = walks.iter().map(|w| w.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let message = format!("found two walkers with the name '{}', expected different names", pair[0]);
            return Err(Error::input("walks", message));
        }
        let longest_m = options.longest_step_m();
        for walk in walks {
            if walk.steps.is_empty() {
                return Err(Error::input(&walk.name, "found a walk without steps, expected at least one"));
            }
            if let Some(step) =
                walk.steps.iter().find(|s| s.length_m() > longest_m || !s.length_m().is_finite())
            {
                let found = format!("found a step of {:.1} m at {} s", step.length_m(), step.time_s);
                let message =
                    format!("{found}, expected at most {longest_m:.1} m: are steps missing before it?");
                return Err(Error::input(&walk.name, message));
            }
        }
        let mut group = Group {
            walks,
            starts: vec![start; walks.len()],
            takes_part: vec![true; walks.len()],
            options,
            tracks: Vec::new(),
            latest: Vec::new(),
            aligned_rad: None,
            fall_back: None,
            particle_steps: 0,
        };
        group.tracks = group.dead_reckoning();
        Ok(group)
    }

    /// Positions of each walker by dead reckoning, the start first.
    pub fn dead_reckoning(&self) -> Vec<Vec<Vec2>> {
        let track =
            |(walk, start): (&Walk, &Start)| walk.track(start.pose).iter().map(|p| p.translation()).collect();
        self.walks.iter().zip(&self.starts).map(track).collect()
    }

    /// Gives every walker another start; before the first round.
    pub fn move_starts(&mut self, poses: &[Pose2]) {
        for (start, &pose) in self.starts.iter_mut().zip(poses) {
            start.pose = pose;
        }
        self.tracks = self.dead_reckoning();
    }

    /// Takes paths that were found elsewhere (the start first, then one pose per step) as what is known so far.
    ///
    /// # Errors
    /// [`Error::Input`] if they do not fit on the grid.
    pub fn begin_with(&mut self, paths: Vec<Vec<Pose2>>) -> Result<()> {
        let (radius_m, origin) = (self.options.hex_radius_m, self.starts[0].pose.translation());
        let grid = HexGrid { radius_m, angle_rad: 0.0, origin };
        let known = |mean: Vec<Pose2>| -> Result<Estimate> {
            let best: Vec<Vec2> = mean.iter().map(|p| p.translation()).collect();
            let layout = Layout::around(&grid, best.iter().copied())?;
            let mut map = TransitionMap::new(grid, layout);
            map.add_path(&best, 1.0);
            let sampled_paths = PathTree::from(best.as_slice());
            let sigma_m = vec![0.0; mean.len()];
            Ok(Estimate { best, mean, sigma_m, map, sampled_paths, log_evidence: 0.0, resamplings: 0 })
        };
        self.latest = paths.into_iter().map(known).collect::<Result<_>>()?;
        Ok(())
    }

    /// Each walker's latest result; empty before the first round.
    pub fn latest(&self) -> &[Estimate] {
        &self.latest
    }

    /// The same, without the group.
    pub fn into_latest(self) -> Vec<Estimate> {
        self.latest
    }

    /// One round of FeetSLAM on the first `steps[j]` steps of each walk; `first` is the first iteration (1 to go on
    /// where an earlier call stopped). Returns the last iteration's number.
    ///
    /// # Errors
    /// [`Error::Input`] if the walks do not fit on the grid.
    pub fn round(
        &mut self,
        round: usize,
        first: usize,
        steps: &[usize],
        observe: &mut dyn FnMut(&Snapshot),
    ) -> Result<usize> {
        let last = if self.walks.len() == 1 { first } else { self.options.iterations.max(first) };
        let mut before: Option<TransitionMap> = None;
        for iteration in first..=last {
            let grid = self.grid(round, iteration, steps);
            let layout = Layout::around(&grid, self.tracks.iter().flatten().copied())?;
            let froms: Vec<usize> = (0..steps.len()).map(|j| self.window_start(round, j, steps[j])).collect();
            let shared = self.shared(iteration, grid, layout);
            // What was drawn is drawn into the maps now: the next paths come with the next passes.
            self.latest.iter_mut().for_each(|e| e.sampled_paths = PathTree::default());
            let exchange = matches!(self.options.grid, GridChoice::Regrid)
                || iteration == last
                || iteration == 0
                || self.fall_back.is_some();
            self.latest =
                self.passes(round, iteration, (steps, &froms), (grid, layout), shared.as_ref(), exchange);
            let run: usize = steps.iter().zip(&froms).map(|(&to, &from)| to - from).sum();
            self.particle_steps += (run * self.options.particles) as u64;

            let mut total = TransitionMap::new(grid, layout);
            self.latest
                .iter()
                .zip(&self.takes_part)
                .filter(|(_, t)| **t)
                .for_each(|(e, _)| total.add_map(&e.map));
            let comparable = before.as_ref().filter(|b| b.grid == grid && b.layout == layout);
            let change = comparable.map_or(1.0, |b| total.change(b));
            observe(&Snapshot { round, iteration, total: &total, estimates: &self.latest, change });
            before = Some(total);
            if change < self.options.converged_below {
                return Ok(iteration);
            }
        }
        Ok(last)
    }

    /// The grid of an iteration.
    fn grid(&mut self, round: usize, iteration: usize, steps: &[usize]) -> HexGrid {
        let (radius_m, origin) = (self.options.hex_radius_m, self.starts[0].pose.translation());
        let key = Key::new(self.options.seed).named("grid").with(round as u64).with(iteration as u64);
        match self.options.grid {
            GridChoice::Fixed(angle_rad) => HexGrid { radius_m, angle_rad, origin },
            GridChoice::Regrid => grid::random_grid(radius_m, origin, key),
            GridChoice::Aligned => match self.aligned(steps) {
                Some(angle_rad) => HexGrid { radius_m, angle_rad, origin },
                None => grid::random_grid(radius_m, origin, key),
            },
        }
    }

    /// The aligned grid's angle, or `None` where it would do harm (and from then on).
    fn aligned(&mut self, steps: &[usize]) -> Option<f64> {
        if self.fall_back.is_some() {
            return None;
        }
        if self.aligned_rad.is_none() {
            let tracks: Vec<(&[Vec2], &Walk)> = self
                .tracks
                .iter()
                .zip(steps)
                .zip(self.walks)
                .map(|((track, &steps), walk)| (&track[..=steps], walk))
                .collect();
            let long = grid::long_direction(
                tracks.iter().map(|(track, walk)| (*track, walk.typical_length_m())),
                &self.options.noise,
            );
            let found = long.filter(|d| d.concentration >= grid::MIN_CONCENTRATION).or_else(|| {
                grid::group_direction(tracks.iter().map(|(track, walk)| {
                    let head = walk.steps_to_length(grid::ALIGN_WITHIN_M).min(track.len() - 1);
                    (&track[..=head], walk.typical_length_m())
                }))
            });
            match found {
                Some(d) if d.concentration >= grid::MIN_CONCENTRATION => self.aligned_rad = Some(d.angle_rad),
                other => {
                    self.fall_back = Some(FallBack::NoDirection(other.map_or(0.0, |d| d.concentration)));
                    return None;
                }
            }
        }
        let parts = self.tracks.iter().zip(steps).zip(&self.takes_part);
        let tracks: Vec<&[Vec2]> =
            parts.filter(|(_, t)| **t).map(|((track, &steps), _)| &track[..=steps]).collect();
        let bend = harmful_bend(&tracks).map(FallBack::Bend);
        self.fall_back = bend.or_else(|| harmful_curve(&tracks).map(FallBack::Curve));
        if self.fall_back.is_some() { None } else { self.aligned_rad }
    }

    /// What the walkers know together; `None` where there is nothing to tell.
    fn shared(&self, iteration: usize, grid: HexGrid, layout: Layout) -> Option<Shared> {
        if self.latest.is_empty() || (self.walks.len() == 1 && !self.options.own_map_in_prior) {
            return None;
        }
        // Counts where the grid is still the same, else the paths drawn on the new one.
        let own = |estimate: &Estimate| {
            if estimate.map.grid == grid && estimate.map.layout == layout {
                return estimate.map.clone();
            }
            let mut map = TransitionMap::new(grid, layout);
            estimate.sampled_paths.add_to(&mut map);
            map
        };
        let own: Vec<TransitionMap> = self.latest.par_iter().map(own).collect();
        let mut total = TransitionMap::new(grid, layout);
        own.iter().zip(&self.takes_part).filter(|(_, t)| **t).for_each(|(map, _)| total.add_map(map));
        let gain = match self.options.gain_schedule {
            GainSchedule::Annealed if iteration > 0 => {
                self.options.gain * iteration as f64 / self.options.iterations as f64
            }
            _ => self.options.gain,
        };
        let with_own = self.options.own_map_in_prior && iteration == 0;
        Some(Shared { total, own, gain, with_own })
    }

    /// What walker j is told by the others; made when its pass begins, as it is large.
    fn prior(&self, shared: &Shared, j: usize, from: usize) -> Option<Prior> {
        if !self.takes_part[j] {
            return None;
        }
        let mut others = shared.total.clone();
        if !shared.with_own {
            others.subtract(&shared.own[j]);
            others.add_path(&self.frozen(j, from), 1.0);
        }
        Some(Prior::new(&others, shared.gain, self.options.alpha))
    }

    /// The step from which on a walker is run again: 0, or what the sliding window leaves.
    fn window_start(&self, round: usize, j: usize, steps: usize) -> usize {
        let (Some(window_m), Some(before)) =
            (self.options.window_m.filter(|_| round > 0), self.latest.get(j))
        else {
            return 0;
        };
        let lengths = self.walks[j].lengths_m();
        let from_m = lengths[..steps].last().map_or(0.0, |l| l - window_m);
        lengths.iter().take_while(|&&l| l <= from_m).count().min(before.mean.len() - 1)
    }

    /// The part of a walker's path that the sliding window leaves as it was, its last point being the new start.
    fn frozen(&self, j: usize, from: usize) -> Vec<Vec2> {
        match self.latest.get(j) {
            Some(before) if from > 0 => before.mean[..=from].iter().map(|p| p.translation()).collect(),
            _ => Vec::new(),
        }
    }

    /// Runs every walker.
    fn passes(
        &self,
        round: usize,
        iteration: usize,
        (steps, froms): (&[usize], &[usize]),
        (grid, layout): (HexGrid, Layout),
        shared: Option<&Shared>,
        exchange: bool,
    ) -> Vec<Estimate> {
        let root = Key::new(self.options.seed);
        let one = |(j, walk): (usize, &Walk)| {
            let from = froms[j];
            let prior = shared.and_then(|shared| self.prior(shared, j, from));
            let mut start = self.starts[j];
            if from > 0 {
                start.pose = self.latest[j].mean[from];
                start.position_sigma_m = self.latest[j].sigma_m[from].max(start.position_sigma_m);
            }
            let run = if prior.is_none() && self.options.islands > 1 {
                footslam::run_islands
            } else {
                footslam::run
            };
            let estimate = run(&Pass {
                steps: &walk.steps[from..steps[j]],
                start,
                grid,
                layout,
                prior: prior.as_ref(),
                options: self.options,
                // By name: the order in which walks are given does not matter.
                key: root.named(&walk.name).with(round as u64).with(iteration as u64),
                sampled_paths: if exchange { EXCHANGED_PATHS.min(self.options.particles) } else { 0 },
                parallel: self.walks.len() < 2 * rayon::current_num_threads(),
            });
            match from {
                0 => estimate,
                _ => estimate.after(&self.latest[j], from),
            }
        };
        self.walks.par_iter().enumerate().map(one).collect()
    }
}
