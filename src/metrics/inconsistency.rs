//! The paper's pairwise inconsistency I = Σ_{i<j} I_ij: the area that pose i saw free and pose j saw occupied.
//!
//! On a grid of square cells, for each pose by itself: **occupied** is a cell that holds a return; **free** is a cell
//! that a ray passes up to the margin before its own return and whose middle is at least the margin from the middle of
//! every occupied cell of that pose. Without the margin grazing rays decide everything, and the true map scores no
//! better than a bent one (docs/MATH.md).
//!
//! Naively that is a loop over pairs of poses. But per cell it is a count, so one pass over the rays is enough: going
//! along the poses, every occupied cell adds the number of earlier poses that saw it free. Runs of poses are counted
//! in parallel and joined; whole numbers, so the result is the same for any number of threads.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2, walk_cells};
use crate::map::SlamMap;

/// More cells than this are refused: a stray return a kilometre away must not fill the memory.
const MOST_CELLS: f64 = 1.5e8;

/// The cell rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InconsistencyOptions {
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// How far before its return a ray stops to show free space, and how far a free cell is from every return, metres.
    pub free_margin_m: f64,
}

impl Default for InconsistencyOptions {
    fn default() -> Self {
        InconsistencyOptions { resolution_m: 0.05, free_margin_m: 0.3 }
    }
}

/// How much a map contradicts itself, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Inconsistency {
    /// I, m².
    pub area_m2: f64,
    /// Contradictions: cells counted once for every pair of poses i < j of which i saw them free and j occupied.
    pub pairs: u64,
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// Every cell with a contradiction: its middle in the world frame and how many it has; row by row.
    pub cells: Vec<(Vec2, u64)>,
}

/// Measures a map.
///
/// # Errors
/// [`Error::Input`] for options out of range, or a map too large for cells of that size.
pub fn inconsistency(map: &SlamMap, options: &InconsistencyOptions) -> Result<Inconsistency> {
    let InconsistencyOptions { resolution_m, free_margin_m } = *options;
    if !(resolution_m.is_finite() && resolution_m > 0.0) {
        return Err(Error::input("resolution", format_args!("found {resolution_m}, expected a number > 0")));
    }
    if !(free_margin_m.is_finite() && (0.0..=100.0).contains(&(free_margin_m / resolution_m))) {
        let message = format_args!("found {free_margin_m}, expected 0 or more, at most 100 cells");
        return Err(Error::input("free margin", message));
    }
    let grid = Grid::around(map, resolution_m)?;
    let disc = disc(free_margin_m / resolution_m);
    let workers = rayon::current_num_threads().clamp(1, map.poses.len().max(1));
    let share = map.poses.len().div_ceil(workers).max(1);
    let runs: Vec<Run> = (0..workers)
        .into_par_iter()
        .map(|k| {
            let mut run = Run::new(grid.columns * grid.rows);
            let mut scan = Scan::default();
            for pose in (k * share).min(map.poses.len())..((k + 1) * share).min(map.poses.len()) {
                scan.read(map, pose, &grid, &disc, free_margin_m);
                run.take(&scan);
            }
            run
        })
        .collect();
    let contradictions = |cell: usize| -> u64 {
        let (mut sum, mut seen_free) = (0, 0);
        for run in &runs {
            sum += u64::from(run.within[cell]) + seen_free * u64::from(run.occupied[cell]);
            seen_free += u64::from(run.free[cell]);
        }
        sum
    };
    let cells: Vec<(Vec2, u64)> = (0..grid.columns * grid.rows)
        .into_par_iter()
        .map(|cell| (cell, contradictions(cell)))
        .filter(|&(_, count)| count > 0)
        .map(|(cell, count)| (grid.middle(cell), count))
        .collect();
    let pairs = cells.iter().map(|c| c.1).sum();
    Ok(Inconsistency { area_m2: pairs as f64 * resolution_m * resolution_m, pairs, resolution_m, cells })
}

/// The cells around a map, row by row.
struct Grid {
    origin: Vec2,
    resolution_m: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    fn around(map: &SlamMap, resolution_m: f64) -> Result<Grid> {
        let corners = (0..map.poses.len()).into_par_iter().map(|pose| {
            let world_from_robot = map.poses[pose];
            let laser = world_from_robot.transform_point(map.robot_from_laser.translation());
            let points = map.observations.range(pose).map(|k| map.observations.point(k));
            points
                .map(|p| world_from_robot.transform_point(p))
                .fold((laser, laser), |(a, b), p| (a.inf(&p), b.sup(&p)))
        });
        let both = |(a, b): (Vec2, Vec2), (c, d): (Vec2, Vec2)| (a.inf(&c), b.sup(&d));
        let (low, high) = corners.reduce_with(both).unwrap_or((Vec2::zeros(), Vec2::zeros()));
        let count = ((high - low) / resolution_m).map(|n| n.floor() + 1.0);
        let cells = count.x * count.y;
        if cells.is_nan() || cells > MOST_CELLS {
            let message = format_args!(
                "found {:.0} m by {:.0} m, expected a map of at most {MOST_CELLS:.0} cells: try a coarser resolution",
                high.x - low.x,
                high.y - low.y
            );
            return Err(Error::input("map: extent", message));
        }
        Ok(Grid { origin: low, resolution_m, columns: count.x as usize, rows: count.y as usize })
    }

    /// In cells from the origin.
    fn place(&self, p: Vec2) -> Vec2 {
        (p - self.origin) / self.resolution_m
    }

    fn cell(&self, place: Vec2) -> [usize; 2] {
        [(place.x as usize).min(self.columns - 1), (place.y as usize).min(self.rows - 1)]
    }

    fn middle(&self, cell: usize) -> Vec2 {
        let (row, column) = (cell / self.columns, cell % self.columns);
        self.origin + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.resolution_m
    }
}

/// For each row offset the half-width of a disc, in cells: the cells whose middles are nearer than `radius` cells.
fn disc(radius: f64) -> Vec<(isize, isize)> {
    let reach = radius.ceil() as isize;
    let half_width = |row: isize| {
        (0..=reach).rev().find(|column| ((column * column + row * row) as f64) < radius * radius)
    };
    (-reach..=reach).filter_map(|row| Some((row, half_width(row)?))).collect()
}

/// What a run of poses saw, per cell.
struct Run {
    free: Vec<u32>,
    occupied: Vec<u32>,
    /// Contradictions within the run.
    within: Vec<u32>,
}

impl Run {
    fn new(cells: usize) -> Self {
        Run { free: vec![0; cells], occupied: vec![0; cells], within: vec![0; cells] }
    }

    fn take(&mut self, scan: &Scan) {
        for &cell in &scan.occupied {
            self.within[cell as usize] += self.free[cell as usize];
            self.occupied[cell as usize] += 1;
        }
        for &cell in &scan.free {
            self.free[cell as usize] += 1;
        }
    }
}

const NEAR_A_RETURN: u8 = 1;
const OCCUPIED: u8 = 2;
const FREE: u8 = 4;

/// The cells that one pose saw.
#[derive(Default)]
struct Scan {
    free: Vec<u32>,
    occupied: Vec<u32>,
    /// Marks in the box around the scan, row by row.
    marks: Vec<u8>,
    ends: Vec<Vec2>,
}

impl Scan {
    fn read(&mut self, map: &SlamMap, pose: usize, grid: &Grid, disc: &[(isize, isize)], margin_m: f64) {
        self.free.clear();
        self.occupied.clear();
        self.ends.clear();
        let world_from_robot: Pose2 = map.poses[pose];
        let (sin, cos) = world_from_robot.theta_rad.sin_cos();
        let to_world = |p: Vec2| {
            Vec2::new(
                cos * p.x - sin * p.y + world_from_robot.x_m,
                sin * p.x + cos * p.y + world_from_robot.y_m,
            )
        };
        let from = grid.place(to_world(map.robot_from_laser.translation()));
        self.ends
            .extend(map.observations.range(pose).map(|k| grid.place(to_world(map.observations.point(k)))));
        let (low, high) = self.ends.iter().fold((from, from), |(a, b), p| (a.inf(p), b.sup(p)));
        let ([left, bottom], [right, top]) = (grid.cell(low), grid.cell(high));
        let (width, height) = (right - left + 1, top - bottom + 1);
        self.marks.clear();
        self.marks.resize(width * height, 0);

        for &end in &self.ends {
            let [column, row] = grid.cell(end);
            let mark = &mut self.marks[(row - bottom) * width + column - left];
            if *mark & OCCUPIED != 0 {
                continue;
            }
            *mark |= OCCUPIED;
            self.occupied.push((row * grid.columns + column) as u32);
            let (column, row) = ((column - left) as isize, (row - bottom) as isize);
            for &(up, half) in disc {
                let y = row + up;
                if y < 0 || y >= height as isize {
                    continue;
                }
                let start = y as usize * width;
                let (first, last) =
                    ((column - half).max(0) as usize, (column + half).min(width as isize - 1) as usize);
                for mark in &mut self.marks[start + first..=start + last] {
                    *mark |= NEAR_A_RETURN;
                }
            }
        }
        let margin = margin_m / grid.resolution_m;
        for &end in &self.ends {
            let way = end - from;
            let length = way.norm();
            if length <= margin {
                continue;
            }
            let (marks, free) = (&mut self.marks, &mut self.free);
            walk_cells(from, way / length, length - margin, |column, row| {
                let (Some(x), Some(y)) = (column.checked_sub(left), row.checked_sub(bottom)) else { return };
                if x < width && y < height && marks[y * width + x] == 0 {
                    marks[y * width + x] = FREE;
                    free.push((row * grid.columns + column) as u32);
                }
            });
        }
    }
}
