//! Walkers whose start frames are unknown: where each started, seen from the first.
//!
//! Every walker is mapped alone (FootSLAM); its paths, not its counts, are moved (counts would smear) and drawn on a common
//! grid. How well a walker B fits the map A of those placed so far is the evidence that one map made both,
//!
//! Σ_h [ln B(α + N_A + N_B) − ln B(α + N_A) − ln B(α + N_B) + ln B(α)],  B = multivariate Beta (Dirichlet-multinomial).
//!
//! Candidates come from `super::hough` and are refined by coordinate search. A walker is placed if its evidence is at
//! least `ENOUGH` of what it would be against itself; else it is left out, and mapped alone.

use rayon::prelude::*;

use super::feetslam::Group;
use super::hex::HexGrid;
use super::hough;
use super::layout::Layout;
use super::options::{Options, Start};
use super::transition_map::TransitionMap;
use super::walk::Walk;
use crate::error::Result;
use crate::geometry::{Pose2, Vec2, angle_diff, wrap_angle};

/// Share of its own evidence (against itself) that a walker must reach.
const ENOUGH: f64 = 0.55;
/// Passes of the map that a walker's own evidence is taken against.
const MANY: usize = 4;
/// A second place with more than this share of the best one's evidence makes the best one a guess.
const AMBIGUOUS: f64 = 0.95;
/// Places are different if they are this far apart, metres or radians.
const DIFFERENT: (f64, f64) = (3.0, 0.25);
/// Hexagons on which candidates are compared, and on which the best are refined: walkers' own maps are bent by a metre
/// or two, which finer ones would not forgive. Metres.
const RADII_M: [f64; 2] = [1.5, 0.75];
/// Paths of a walker that are drawn: the posterior's spread smooths the evidence.
const PATHS: usize = 8;
/// Candidates that are refined.
const REFINED: usize = 6;
/// Coordinate search: radians and metres, halved several times.
const FIRST_STEP: [f64; 2] = [0.03, 0.5];
const HALVINGS: usize = 5;

/// Where walkers start.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Start pose of each walker in the first one's frame; of those left out, as if alone.
    pub starts: Vec<Pose2>,
    /// Who was placed.
    pub placed: Vec<bool>,
    /// Evidence over that against itself, per walker; 1 for the first, 0 where several places are as good.
    pub support: Vec<f64>,
    /// Particles times steps.
    pub particle_steps: u64,
}

/// One walker's own map as paths.
struct Shape {
    paths: Vec<Vec<Vec2>>,
    own_evidence: f64,
}

/// Finds the starts; the first walker's is `start`.
///
/// # Errors
/// As [`Group::new`] and [`Group::round`].
pub fn find_starts(walks: &[Walk], start: Start, options: &Options) -> Result<Alignment> {
    let alone = Options { iterations: 0, ..*options };
    // Each in its own frame, with its own aligned grid.
    let shape = |walk: &Walk| -> Result<(Shape, u64)> {
        let mut group = Group::new(std::slice::from_ref(walk), start, &alone)?;
        group.round(0, 0, &[walk.steps.len()], &mut |_| ())?;
        let samples = group.latest()[0].sampled_paths.paths();
        let stride = samples.len().div_ceil(PATHS).max(1);
        let paths: Vec<Vec<Vec2>> = samples.into_iter().step_by(stride).collect();
        Ok((Shape { paths, own_evidence: 0.0 }, group.particle_steps))
    };
    let shapes: Vec<Result<(Shape, u64)>> = walks.par_iter().map(shape).collect();
    let mut particle_steps = 0;
    let mut own = Vec::new();
    for shape in shapes {
        let (shape, steps) = shape?;
        particle_steps += steps;
        own.push(shape);
    }

    let grids =
        RADII_M.map(|radius_m| HexGrid { radius_m, angle_rad: 0.1, origin: start.pose.translation() });
    for shape in &mut own {
        let grid = grids[0];
        let layout = Layout::around(&grid, shape.paths.iter().flatten().copied())?;
        let map = drawn(&grid, layout, &shape.paths, Pose2::IDENTITY);
        // Against a map of many passes along the same way: what a perfect fit could reach.
        let mut many = map.clone();
        (1..MANY).for_each(|_| many.add_map(&map));
        shape.own_evidence = evidence(&many, &map, options.alpha);
    }
    let mut alignment = Alignment {
        starts: vec![start.pose; walks.len()],
        placed: vec![false; walks.len()],
        support: vec![0.0; walks.len()],
        particle_steps,
    };
    (alignment.placed[0], alignment.support[0]) = (true, 1.0);
    let mut motions = vec![Pose2::IDENTITY; walks.len()];
    loop {
        // Everybody not yet placed against everybody placed; the best one is placed, if it is good enough.
        let placed: Vec<Vec<Vec2>> = (0..walks.len())
            .filter(|&j| alignment.placed[j])
            .flat_map(|j| own[j].paths.iter().map(move |p| (j, p)))
            .map(|(j, path)| path.iter().map(|p| motions[j].transform_point(*p)).collect())
            .collect();
        let open: Vec<usize> = (0..walks.len()).filter(|&j| !alignment.placed[j]).collect();
        let fits: Vec<Result<(f64, Pose2)>> =
            open.par_iter().map(|&j| best_motion(&placed, &own[j], &grids, options.alpha)).collect();
        let mut best: Option<(f64, usize)> = None;
        for (&j, fit) in open.iter().zip(fits) {
            let (support, motion) = fit?;
            (alignment.support[j], motions[j]) = (support, motion);
            if best.is_none_or(|(s, _)| support > s) {
                best = Some((support, j));
            }
        }
        let Some((_, j)) = best.filter(|(support, _)| *support >= ENOUGH) else { break };
        alignment.placed[j] = true;
        alignment.starts[j] = motions[j].compose(start.pose);
    }
    Ok(alignment)
}

/// The motion of a shape onto placed paths with the greatest evidence, over that against itself.
fn best_motion(
    placed: &[Vec<Vec2>],
    shape: &Shape,
    grids: &[HexGrid; 2],
    alpha: f64,
) -> Result<(f64, Pose2)> {
    let fixed: Vec<&[Vec2]> = placed.iter().step_by(PATHS).map(Vec::as_slice).collect();
    let moving = &shape.paths[0];
    let mut boards = Vec::new();
    for grid in grids {
        let layout = Layout::around(grid, placed.iter().flatten().copied())?;
        boards.push((*grid, layout, drawn(grid, layout, placed, Pose2::IDENTITY)));
    }
    let score = |board: &(HexGrid, Layout, TransitionMap), motion: Pose2| {
        evidence(&board.2, &drawn(&board.0, board.1, &shape.paths, motion), alpha)
    };
    let mut candidates: Vec<(f64, Pose2)> = hough::candidates(&fixed, &[moving])
        .into_iter()
        .map(|motion| (score(&boards[0], motion), motion))
        .collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let refined = candidates.iter().take(REFINED);
    let mut refined: Vec<(f64, Pose2)> =
        refined.map(|&(value, motion)| refine(value, motion, moving, &|m| score(&boards[0], m))).collect();
    refined.sort_by(|a, b| b.0.total_cmp(&a.0));
    let Some(&(mut value, motion)) = refined.first() else { return Ok((0.0, Pose2::IDENTITY)) };
    let middle = middle(moving);
    let is_other = |other: &Pose2| {
        let apart = other.transform_point(middle) - motion.transform_point(middle);
        apart.norm() > DIFFERENT.0 || angle_diff(other.theta_rad, motion.theta_rad).abs() > DIFFERENT.1
    };
    if refined.iter().any(|(other, m)| *other > AMBIGUOUS * value && is_other(m)) {
        value = 0.0;
    }
    let (_, motion) = refine(score(&boards[1], motion), motion, moving, &|m| score(&boards[1], m));
    Ok((value / shape.own_evidence.max(1.0), motion))
}

/// Coordinate search around a motion; turns are about the middle of the path, so that they do not move it away.
fn refine(mut value: f64, mut motion: Pose2, path: &[Vec2], score: &dyn Fn(Pose2) -> f64) -> (f64, Pose2) {
    let middle = middle(path);
    let [mut turn_rad, mut shift_m] = FIRST_STEP;
    for _ in 0..HALVINGS {
        let mut improved = true;
        while improved {
            improved = false;
            for (turn, x, y) in [
                (1.0, 0.0, 0.0),
                (-1.0, 0.0, 0.0),
                (0.0, 1.0, 0.0),
                (0.0, -1.0, 0.0),
                (0.0, 0.0, 1.0),
                (0.0, 0.0, -1.0),
            ] {
                let centre = motion.transform_point(middle);
                let theta_rad = wrap_angle(motion.theta_rad + turn * turn_rad);
                let moved = Pose2::new(0.0, 0.0, theta_rad).rotate(middle);
                let t = centre - moved + Vec2::new(x, y) * shift_m;
                let trial = Pose2::new(t.x, t.y, theta_rad);
                let trial_value = score(trial);
                if trial_value > value + 1e-6 {
                    (value, motion, improved) = (trial_value, trial, true);
                }
            }
        }
        (turn_rad, shift_m) = (turn_rad / 2.0, shift_m / 2.0);
    }
    (value, motion)
}

fn middle(path: &[Vec2]) -> Vec2 {
    path.iter().sum::<Vec2>() / path.len().max(1) as f64
}

/// Paths, moved, as a map; a walker's paths together count once.
fn drawn(grid: &HexGrid, layout: Layout, paths: &[Vec<Vec2>], motion: Pose2) -> TransitionMap {
    let mut map = TransitionMap::new(*grid, layout);
    for path in paths {
        let moved: Vec<Vec2> = path.iter().map(|p| motion.transform_point(*p)).collect();
        // What lies outside the window would wrap around it; there is nothing there to compare with.
        for part in moved.split(|p| !layout.contains(grid, *p)) {
            map.add_path(part, 1.0 / PATHS as f64);
        }
    }
    map
}

/// ln of how much more likely two maps are if one building made both.
pub fn evidence(a: &TransitionMap, b: &TransitionMap, alpha: f64) -> f64 {
    let ln_beta = |counts: [f64; 6]| {
        let sum: f64 = counts.iter().sum();
        counts.iter().map(|n| ln_gamma(n + alpha)).sum::<f64>() - ln_gamma(sum + 6.0 * alpha)
    };
    let nothing = ln_beta([0.0; 6]);
    let both = b.cells().map(|(cell, _)| {
        let (n_a, n_b) = (a.counts_of(cell), b.counts_of(cell));
        if n_a.iter().sum::<f64>() == 0.0 {
            return 0.0;
        }
        ln_beta(std::array::from_fn(|e| n_a[e] + n_b[e])) - ln_beta(n_a) - ln_beta(n_b) + nothing
    });
    both.sum()
}

/// ln Γ(x) for x > 0, to 1e-10: Stirling's series above 8, the recurrence below.
pub fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut product) = (x, 1.0);
    while x < 8.0 {
        product *= x;
        x += 1.0;
    }
    let i = 1.0 / (x * x);
    let series = (1.0 / 12.0 - i * (1.0 / 360.0 - i * (1.0 / 1260.0 - i / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - f64::ln(product)
}
