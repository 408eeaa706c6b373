//! A world of straight walls, and what a ray hits first.
//!
//! Rays walk a uniform grid whose cells list the walls near them, so a cast costs the walls along the ray and not
//! all walls of a campus. Metres, world frame. Walls have no thickness and block from both sides.

use crate::geometry::Vec2;
pub use crate::map::Wall;

/// Cells are at least this wide, and wider where the world would otherwise need more than [`MAX_CELLS`].
const CELL_M: f64 = 1.0;
const MAX_CELLS: f64 = 1e6;

/// The first wall on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin, metres.
    pub range_m: f64,
    /// Index into [`World::walls`].
    pub wall: usize,
    /// Where on the wall, metres from its first end.
    pub along_m: f64,
}

/// Walls with an index for casting rays.
#[derive(Debug, Clone)]
pub struct World {
    walls: Vec<Wall>,
    ends: Vec<[Vec2; 2]>,
    origin: Vec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
    /// Walls that come near each cell, row by row.
    cells: Vec<Vec<u32>>,
}

impl World {
    /// Indexes `walls`; all end points must be finite.
    pub fn new(walls: Vec<Wall>) -> Self {
        let ends: Vec<[Vec2; 2]> = walls.iter().map(|w| w.segment.ends()).collect();
        let (mut low, mut high) = (Vec2::zeros(), Vec2::zeros());
        for (k, p) in ends.iter().flatten().enumerate() {
            (low, high) = if k == 0 { (*p, *p) } else { (low.inf(p), high.sup(p)) };
        }
        let size = high - low;
        let cell_m = CELL_M.max((size.x * size.y / MAX_CELLS).sqrt()).max(size.amax() / MAX_CELLS);
        let columns = (size.x / cell_m) as usize + 1;
        let rows = (size.y / cell_m) as usize + 1;
        let mut cells = vec![Vec::new(); columns * rows];
        for (k, (wall, [p, q])) in walls.iter().zip(&ends).enumerate() {
            let cell = |v: f64, low: f64, count: usize| (((v - low) / cell_m) as usize).min(count - 1);
            let column_of = |x: f64| cell(x, low.x, columns);
            let row_of = |y: f64| cell(y, low.y, rows);
            for row in row_of(p.y.min(q.y))..=row_of(p.y.max(q.y)) {
                for column in column_of(p.x.min(q.x))..=column_of(p.x.max(q.x)) {
                    let centre = low + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * cell_m;
                    // The circle around the cell: a ray that slips through a corner still meets the wall.
                    if wall.segment.along_across(centre).1.abs() <= 0.7072 * cell_m {
                        cells[row * columns + column].push(k as u32);
                    }
                }
            }
        }
        World { walls, ends, origin: low, cell_m, columns, rows, cells }
    }

    /// Every wall, in the order given.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The wall of that name and its index.
    pub fn wall(&self, name: &str) -> Option<(usize, &Wall)> {
        self.walls.iter().enumerate().find(|(_, w)| w.name == name)
    }

    /// The first wall from `origin` along the unit vector `direction`, not farther than `max_range_m`, which is finite.
    pub fn cast(&self, origin: Vec2, direction: Vec2, max_range_m: f64) -> Option<Hit> {
        let start = (origin - self.origin) / self.cell_m;
        let mut cell = [start.x.floor(), start.y.floor()];
        // Ray parameter, in metres, at which the next cell border is crossed, per axis.
        let border = |axis: usize| -> (f64, f64) {
            let d = direction[axis];
            if d == 0.0 {
                return (f64::INFINITY, f64::INFINITY);
            }
            let to_border = if d > 0.0 { cell[axis] + 1.0 - start[axis] } else { start[axis] - cell[axis] };
            (to_border * self.cell_m / d.abs(), self.cell_m / d.abs())
        };
        let ((mut next_x, step_x), (mut next_y, step_y)) = (border(0), border(1));
        let (mut best, mut entered_m) = (None::<Hit>, 0.0);
        while entered_m <= best.map_or(max_range_m, |hit| hit.range_m) {
            for &wall in self.near(cell) {
                if let Some((range_m, along_m)) = crossing(origin, direction, &self.ends[wall as usize])
                    && range_m <= best.map_or(max_range_m, |hit| hit.range_m)
                {
                    best = Some(Hit { range_m, wall: wall as usize, along_m });
                }
            }
            if next_x < next_y {
                (entered_m, cell[0], next_x) = (next_x, cell[0] + direction.x.signum(), next_x + step_x);
            } else {
                (entered_m, cell[1], next_y) = (next_y, cell[1] + direction.y.signum(), next_y + step_y);
            }
        }
        best
    }

    fn near(&self, [column, row]: [f64; 2]) -> &[u32] {
        if column < 0.0 || row < 0.0 || column >= self.columns as f64 || row >= self.rows as f64 {
            return &[];
        }
        &self.cells[row as usize * self.columns + column as usize]
    }
}

/// Where a ray crosses the segment p–q, if it does: the distances from its origin and from p.
fn crossing(origin: Vec2, direction: Vec2, [p, q]: &[Vec2; 2]) -> Option<(f64, f64)> {
    let (along, to_p) = (q - p, p - origin);
    let determinant = direction.perp(&along);
    if determinant == 0.0 {
        return None;
    }
    let range_m = to_p.perp(&along) / determinant;
    let share = to_p.perp(&direction) / determinant;
    (range_m >= 0.0 && (0.0..=1.0).contains(&share)).then_some((range_m, share * along.norm()))
}
