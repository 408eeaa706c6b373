//! One walker of a live run: its filter, its paths so far, what it published and what it was told.

use super::{Position, Settings};
use crate::geometry::{Pose2, Vec2, wrap_angle};
use crate::pedestrian::footslam::Estimate;
use crate::pedestrian::hex::HexGrid;
use crate::pedestrian::layout::Layout;
use crate::pedestrian::motion::MeasuredStep;
use crate::pedestrian::options::Start;
use crate::pedestrian::particle_filter::{ParticleFilter, Setting};
use crate::pedestrian::path_tree::PathTree;
use crate::pedestrian::random::Key;
use crate::pedestrian::transition_map::{Prior, TransitionMap};
use crate::pedestrian::walk::{Step, Walk};

/// What all walkers share.
#[derive(Debug, Clone, Copy)]
pub(super) struct World<'a> {
    pub settings: &'a Settings,
    pub grid: HexGrid,
    pub layout: Layout,
    /// Rounds closed so far: part of the random streams' names.
    pub round: u64,
}

/// A walker on its way.
#[derive(Debug)]
pub(super) struct Walker<'a> {
    pub walk: Walk,
    pub start: Start,
    filter: ParticleFilter<'a>,
    /// What the others had published when it was last told.
    pub prior: Option<Prior>,
    /// Its own map when it last published it.
    pub published: Option<TransitionMap>,
    /// Dead reckoning and weighted mean, the start first.
    pub track: Vec<Pose2>,
    pub mean: Vec<Pose2>,
    pub sigma_m: Vec<f64>,
    /// Heading of the dead reckoning, not wrapped.
    heading_rad: f64,
    /// Path length, metres.
    pub length_m: f64,
    /// It was said that it left the window.
    pub strayed: bool,
}

impl<'a> Walker<'a> {
    /// A walker at its start; `walk` has no steps yet.
    pub fn new(world: &World<'a>, walk: Walk, start: Start, prior: Option<Prior>) -> Self {
        let at = world.grid.to_grid(start.pose.translation());
        let filter = ParticleFilter::new(Setting {
            hexagon: world.grid.shape(),
            layout: world.layout,
            prior: None,
            options: &world.settings.options,
            key: Key::new(world.settings.options.seed).named(&walk.name).with(world.round).with(0),
            start: [at.x as f32, at.y as f32],
            start_sigmas: [start.position_sigma_m as f32, start.heading_sigma_rad as f32],
            parallel: true,
        });
        Walker {
            walk,
            start,
            filter,
            prior,
            published: None,
            track: vec![start.pose],
            mean: vec![start.pose],
            sigma_m: vec![start.position_sigma_m],
            heading_rad: start.pose.theta_rad,
            length_m: 0.0,
            strayed: false,
        }
    }

    /// One step on.
    pub fn advance(&mut self, world: &World<'a>, step: Step) -> Position {
        let moved = MeasuredStep::of(&step, self.heading_rad, &world.grid);
        self.heading_rad = moved.heading_rad;
        let sums = self.filter.step_with(self.prior.as_ref(), &moved, true);
        let [x, y] = sums.mean();
        let p = world.grid.to_world(Vec2::new(x, y));
        let mean = Pose2::new(p.x, p.y, wrap_angle(moved.heading_rad + sums.heading_offset_rad()));
        let [x, y] = self.filter.position(self.filter.best());
        let reckoned = self
            .track
            .last()
            .map_or(self.start.pose, |p| p.compose(Pose2::new(step.forward_m, step.left_m, step.turn_rad)));
        self.track.push(reckoned);
        self.mean.push(mean);
        self.sigma_m.push(sums.sigma());
        self.length_m += step.length_m();
        self.walk.steps.push(step);
        Position {
            time_s: step.time_s,
            steps: self.walk.steps.len(),
            mean,
            sigma_m: sums.sigma(),
            best: world.grid.to_world(Vec2::new(x.into(), y.into())),
            reckoned,
        }
    }

    /// The same walker run again from its start, in another world or with another prior.
    pub fn again(self, world: &World<'a>, prior: Option<Prior>) -> Self {
        let name = self.walk.name.clone();
        let mut walker = Walker::new(world, Walk { name, steps: Vec::new() }, self.start, prior);
        for &step in &self.walk.steps {
            walker.advance(world, step);
        }
        if self.published.as_ref().is_some_and(|map| map.grid == world.grid && map.layout == world.layout) {
            walker.publish(world);
        }
        walker.strayed = self.strayed;
        walker
    }

    /// Makes the map so far known to the others.
    pub fn publish(&mut self, world: &World<'a>) {
        let mut map = TransitionMap::new(world.grid, world.layout);
        self.filter.add_to(&mut map);
        self.published = Some(map);
    }

    /// Adds the expected crossings.
    pub fn add_to(&self, map: &mut TransitionMap) {
        self.filter.add_to(map);
    }

    /// Everything found out so far.
    pub fn estimate(&self, world: &World<'a>) -> Estimate {
        let mut map = TransitionMap::new(world.grid, world.layout);
        self.add_to(&mut map);
        let path = self.filter.path(self.filter.best());
        Estimate {
            best: path.iter().map(|&[x, y]| world.grid.to_world(Vec2::new(x.into(), y.into()))).collect(),
            mean: self.mean.clone(),
            sigma_m: self.sigma_m.clone(),
            map,
            sampled_paths: PathTree::default(),
            log_evidence: self.filter.log_evidence,
            resamplings: self.filter.resamplings,
        }
    }
}
