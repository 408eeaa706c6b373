//! Numbers the cells of a window of the grid: 16 bits per cell, so that a particle's path is short.
//!
//! The window is a torus with power-of-two sides: stepping over its border comes in at the other side. It is made
//! larger than any walk, so that this is harmless.

use super::hex::{Cell, HexGrid};
use crate::error::{Error, Result};
use crate::geometry::Vec2;

/// 16 bits. The last id, a corner of the margin, also means "no cell".
const MAX_CELLS: usize = 1 << 16;
/// Room around the dead reckoning: metres, and share of the extent; the second where the first is too much.
const MARGINS: [(f64, f64); 2] = [(10.0, 0.2), (4.0, 0.05)];

/// A window of columns × rows cells; column of a cell = q + ⌊r/2⌋.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    column_bits: u32,
    row_bits: u32,
    /// Column and row of the window's corner.
    corner: [i16; 2],
}

impl Layout {
    /// A window of at least `columns` × `rows` cells (powers of two) from `corner` on.
    fn new(columns: usize, rows: usize, [column, row]: [i16; 2]) -> Self {
        let bits = |n: usize| n.max(8).next_power_of_two().trailing_zeros();
        let (column_bits, row_bits) = (bits(columns), bits(rows));
        // What the power of two gives on top is shared by both sides.
        let spare = |bits: u32, needed: usize| ((1_usize << bits).saturating_sub(needed) / 2) as i16;
        let corner = [column - spare(column_bits, columns), row - spare(row_bits, rows)];
        Layout { column_bits, row_bits, corner }
    }

    /// A window around world points, with room for drift.
    ///
    /// # Errors
    /// [`Error::Input`] if it would need more than 65,536 cells.
    pub fn around(grid: &HexGrid, points: impl IntoIterator<Item = Vec2>) -> Result<Layout> {
        let (mut low, mut high) = (Vec2::zeros(), Vec2::zeros());
        for p in points {
            let p = grid.to_grid(p);
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        for (margin_m, share) in MARGINS {
            let margin = Vec2::repeat(margin_m) + (high - low) * share;
            let (low, high) = (low - margin, high + margin);
            let columns = ((high.x - low.x) / (3f64.sqrt() * grid.radius_m)).ceil() + 2.0;
            let rows = ((high.y - low.y) / (1.5 * grid.radius_m)).ceil() + 2.0;
            if columns.max(rows) > MAX_CELLS as f64 || !columns.is_finite() || !rows.is_finite() {
                continue;
            }
            let corner = grid.shape().locate([low.x as f32, low.y as f32]);
            let corner = [corner.q + corner.r.div_euclid(2), corner.r];
            let layout = Layout::new(columns as usize, rows as usize, corner);
            if layout.len() <= MAX_CELLS {
                return Ok(layout);
            }
        }
        let size = high - low;
        let found = format!("found walks over {:.0} m × {:.0} m", size.x, size.y);
        let message = format!("{found}, expected at most {MAX_CELLS} hexagons: take larger ones");
        Err(Error::input("hexagon radius", message))
    }

    /// The largest window there is, around a world point: for walks that are not known yet.
    pub fn largest(grid: &HexGrid, middle: Vec2) -> Layout {
        const SIDE: i16 = 1 << 8;
        let cell = grid.cell_at(middle);
        Layout::new(
            SIDE as usize,
            SIDE as usize,
            [cell.q + cell.r.div_euclid(2) - SIDE / 2, cell.r - SIDE / 2],
        )
    }

    /// Columns and rows of the window.
    pub fn sides(&self) -> [usize; 2] {
        [1 << self.column_bits, 1 << self.row_bits]
    }

    /// True if a world point lies in the window itself, not only in its wrapped copies.
    pub fn contains(&self, grid: &HexGrid, world: Vec2) -> bool {
        self.holds(grid.cell_at(world))
    }

    /// True if a cell lies in the window itself.
    #[inline(always)]
    pub fn holds(&self, cell: Cell) -> bool {
        self.cell(self.id(cell)) == cell
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        1 << (self.column_bits + self.row_bits)
    }

    /// Never: a window has at least 64 cells.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Id of a cell, below [`Layout::len`].
    #[inline(always)]
    pub fn id(&self, cell: Cell) -> u16 {
        let column = (cell.q.wrapping_add(cell.r >> 1).wrapping_sub(self.corner[0]) as u16)
            & ((1 << self.column_bits) - 1);
        let row = (cell.r.wrapping_sub(self.corner[1]) as u16) & ((1 << self.row_bits) - 1);
        (row << self.column_bits) | column
    }

    /// The cell of an id, within the window.
    pub fn cell(&self, id: u16) -> Cell {
        let [column, row] = self.place(id).map(|v| v as i16);
        let r = self.corner[1].wrapping_add(row);
        Cell { q: self.corner[0].wrapping_add(column).wrapping_sub(r >> 1), r }
    }

    /// Column and row within the window.
    #[inline(always)]
    pub fn place(&self, id: u16) -> [u16; 2] {
        [id & ((1 << self.column_bits) - 1), id >> self.column_bits]
    }

    /// The edge (0, 1 or 2) between two neighbouring cells and the id of the cell that it belongs to.
    #[inline(always)]
    pub fn edge_between(&self, a: u16, b: u16) -> (u16, usize) {
        let ([column_a, row_a], [column_b, row_b]) = (self.place(a), self.place(b));
        let column_mask = (1 << self.column_bits) - 1;
        let row_mask = (1 << self.row_bits) - 1;
        let right = column_b.wrapping_sub(column_a) & column_mask;
        // Odd rows stand half a cell further right: there the upper right neighbour has the next column.
        let odd = (self.corner[1] as u16).wrapping_add(row_a) & 1;
        match row_b.wrapping_sub(row_a) & row_mask {
            0 if right == 1 => (a, 0),
            0 => (b, 0),
            1 if right == odd => (a, 1),
            1 => (a, 2),
            _ if right == odd => (b, 2),
            _ => (b, 1),
        }
    }

    /// Every id.
    pub fn ids(&self) -> impl Iterator<Item = u16> {
        (0..self.len() as u32).map(|id| id as u16)
    }
}
