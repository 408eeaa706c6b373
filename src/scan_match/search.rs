//! Correlative search: every pose of a window is tried against a blurred picture of the map (Olson 2009).

use super::SurfelMap;
use crate::geometry::{Pose2, Vec2};

/// Side of a picture cell, metres.
const CELL_M: f64 = 0.1;
/// σ of the blur, metres.
const BLUR_M: f64 = 0.15;
/// Points tried per pose, about.
const POINTS: usize = 150;
/// Score lost at the edge of the window, in position and in heading each: of equal scores the nearest wins.
const DISTANCE_COST: f64 = 0.02;
/// A place further than this from the best one is another place, metres.
const ELSEWHERE_M: f64 = 0.5;

/// A blurred picture of a surfel map: each cell says how near the nearest surfel is, 1 at it.
pub struct Search {
    corner: Vec2,
    columns: usize,
    rows: usize,
    cells: Vec<f32>,
}

/// What to try: ± half-widths and steps around the start.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// ± metres in x and y.
    pub position_m: f64,
    /// ± radians.
    pub heading_rad: f64,
    /// Metres from try to try; a multiple of 0.1.
    pub position_step_m: f64,
    /// Radians from try to try.
    pub heading_step_rad: f64,
}

/// Where the points fit best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// `map_from_robot`.
    pub pose: Pose2,
    /// Mean nearness of the points to the map, 0 to 1, less what the distance from the start costs.
    pub score: f64,
    /// Best score anywhere more than half a metre away, over `score`: near 1 the place is not distinct.
    pub ambiguity: f64,
}

impl Search {
    /// Draws the picture.
    pub fn new(map: &SurfelMap) -> Self {
        let (mut low, mut high) = (Vec2::zeros(), Vec2::zeros());
        if let Some(first) = map.surfels().first() {
            (low, high) = (first.mean, first.mean);
        }
        for s in map.surfels() {
            low = low.inf(&s.mean);
            high = high.sup(&s.mean);
        }
        let reach = (2.0 * BLUR_M / CELL_M).ceil() as i64;
        let corner = low.add_scalar(-(reach as f64 + 1.0) * CELL_M);
        let size = (high - corner).add_scalar((reach as f64 + 1.0) * CELL_M) / CELL_M;
        let (columns, rows) = (size.x as usize + 1, size.y as usize + 1);
        let mut cells = vec![0_f32; columns * rows];
        for s in map.surfels() {
            let at = ((s.mean - corner) / CELL_M).map(f64::floor);
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let distance2 = (dx * dx + dy * dy) as f64 * CELL_M * CELL_M;
                    let value = (-0.5 * distance2 / (BLUR_M * BLUR_M)).exp() as f32;
                    let (x, y) = (at.x as i64 + dx, at.y as i64 + dy);
                    let cell = &mut cells[y as usize * columns + x as usize];
                    *cell = cell.max(value);
                }
            }
        }
        Search { corner, columns, rows, cells }
    }

    /// The best pose of the window around `start` (`map_from_robot`) for these points (robot frame).
    pub fn best(&self, points: &[Vec2], start: Pose2, window: Window) -> Found {
        let stride = (window.position_step_m / CELL_M).round().max(1.0) as i32;
        let step_m = f64::from(stride) * CELL_M;
        let steps = (window.position_m / step_m).ceil() as i32;
        let turns = (window.heading_rad / window.heading_step_rad).ceil() as i32;
        let some: Vec<Vec2> = points.iter().step_by((points.len() / POINTS).max(1)).copied().collect();
        let side = (2 * steps + 1) as usize;
        let shift = |place: usize| {
            let (row, column) = ((place / side) as i32 - steps, (place % side) as i32 - steps);
            Vec2::new(f64::from(column), f64::from(row)) * step_m
        };
        let costs: Vec<f64> = (0..side * side)
            .map(|place| DISTANCE_COST * shift(place).norm() / (f64::from(steps.max(1)) * step_m))
            .collect();
        // The best score at every place, whatever the heading; the sums at one heading.
        let (mut places, mut sums) = (vec![0.0_f64; side * side], vec![0.0_f32; side * side]);
        let mut best = Found { pose: start, score: f64::NEG_INFINITY, ambiguity: 0.0 };
        for turn in -turns..=turns {
            let heading = start.theta_rad + f64::from(turn) * window.heading_step_rad;
            let turned = Pose2::new(start.x_m, start.y_m, heading);
            sums.fill(0.0);
            for p in &some {
                let at = ((turned.transform_point(*p) - self.corner) / CELL_M).map(f64::floor);
                self.add(&mut sums, side, [at.x as i32, at.y as i32], steps, stride);
            }
            let turn_cost = DISTANCE_COST * f64::from(turn.abs()) / f64::from(turns.max(1));
            for (place, &sum) in sums.iter().enumerate() {
                let score = f64::from(sum) / some.len().max(1) as f64;
                places[place] = places[place].max(score);
                let score = score - costs[place] - turn_cost;
                if score > best.score {
                    let at = start.translation() + shift(place);
                    best = Found { pose: Pose2::new(at.x, at.y, heading), score, ambiguity: 0.0 };
                }
            }
        }
        let chosen = best.pose.translation() - start.translation();
        let elsewhere = |place: &usize| (shift(*place) - chosen).norm() > ELSEWHERE_M;
        let second = (0..places.len()).filter(elsewhere).map(|place| places[place]).fold(0.0, f64::max);
        best.ambiguity = (second / best.score.max(1e-9)).min(1.0);
        best
    }

    /// Adds what a point in cell (x, y) scores at every place of the window, row by row.
    fn add(&self, sums: &mut [f32], side: usize, [x, y]: [i32; 2], steps: i32, stride: i32) {
        let (width, height) = (self.columns as i32, self.rows as i32);
        // First and last step that stay within the picture.
        let range = |at: i32, size: i32| {
            let first = (-at).div_euclid(stride) + i32::from((-at).rem_euclid(stride) != 0);
            (first.max(-steps), (size - 1 - at).div_euclid(stride).min(steps))
        };
        let ((left, right), (bottom, top)) = (range(x, width), range(y, height));
        if left > right {
            return;
        }
        for row in bottom..=top {
            let start = (y + row * stride) as usize * self.columns + (x + left * stride) as usize;
            let from = (row + steps) as usize * side + (left + steps) as usize;
            let cells = self.cells[start..].iter().step_by(stride as usize);
            for (sum, cell) in sums[from..=from + (right - left) as usize].iter_mut().zip(cells) {
                *sum += cell;
            }
        }
    }
}
