//! The fast filter against its naive twin: a record per particle, a hash map per particle, cloned when resampled.

use std::collections::HashMap;

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::pedestrian::footslam::{self, Estimate, Pass};
use hitl_slam::pedestrian::hex::{Cell, HexGrid, opposite};
use hitl_slam::pedestrian::motion::{ErrorState, Sigmas, measured};
use hitl_slam::pedestrian::particle_filter::{CROSSINGS_PER_STEP, RESAMPLING_WORD};
use hitl_slam::pedestrian::random::{Key, Normals};
use hitl_slam::pedestrian::transition_map::Prior;
use hitl_slam::pedestrian::weights::{BLOCK, Sums, systematic};
use hitl_slam::pedestrian::{Layout, Norm, Options, Start, Step, TransitionMap};

use crate::support::Dice;

#[derive(Clone)]
struct Particle {
    cell: Cell,
    offset: [f32; 2],
    error: ErrorState,
    weight: f32,
    evidence: f32,
    counts: HashMap<Cell, [u32; 6]>,
    path: Vec<[f32; 2]>,
}

struct Naive {
    best: Vec<[f32; 2]>,
    means: Vec<[f64; 2]>,
    map: TransitionMap,
    resamplings: usize,
}

fn naive(pass: &Pass, prior_map: Option<&TransitionMap>) -> Naive {
    let (options, hexagon, table) = (pass.options, pass.grid.shape(), Normals::table());
    let sigmas = Sigmas::from(&options.noise);
    let start = pass.grid.to_grid(pass.start.pose.translation());
    let absolute = |cell: Cell, offset: [f32; 2]| {
        let [x, y] = hexagon.centre(cell);
        [x + offset[0], y + offset[1]]
    };
    let mut particles: Vec<Particle> = (0..options.particles as u64)
        .map(|i| {
            let [a, b, c, d] = table.four(pass.key.with(0).word(2 * i));
            let [e, ..] = table.four(pass.key.with(0).word(2 * i + 1));
            let sigma = pass.start.position_sigma_m as f32;
            let (cell, offset) = hexagon.enter([start.x as f32 + sigma * a, start.y as f32 + sigma * b]);
            let error = ErrorState::draw(&sigmas, pass.start.heading_sigma_rad as f32, [c, d, e]);
            let path = vec![absolute(cell, offset)];
            Particle { cell, offset, error, weight: 1.0, evidence: 0.0, counts: HashMap::new(), path }
        })
        .collect();
    let (mut rescale, mut resamplings, mut means) = (1.0_f32, 0, Vec::new());
    let steps = measured(pass.steps, pass.start.pose.theta_rad, &pass.grid);
    for (k, step) in steps.iter().enumerate() {
        let key = pass.key.with(k as u64 + 1);
        let mut directions = Vec::new();
        for (i, p) in particles.iter_mut().enumerate() {
            let (error, motion, direction) = p.error.step(&sigmas, step, table.four(key.word(i as u64)));
            p.error = error;
            directions.push(direction);
            let (mut factor, counts) = (rescale, &mut p.counts);
            (p.cell, p.offset) = hexagon.walk(p.cell, p.offset, motion, CROSSINGS_PER_STEP, |cell, edge| {
                let own = counts.entry(cell).or_default();
                let (at_edge, at_cell) = (own[edge], own.iter().sum::<u32>());
                own[edge] += 1;
                counts.entry(cell.across(edge)).or_default()[opposite(edge)] += 1;
                let (edge_prior, cell_prior) = match prior_map {
                    None => (options.alpha as f32, (6.0 * options.alpha) as f32),
                    Some(map) => (
                        (options.alpha + map.count(cell, edge)) as f32,
                        (6.0 * options.alpha + map.counts_of(cell).iter().sum::<f64>()) as f32,
                    ),
                };
                factor *= options.norm_factor() as f32 * (edge_prior + at_edge as f32)
                    / (cell_prior + at_cell as f32);
            });
            p.weight *= factor;
            p.path.push(absolute(p.cell, p.offset));
        }
        let mut sums = Sums::default();
        for (block, directions) in particles.chunks(BLOCK).zip(directions.chunks(BLOCK)) {
            let weights: Vec<f32> = block.iter().map(|p| p.weight).collect();
            let positions: Vec<[f32; 2]> = block.iter().map(|p| *p.path.last().unwrap()).collect();
            sums.add(&Sums::of_block(&weights, &positions, directions));
        }
        means.push(sums.mean());
        rescale = (options.particles as f64 / sums.weight) as f32;
        if k + 1 < steps.len() && sums.effective() < options.resample_below * options.particles as f64 {
            let weights = particles.iter().map(|p| p.weight);
            let parents = systematic(weights, sums.weight, options.particles, key.uniform(RESAMPLING_WORD));
            let child = |&i: &u32| {
                let parent = particles[i as usize].clone();
                Particle { evidence: parent.evidence + parent.weight.ln(), weight: 1.0, ..parent }
            };
            particles = parents.iter().map(child).collect();
            (rescale, resamplings) = (1.0, resamplings + 1);
        }
    }
    let score = |p: &Particle| p.evidence + p.weight.ln();
    let mut best = &particles[0];
    particles.iter().for_each(|p| {
        if score(p) > score(best) {
            best = p
        }
    });
    let sum: f64 = particles.iter().map(|p| f64::from(p.weight)).sum();
    let mut map = TransitionMap::new(pass.grid, pass.layout);
    for p in &particles {
        let fixed = TransitionMap::fixed(f64::from(p.weight) / sum);
        for (&cell, counts) in &p.counts {
            (0..3).for_each(|edge| map.add(cell, edge, fixed * u64::from(counts[edge])));
        }
    }
    Naive { best: best.path.clone(), means, map, resamplings }
}

/// A walk with turns, stops and revisits.
fn random_steps(seed: u64, count: usize) -> Vec<Step> {
    let mut dice = Dice::new(seed);
    let step = |k: usize| Step {
        time_s: k as f64,
        forward_m: if k.is_multiple_of(17) { 0.0 } else { dice.uniform(0.1, 0.7) },
        left_m: if k.is_multiple_of(17) { 0.0 } else { dice.normal(0.05) },
        turn_rad: if k.is_multiple_of(9) { dice.uniform(-2.0, 2.0) } else { 0.0 },
    };
    (0..count).map(step).collect()
}

fn assert_same(fast: &Estimate, naive: &Naive, grid: &HexGrid) {
    let world = |p: [f64; 2]| grid.to_world(Vec2::new(p[0], p[1]));
    let best: Vec<Vec2> = naive.best.iter().map(|p| world(p.map(f64::from))).collect();
    assert_eq!(fast.best, best);
    let means: Vec<Vec2> = fast.mean[1..].iter().map(|p| p.translation()).collect();
    assert_eq!(means, naive.means.iter().map(|&p| world(p)).collect::<Vec<_>>());
    assert_eq!(fast.resamplings, naive.resamplings);
    assert_eq!(fast.map, naive.map);
}

#[test]
fn the_fast_filter_equals_the_naive_one_bit_for_bit() {
    let mut resamplings = 0;
    for (seed, count, particles, norm) in [
        (1, 60, 1500, Norm::Fresh),
        (2, 60, 300, Norm::Literal),
        (3, 40, 2000, Norm::Uniform),
        (4, 700, 60, Norm::Fresh),   // long enough for chunks of path
        (5, 500, 1100, Norm::Fresh), // and for tables of what relatives share, and for lines that died out to be pruned
    ] {
        let steps = random_steps(seed, count);
        let grid = HexGrid { radius_m: 0.5, angle_rad: 0.2 * seed as f64, origin: Vec2::new(0.3, 0.1) };
        let options = Options { particles, norm, ..Options::default() };
        let start = Start { pose: Pose2::new(1.0, 2.0, 0.4), ..Start::default() };
        let walk = hitl_slam::pedestrian::Walk { name: "w".into(), steps: steps.clone() };
        let track: Vec<Vec2> = walk.track(start.pose).iter().map(|p| p.translation()).collect();
        let room = track.iter().flat_map(|p| [p - Vec2::repeat(30.0), p + Vec2::repeat(30.0)]);
        let layout = Layout::around(&grid, room).unwrap();
        let mut others = TransitionMap::new(grid, layout);
        others.add_path(&track, 2.5);
        for prior_map in [None, Some(&others)] {
            let prior = prior_map.map(|map| Prior::new(map, 1.0, options.alpha));
            let pass = Pass {
                steps: &steps,
                start,
                grid,
                layout,
                prior: prior.as_ref(),
                options: &options,
                key: Key::new(seed),
                sampled_paths: 0,
                parallel: seed % 2 == 0,
            };
            let fast = footslam::run(&pass);
            assert_same(&fast, &naive(&pass, prior_map), &grid);
            resamplings += fast.resamplings;
        }
    }
    assert!(resamplings > 100, "{resamplings} resamplings: the test says little");
}

#[test]
fn a_tree_of_paths_draws_the_same_map_as_its_paths_one_by_one() {
    let steps = random_steps(8, 300);
    let grid = HexGrid { radius_m: 0.5, angle_rad: 0.3, origin: Vec2::new(0.1, 0.2) };
    let walk = hitl_slam::pedestrian::Walk { name: "w".into(), steps };
    let track: Vec<Vec2> = walk.track(Pose2::IDENTITY).iter().map(|p| p.translation()).collect();
    let layout = Layout::around(&grid, track.iter().copied()).unwrap();
    let options = Options { particles: 500, ..Options::default() };
    let estimate = footslam::run(&Pass {
        steps: &walk.steps,
        start: Start::default(),
        grid,
        layout,
        prior: None,
        options: &options,
        key: Key::new(3),
        sampled_paths: 64,
        parallel: false,
    });
    let tree = &estimate.sampled_paths;
    let paths = tree.paths();
    assert_eq!((tree.len(), paths.len()), (64, 64));
    assert!(paths.iter().all(|p| p.len() == walk.steps.len() + 1));
    let other_grid = HexGrid { angle_rad: 1.0, ..grid };
    let layout = Layout::around(&other_grid, track).unwrap();
    let (mut together, mut one_by_one) =
        (TransitionMap::new(other_grid, layout), TransitionMap::new(other_grid, layout));
    tree.add_to(&mut together);
    paths.iter().for_each(|p| one_by_one.add_path(p, 1.0 / 64.0));
    assert!(together.total() > 100.0);
    assert_eq!(together, one_by_one);
}
