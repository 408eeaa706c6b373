//! How well one walker's way fits on the map of others, and where best: the evidence, and the search for its maximum.

use super::hex::HexGrid;
use super::hough;
use super::layout::Layout;
use super::options::Options;
use super::transition_map::TransitionMap;
use crate::error::Result;
use crate::geometry::{Pose2, Vec2, angle_diff, wrap_angle};

/// Passes of the map that a walker's own evidence is taken against.
const MANY: usize = 4;
/// Places are different if they are this far apart, metres or radians.
const DIFFERENT: (f64, f64) = (3.0, 0.25);
/// Hexagons on which candidates are compared, and on which the best are refined, metres.
const RADII_M: [f64; 2] = [1.5, 0.75];
/// A path is drawn in copies that are moved by this much, metres: its own uncertainty, and hides the cells' borders.
const BLUR_M: f64 = 0.35;
const COPIES: usize = 7;
/// Candidates that are refined: with few of them the next best place is missed, and a chance fit looks like the only one.
const REFINED: usize = 24;
/// Coordinate search: radians, metres and share of the scale, halved several times.
const FIRST_STEP: [f64; 3] = [0.03, 0.5, 0.01];
const HALVINGS: usize = 4;
/// Scales from which the search begins, if the scale is asked for.
const SCALES: [f64; 5] = [0.94, 0.97, 1.0, 1.03, 1.06];

/// Where a path is put: p ↦ motion · (scale p).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placing {
    pub motion: Pose2,
    pub scale: f64,
}

impl Placing {
    pub fn of(&self, p: Vec2) -> Vec2 {
        self.motion.transform_point(p * self.scale)
    }
}

/// What was found for a walker.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// Evidence of the best place over that against itself.
    pub support: f64,
    /// The same of the best other place.
    pub rival: f64,
    pub placing: Placing,
}

/// A walker's way: where it turns and every few steps (drawn on maps), and after every step (its directions).
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape<'a> {
    pub corners: &'a [Vec2],
    pub path: &'a [Vec2],
}

impl Shape<'_> {
    /// Its evidence against a map of many passes along the same way: what a perfect fit could reach.
    pub fn own_evidence(&self, origin: Vec2, alpha: f64) -> Result<f64> {
        let grid = grid(RADII_M[0], origin);
        let layout = Layout::around(&grid, self.corners.iter().copied())?;
        let map = drawn(&grid, layout, self.corners, |p| p);
        let mut many = map.clone();
        (1..MANY).for_each(|_| many.add_map(&map));
        Ok(evidence(&many, &map, alpha).max(1.0))
    }
}

fn grid(radius_m: f64, origin: Vec2) -> HexGrid {
    HexGrid { radius_m, angle_rad: 0.1, origin }
}

/// The map of those who are placed, coarse and fine.
pub(super) struct Boards<'a> {
    paths: Vec<&'a [Vec2]>,
    boards: [(HexGrid, Layout, TransitionMap); 2],
}

impl<'a> Boards<'a> {
    /// Of shapes that lie where they belong; `origin` is where the hexagons begin.
    pub fn new(shapes: &[Shape<'a>], origin: Vec2) -> Result<Boards<'a>> {
        let board = |radius_m: f64| -> Result<(HexGrid, Layout, TransitionMap)> {
            let grid = grid(radius_m, origin);
            let layout = Layout::around(&grid, shapes.iter().flat_map(|s| s.corners.iter().copied()))?;
            let mut map = TransitionMap::new(grid, layout);
            shapes.iter().for_each(|s| map.add_map(&drawn(&grid, layout, s.corners, |p| p)));
            Ok((grid, layout, map))
        };
        let boards = [board(RADII_M[0])?, board(RADII_M[1])?];
        Ok(Boards { paths: shapes.iter().map(|s| s.path).collect(), boards })
    }

    fn score(&self, board: usize, path: &[Vec2], placing: Placing, alpha: f64) -> f64 {
        let (grid, layout, map) = &self.boards[board];
        evidence(map, &drawn(grid, *layout, path, |p| placing.of(p)), alpha)
    }

    /// The place of a walker with the greatest evidence, and how near the next one comes.
    pub fn best_fit(&self, shape: Shape, own_evidence: f64, options: &Options) -> Option<Fit> {
        let path = shape.corners;
        let scales: &[f64] = if options.align_scale { &SCALES } else { &[1.0] };
        let mut candidates: Vec<(f64, Placing)> = Vec::new();
        for &scale in scales {
            let scaled: Vec<Vec2> = shape.path.iter().map(|p| p * scale).collect();
            let motions = hough::candidates(&self.paths, &[&scaled]);
            let placings = motions.into_iter().map(|motion| Placing { motion, scale });
            candidates.extend(placings.map(|p| (self.score(0, path, p, options.alpha), p)));
        }
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        let centre = middle(path);
        let apart = |a: &Placing, b: &Placing, far: (f64, f64)| {
            (a.of(centre) - b.of(centre)).norm() > far.0
                || angle_diff(a.motion.theta_rad, b.motion.theta_rad).abs() > far.1
        };
        let mut chosen: Vec<(f64, Placing)> = Vec::new();
        for candidate in candidates {
            let near = (DIFFERENT.0 / 2.0, DIFFERENT.1 / 3.0);
            if chosen.len() < REFINED && chosen.iter().all(|(_, c)| apart(c, &candidate.1, near)) {
                chosen.push(candidate);
            }
        }
        let refined = chosen.into_iter().map(|(value, placing)| {
            refine(value, placing, path, options.align_scale, &|p| self.score(0, path, p, options.alpha))
        });
        let mut refined: Vec<(f64, Placing)> = refined.collect();
        refined.sort_by(|a, b| b.0.total_cmp(&a.0));
        let &(value, placing) = refined.first()?;
        let rival = refined.iter().find(|(_, p)| apart(p, &placing, DIFFERENT)).map_or(0.0, |(v, _)| *v);
        let fine = |p| self.score(1, path, p, options.alpha);
        let (_, placing) = refine(fine(placing), placing, path, options.align_scale, &fine);
        (value > 0.0).then(|| Fit { support: value / own_evidence, rival: rival / own_evidence, placing })
    }
}

/// Coordinate search around a placing; turns and scales are about the middle of the path, so that they do not move it away.
fn refine(
    mut value: f64,
    mut placing: Placing,
    path: &[Vec2],
    with_scale: bool,
    score: &dyn Fn(Placing) -> f64,
) -> (f64, Placing) {
    let middle = middle(path);
    let [mut turn_rad, mut shift_m, mut stretch] = FIRST_STEP;
    const DIRECTIONS: [[f64; 4]; 8] = [
        [1.0, 0.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, -1.0],
    ];
    for _ in 0..HALVINGS {
        let mut improved = true;
        while improved {
            improved = false;
            for [turn, x, y, scale] in &DIRECTIONS[..if with_scale { 8 } else { 6 }] {
                let centre = placing.of(middle);
                let theta_rad = wrap_angle(placing.motion.theta_rad + turn * turn_rad);
                let scale = placing.scale * (1.0 + scale * stretch);
                let moved = Pose2::new(0.0, 0.0, theta_rad).rotate(middle * scale);
                let t = centre - moved + Vec2::new(*x, *y) * shift_m;
                let trial = Placing { motion: Pose2::new(t.x, t.y, theta_rad), scale };
                let trial_value = score(trial);
                if trial_value > value + 1e-6 {
                    (value, placing, improved) = (trial_value, trial, true);
                }
            }
        }
        (turn_rad, shift_m, stretch) = (turn_rad / 2.0, shift_m / 2.0, stretch / 2.0);
    }
    (value, placing)
}

fn middle(path: &[Vec2]) -> Vec2 {
    path.iter().sum::<Vec2>() / path.len().max(1) as f64
}

/// A path, moved, as a map: copies a little apart that together count once.
fn drawn(grid: &HexGrid, layout: Layout, path: &[Vec2], moved: impl Fn(Vec2) -> Vec2) -> TransitionMap {
    let mut map = TransitionMap::new(*grid, layout);
    let moved: Vec<Vec2> = path.iter().map(|p| moved(*p)).collect();
    for copy in 0..COPIES {
        let (s, c) = (copy as f64 * std::f64::consts::TAU / (COPIES - 1) as f64).sin_cos();
        let offset = if copy == COPIES - 1 { Vec2::zeros() } else { Vec2::new(c, s) * BLUR_M };
        let copy: Vec<Vec2> = moved.iter().map(|p| p + offset).collect();
        // What lies outside the window would wrap around it; there is nothing there to compare with.
        for part in copy.split(|p| !layout.contains(grid, *p)) {
            map.add_path(part, 1.0 / COPIES as f64);
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
