//! FootSLAM: one walker, one pass over the walk, with or without a prior map.

use rayon::prelude::*;

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

/// Islands that are off by more than this many times as much as the most central one do not count for the mean.
const ASTRAY: f64 = 2.0;

/// Runs several filters that know nothing of each other, each with its share of the particles. The best path and the map
/// are those of the filter whose best path is the most central: the least sum of distances to the others' paths. The
/// mean is that of the particles of all filters but those astray.
///
/// When a long loop closes, few ancestors survive, however many particles there are; where the map lies and how it
/// is turned is then as good as drawn once from what was possible. The most central of several draws is off by less
/// than one, their mean by less still, and a filter that closed a loop wrongly is not chosen.
pub fn run_islands(pass: &Pass) -> Estimate {
    let islands = pass.options.islands;
    let options = Options { particles: pass.options.particles / islands, islands: 1, ..*pass.options };
    let island = |k: usize| run(&Pass { options: &options, key: pass.key.with(k as u64), ..*pass });
    let mut estimates: Vec<Estimate> = (0..islands).into_par_iter().map(island).collect();
    let apart =
        |a: &Estimate, b: &Estimate| -> f64 { a.best.iter().zip(&b.best).map(|(p, q)| (p - q).norm()).sum() };
    let offs: Vec<f64> = estimates.iter().map(|a| estimates.iter().map(|b| apart(a, b)).sum()).collect();
    let central = (0..islands).min_by(|&a, &b| offs[a].total_cmp(&offs[b])).unwrap_or(0);
    let counting: Vec<&Estimate> = estimates
        .iter()
        .zip(&offs)
        .filter(|(_, off)| **off <= ASTRAY * offs[central])
        .map(|(e, _)| e)
        .collect();
    let (mean, sigma_m) = (0..=pass.steps.len()).map(|k| pooled(&counting, k)).unzip();
    Estimate { mean, sigma_m, ..estimates.swap_remove(central) }
}

/// Mean and standard deviation per axis of the particles of several filters after step k.
fn pooled(estimates: &[&Estimate], k: usize) -> (Pose2, f64) {
    let count = estimates.len() as f64;
    let centre = estimates.iter().map(|e| e.mean[k].translation()).sum::<Vec2>() / count;
    let (sin, cos) = estimates.iter().fold((0.0, 0.0), |(sin, cos), e| {
        let (s, c) = e.mean[k].theta_rad.sin_cos();
        (sin + s, cos + c)
    });
    let square =
        |e: &&Estimate| e.sigma_m[k].powi(2) + (e.mean[k].translation() - centre).norm_squared() / 2.0;
    let variance = estimates.iter().map(square).sum::<f64>() / count;
    (Pose2::new(centre.x, centre.y, f64::atan2(sin, cos)), variance.sqrt())
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
