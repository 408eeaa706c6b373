//! FootSLAM: one walker, one pass over the walk, with or without a prior map.

use super::hex::HexGrid;
use super::layout::Layout;
use super::motion::measured;
use super::options::{Options, Start};
use super::particle_filter::{ParticleFilter, Setting};
use super::path_tree::PathTree;
use super::random::Key;
use super::transition_map::{Prior, TransitionMap};
use super::walk::Step;
use crate::geometry::{Pose2, Vec2, wrap_angle};

/// One pass of the filter.
#[derive(Debug, Clone, Copy)]
pub struct Pass<'a> {
    /// The steps to go through.
    pub steps: &'a [Step],
    /// Where they begin.
    pub start: Start,
    /// Where the hexagons lie.
    pub grid: HexGrid,
    /// How they are numbered.
    pub layout: Layout,
    /// What other walkers found out.
    pub prior: Option<&'a Prior>,
    /// Settings.
    pub options: &'a Options,
    /// Random stream.
    pub key: Key,
    /// How many paths to draw from the posterior.
    pub sampled_paths: usize,
    /// Run blocks of particles on several threads.
    pub parallel: bool,
}

/// What a pass found out; world frame. Paths have one entry more than there are steps: the start.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The path of the particle with the greatest evidence.
    pub best: Vec<Vec2>,
    /// The weighted mean of the particles after each step (as a person would have seen it then).
    pub mean: Vec<Pose2>,
    /// Standard deviation of the particles' positions per axis after each step, metres.
    pub sigma_m: Vec<f64>,
    /// Expected crossings of this walker alone.
    pub map: TransitionMap,
    /// Paths drawn from the posterior, equally weighted.
    pub sampled_paths: PathTree,
    /// ln of the evidence.
    pub log_evidence: f64,
    /// How often particles were resampled.
    pub resamplings: usize,
}

impl Estimate {
    /// This estimate of the end of a walk, behind the first `from` steps of an earlier one.
    pub(super) fn after(mut self, earlier: &Estimate, from: usize) -> Estimate {
        let frozen: Vec<Vec2> = earlier.mean[..=from].iter().map(|p| p.translation()).collect();
        self.map.add_path(&frozen, 1.0);
        self.sampled_paths.put_before(&frozen[..from]);
        self.best.splice(0..0, earlier.best[..from].iter().copied());
        self.mean.splice(0..0, earlier.mean[..from].iter().copied());
        self.sigma_m.splice(0..0, earlier.sigma_m[..from].iter().copied());
        self
    }
}

/// Runs the filter over a walk.
pub fn run(pass: &Pass) -> Estimate {
    let heading_rad = pass.start.pose.theta_rad;
    let steps = measured(pass.steps, heading_rad, &pass.grid);
    let start = pass.grid.to_grid(pass.start.pose.translation());
    let mut filter = ParticleFilter::new(Setting {
        hexagon: pass.grid.shape(),
        layout: pass.layout,
        prior: pass.prior,
        options: pass.options,
        key: pass.key,
        start: [start.x as f32, start.y as f32],
        start_sigmas: [pass.start.position_sigma_m as f32, pass.start.heading_sigma_rad as f32],
        parallel: pass.parallel,
    });
    let mut mean = vec![pass.start.pose];
    let mut sigma_m = vec![pass.start.position_sigma_m];
    for (k, step) in steps.iter().enumerate() {
        // Never on the last step: the weights are the result.
        let sums = filter.step(step, k + 1 < steps.len());
        let [x, y] = sums.mean();
        let p = pass.grid.to_world(Vec2::new(x, y));
        mean.push(Pose2::new(p.x, p.y, wrap_angle(step.heading_rad + sums.heading_offset_rad())));
        sigma_m.push(sums.sigma());
    }
    let to_world = |[x, y]: [f32; 2]| pass.grid.to_world(Vec2::new(x.into(), y.into()));
    let mut map = TransitionMap::new(pass.grid, pass.layout);
    filter.add_to(&mut map);
    let sampled_paths = match pass.sampled_paths {
        0 => PathTree::default(),
        count => filter.sample(count, to_world),
    };
    Estimate {
        best: filter.path(filter.best()).into_iter().map(to_world).collect(),
        mean,
        sigma_m,
        map,
        sampled_paths,
        log_evidence: filter.log_evidence,
        resamplings: filter.resamplings,
    }
}
