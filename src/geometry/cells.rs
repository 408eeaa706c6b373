//! Rays on a grid of square cells.

use super::Vec2;

/// Every cell that a ray passes, in order and none twice: (column, row), those below zero left out. From a
/// place along a unit vector, all in cells (Amanatides & Woo 1987).
pub fn walk_cells(from: Vec2, direction: Vec2, length: f64, mut pass: impl FnMut(usize, usize)) {
    let mut cell = [from.x.floor() as isize, from.y.floor() as isize];
    let axis = |d: f64, at: f64, cell: isize| -> (isize, f64, f64) {
        if d > 0.0 {
            (1, (cell as f64 + 1.0 - at) / d, 1.0 / d)
        } else if d < 0.0 {
            (-1, (cell as f64 - at) / d, -1.0 / d)
        } else {
            (0, f64::INFINITY, f64::INFINITY)
        }
    };
    let (step_x, mut next_x, each_x) = axis(direction.x, from.x, cell[0]);
    let (step_y, mut next_y, each_y) = axis(direction.y, from.y, cell[1]);
    loop {
        if cell[0] >= 0 && cell[1] >= 0 {
            pass(cell[0] as usize, cell[1] as usize);
        }
        if next_x.min(next_y) >= length {
            return;
        }
        if next_x < next_y {
            cell[0] += step_x;
            next_x += each_x;
        } else {
            cell[1] += step_y;
            next_y += each_y;
        }
    }
}
