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
    /// Metres from try to try.
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
        let steps = (window.position_m / window.position_step_m).ceil() as i32;
        let turns = (window.heading_rad / window.heading_step_rad).ceil() as i32;
        let some: Vec<Vec2> = points.iter().step_by((points.len() / POINTS).max(1)).copied().collect();
        let side = (2 * steps + 1) as usize;
        let shift = |k: i32| f64::from(k) * window.position_step_m;
        // The best score at every place, whatever the heading.
        let mut places = vec![0.0_f64; side * side];
        let mut best = Found { pose: start, score: f64::NEG_INFINITY, ambiguity: 0.0 };
        for turn in -turns..=turns {
            let heading = start.theta_rad + f64::from(turn) * window.heading_step_rad;
            let turned = Pose2::new(start.x_m, start.y_m, heading);
            let at: Vec<Vec2> =
                some.iter().map(|p| (turned.transform_point(*p) - self.corner) / CELL_M).collect();
            for row in -steps..=steps {
                for column in -steps..=steps {
                    let score = self.score(&at, Vec2::new(shift(column), shift(row)) / CELL_M);
                    let place = &mut places[(row + steps) as usize * side + (column + steps) as usize];
                    *place = place.max(score);
                    let far = f64::from(column).hypot(f64::from(row)) / f64::from(steps.max(1))
                        + f64::from(turn.abs()) / f64::from(turns.max(1));
                    let score = score - DISTANCE_COST * far;
                    if score > best.score {
                        best.pose = Pose2::new(start.x_m + shift(column), start.y_m + shift(row), heading);
                        best.score = score;
                    }
                }
            }
        }
        let mut second = 0.0_f64;
        for (k, &place) in places.iter().enumerate() {
            let (row, column) = ((k / side) as i32 - steps, (k % side) as i32 - steps);
            let at = Vec2::new(start.x_m + shift(column), start.y_m + shift(row));
            if (at - best.pose.translation()).norm() > ELSEWHERE_M {
                second = second.max(place);
            }
        }
        best.ambiguity = second / best.score.max(1e-9);
        best
    }

    fn score(&self, at: &[Vec2], shift: Vec2) -> f64 {
        let mut sum = 0.0_f32;
        for p in at {
            let q = p + shift;
            if q.x >= 0.0 && q.y >= 0.0 && q.x < self.columns as f64 && q.y < self.rows as f64 {
                sum += self.cells[q.y as usize * self.columns + q.x as usize];
            }
        }
        f64::from(sum) / at.len().max(1) as f64
    }
}
