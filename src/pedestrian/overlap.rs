//! How well one walker's way fits on the map of others, and where best: the evidence, and the search for its maximum.

use rayon::prelude::*;

use super::evidence::{Board, Trial};
use super::hex::HexGrid;
use super::hough;
use super::options::Options;
use crate::error::Result;
use crate::geometry::{Pose2, Vec2, angle_diff, wrap_angle};

/// Passes of the map that a walker's own evidence is taken against.
const MANY: usize = 4;
/// Places are different if they are this far apart, metres or radians.
const DIFFERENT: (f64, f64) = (3.0, 0.25);
/// Hexagons on which candidates are compared, and on which the best are refined, metres.
const RADII_M: [f64; 2] = [1.5, 0.75];
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

    /// The same of many points, into a buffer.
    fn of_all(&self, path: &[Vec2], moved: &mut Vec<Vec2>) {
        let (s, c) = self.motion.theta_rad.sin_cos();
        let (s, c, t) = (self.scale * s, self.scale * c, self.motion.translation());
        moved.clear();
        moved.extend(path.iter().map(|p| Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y) + t));
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
        let board = Board::new(grid(RADII_M[0], origin), &[self.corners; MANY], alpha)?;
        Ok(board.evidence(self.corners, &mut Trial::default()).max(1.0))
    }
}

fn grid(radius_m: f64, origin: Vec2) -> HexGrid {
    HexGrid { radius_m, angle_rad: 0.1, origin }
}

/// The ways of those who are placed, coarse and fine.
pub(super) struct Boards<'a> {
    paths: Vec<&'a [Vec2]>,
    boards: [Board; 2],
}

/// Buffers of one thread.
#[derive(Default)]
struct Buffers {
    moved: Vec<Vec2>,
    trial: Trial,
}

impl<'a> Boards<'a> {
    /// Of shapes that lie where they belong; `origin` is where the hexagons begin.
    pub fn new(shapes: &[Shape<'a>], origin: Vec2, alpha: f64) -> Result<Boards<'a>> {
        let corners: Vec<&[Vec2]> = shapes.iter().map(|s| s.corners).collect();
        let board = |radius_m: f64| Board::new(grid(radius_m, origin), &corners, alpha);
        let boards = [board(RADII_M[0])?, board(RADII_M[1])?];
        Ok(Boards { paths: shapes.iter().map(|s| s.path).collect(), boards })
    }

    fn score(&self, board: usize, path: &[Vec2], placing: Placing, buffers: &mut Buffers) -> f64 {
        placing.of_all(path, &mut buffers.moved);
        self.boards[board].evidence(&buffers.moved, &mut buffers.trial)
    }

    /// The place of a walker with the greatest evidence, and how near the next one comes.
    pub fn best_fit(&self, shape: Shape, own_evidence: f64, options: &Options) -> Option<Fit> {
        let path = shape.corners;
        let scales: &[f64] = if options.align_scale { &SCALES } else { &[1.0] };
        let mut candidates: Vec<(f64, Placing)> = Vec::new();
        for &scale in scales {
            let scaled: Vec<Vec2> = shape.path.iter().map(|p| p * scale).collect();
            let motions = hough::candidates(&self.paths, &[&scaled]);
            let placings = motions.into_par_iter().map(|motion| Placing { motion, scale });
            let scored =
                placings.map_init(Buffers::default, |buffers, p| (self.score(0, path, p, buffers), p));
            candidates.par_extend(scored);
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
        let refined = chosen.into_par_iter().map_init(Buffers::default, |buffers, (value, placing)| {
            refine(value, placing, path, options.align_scale, &mut |p| self.score(0, path, p, buffers))
        });
        let mut refined: Vec<(f64, Placing)> = refined.collect();
        refined.sort_by(|a, b| b.0.total_cmp(&a.0));
        let &(value, placing) = refined.first()?;
        let rival = refined.iter().find(|(_, p)| apart(p, &placing, DIFFERENT)).map_or(0.0, |(v, _)| *v);
        let mut buffers = Buffers::default();
        let mut fine = |p| self.score(1, path, p, &mut buffers);
        let (_, placing) = refine(fine(placing), placing, path, options.align_scale, &mut fine);
        (value > 0.0).then(|| Fit { support: value / own_evidence, rival: rival / own_evidence, placing })
    }
}

/// Coordinate search around a placing; turns and scales are about the middle of the path, so that they do not move it away.
fn refine(
    mut value: f64,
    mut placing: Placing,
    path: &[Vec2],
    with_scale: bool,
    score: &mut dyn FnMut(Placing) -> f64,
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
