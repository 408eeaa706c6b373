//! Finds ways through a building: a raster of the free space, and shortest paths that keep away from walls.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::error::{Error, Result};
use crate::geometry::{Segment, Vec2};

/// Side of a raster cell, metres.
const CELL_M: f64 = 0.25;
/// Cells must be this many from the nearest wall: people fit through a door of 0.9 m.
const BODY_CELLS: u16 = 2;
/// Inside a building there is a wall within so many cells in so many of eight directions.
const ENCLOSED: (usize, usize) = (80, 7);
/// Nearer to a wall than this a way costs more, metres.
const COMFORT_M: f64 = 1.0;

/// The free space of a building.
pub struct Planner {
    origin: Vec2,
    columns: usize,
    rows: usize,
    /// Distance to the nearest wall in cells, chessboard metric; 0: wall.
    clearance: Vec<u16>,
    /// Cells of the largest connected free space.
    free: Vec<usize>,
    in_free: Vec<bool>,
}

impl Planner {
    /// The free space between walls.
    ///
    /// # Errors
    /// [`Error::Input`] if there is none to speak of.
    pub fn new(walls: &[Segment]) -> Result<Planner> {
        let closed = || Error::input("plan", "found no free space between the walls, expected a building");
        let ends = || walls.iter().flat_map(Segment::ends);
        let first = ends().next().ok_or_else(closed)?;
        let (low, high) = ends().fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let size = high - low;
        let (columns, rows) = ((size.x / CELL_M) as usize + 1, (size.y / CELL_M) as usize + 1);
        let mut planner = Planner {
            origin: low,
            columns,
            rows,
            clearance: vec![u16::MAX; columns * rows],
            free: Vec::new(),
            in_free: vec![false; columns * rows],
        };
        for wall in walls {
            let [p, q] = wall.ends();
            let samples = ((q - p).norm() / (0.4 * CELL_M)).ceil().max(1.0) as usize;
            for k in 0..=samples {
                let cell = planner.cell(p + (q - p) * (k as f64 / samples as f64));
                planner.clearance[cell] = 0;
            }
        }
        planner.spread_clearance();
        planner.find_free_space();
        if planner.free.len() > 100 { Ok(planner) } else { Err(closed()) }
    }

    /// A free place, by a number in [0, 1).
    pub fn place(&self, share: f64) -> Vec2 {
        let index = (share * self.free.len() as f64) as usize;
        self.centre(self.free[index.min(self.free.len() - 1)])
    }

    /// A way between two free places: corners of a polyline, the ends included.
    pub fn way(&self, from: Vec2, to: Vec2) -> Option<Vec<Vec2>> {
        let (start, goal) = (self.cell(from), self.cell(to));
        let mut cost = vec![u32::MAX; self.clearance.len()];
        let mut came_from = vec![usize::MAX; self.clearance.len()];
        let mut open = BinaryHeap::from([(Reverse(0), start)]);
        cost[start] = 0;
        while let Some((Reverse(reached), cell)) = open.pop() {
            if cell == goal {
                break;
            }
            if reached > cost[cell] {
                continue;
            }
            for (next, length) in self.neighbours(cell) {
                if !self.in_free[next] {
                    continue;
                }
                let near = (COMFORT_M / CELL_M - f64::from(self.clearance[next])).max(0.0) as u32;
                let total = reached + length * (1 + near);
                if total < cost[next] {
                    (cost[next], came_from[next]) = (total, cell);
                    open.push((Reverse(total), next));
                }
            }
        }
        if came_from[goal] == usize::MAX {
            return None;
        }
        let mut cells = vec![goal];
        while let Some(&last) = cells.last().filter(|&&c| c != start) {
            cells.push(came_from[last]);
        }
        cells.reverse();
        Some(self.simplified(&cells))
    }

    /// Fewer corners: goes straight as long as that keeps the clearance of the way there.
    fn simplified(&self, cells: &[usize]) -> Vec<Vec2> {
        let mut corners = vec![self.centre(cells[0])];
        let mut from = 0;
        while from + 1 < cells.len() {
            let mut to = from + 1;
            let mut needed = self.clearance[cells[from]].min(self.clearance[cells[to]]);
            while to + 1 < cells.len() {
                let next_needed = needed.min(self.clearance[cells[to + 1]]);
                if !self.is_clear(cells[from], cells[to + 1], next_needed) {
                    break;
                }
                (to, needed) = (to + 1, next_needed);
            }
            corners.push(self.centre(cells[to]));
            from = to;
        }
        corners
    }

    fn is_clear(&self, a: usize, b: usize, needed: u16) -> bool {
        let (p, q) = (self.centre(a), self.centre(b));
        let samples = ((q - p).norm() / (0.5 * CELL_M)).ceil() as usize;
        (0..=samples).all(|k| {
            let cell = self.cell(p + (q - p) * (k as f64 / samples.max(1) as f64));
            self.in_free[cell] && self.clearance[cell] >= needed
        })
    }

    fn cell(&self, p: Vec2) -> usize {
        let d = (p - self.origin) / CELL_M;
        let column = (d.x.max(0.0) as usize).min(self.columns - 1);
        let row = (d.y.max(0.0) as usize).min(self.rows - 1);
        row * self.columns + column
    }

    fn centre(&self, cell: usize) -> Vec2 {
        let (column, row) = (cell % self.columns, cell / self.columns);
        self.origin + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * CELL_M
    }

    /// The up to eight neighbours and the length of the way there (5: straight, 7: diagonal).
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = (usize, u32)> + use<> {
        let (columns, rows) = (self.columns as isize, self.rows as isize);
        let (column, row) = (cell as isize % columns, cell as isize / columns);
        (0..9).filter(|k| *k != 4).filter_map(move |k| {
            let (dx, dy) = (k % 3 - 1, k / 3 - 1);
            let (x, y) = (column + dx, row + dy);
            let inside = x >= 0 && y >= 0 && x < columns && y < rows;
            inside.then_some(((y * columns + x) as usize, if dx != 0 && dy != 0 { 7 } else { 5 }))
        })
    }

    fn spread_clearance(&mut self) {
        let mut front: Vec<usize> = (0..self.clearance.len()).filter(|&c| self.clearance[c] == 0).collect();
        let mut distance = 0;
        while !front.is_empty() {
            distance += 1;
            let mut next = Vec::new();
            for cell in front {
                for (near, _) in self.neighbours(cell) {
                    if self.clearance[near] == u16::MAX {
                        self.clearance[near] = distance;
                        next.push(near);
                    }
                }
            }
            front = next;
        }
    }

    /// True if there are walls around a cell.
    fn is_enclosed(&self, cell: usize) -> bool {
        let (far, enough) = ENCLOSED;
        let (column, row) = ((cell % self.columns) as isize, (cell / self.columns) as isize);
        let sees_wall = |k: &isize| {
            let (dx, dy) = (k % 3 - 1, k / 3 - 1);
            (1..far as isize).any(|n| {
                let (x, y) = (column + n * dx, row + n * dy);
                let inside = x >= 0 && y >= 0 && x < self.columns as isize && y < self.rows as isize;
                inside && self.clearance[y as usize * self.columns + x as usize] == 0
            })
        };
        (0..9).filter(|k| *k != 4).filter(sees_wall).count() >= enough
    }

    /// The largest connected part of the enclosed cells with room for a body.
    fn find_free_space(&mut self) {
        let open: Vec<bool> = (0..self.clearance.len())
            .map(|cell| self.clearance[cell] >= BODY_CELLS && self.is_enclosed(cell))
            .collect();
        let mut seen = vec![false; self.clearance.len()];
        let mut best = Vec::new();
        for seed in 0..self.clearance.len() {
            if seen[seed] || !open[seed] {
                continue;
            }
            let (mut part, mut next) = (vec![seed], 0);
            seen[seed] = true;
            while next < part.len() {
                let cell = part[next];
                next += 1;
                for (near, _) in self.neighbours(cell) {
                    if !seen[near] && open[near] {
                        seen[near] = true;
                        part.push(near);
                    }
                }
            }
            if part.len() > best.len() {
                best = part;
            }
        }
        best.iter().for_each(|&c| self.in_free[c] = true);
        self.free = best;
    }
}
