//! Numbers the cells of a window of the grid: 16 bits per cell, so that a particle's path is short.
//!
//! The window is a torus with power-of-two sides: stepping over its border comes in at the other side. It is made
//! larger than any walk, so that this is harmless.

use super::hex::{Cell, HexGrid};
use crate::error::{Error, Result};
use crate::geometry::Vec2;

/// 16 bits. The last id, a corner of the margin, also means "no cell".
const MAX_CELLS: usize = 1 << 16;
/// Room around the dead reckoning: metres, and share of the extent.
const MARGIN_M: f64 = 4.0;
const MARGIN_SHARE: f64 = 0.05;

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
    fn new(columns: usize, rows: usize, corner: [i16; 2]) -> Self {
        let bits = |n: usize| n.max(8).next_power_of_two().trailing_zeros();
        Layout { column_bits: bits(columns), row_bits: bits(rows), corner }
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
        let margin = Vec2::repeat(MARGIN_M) + (high - low) * MARGIN_SHARE;
        let (low, high) = (low - margin, high + margin);
        let size = high - low;
        let columns = (size.x / (3f64.sqrt() * grid.radius_m)).ceil() + 2.0;
        let rows = (size.y / (1.5 * grid.radius_m)).ceil() + 2.0;
        let area = (columns.max(8.0).log2().ceil() + rows.max(8.0).log2().ceil()).exp2();
        if area > MAX_CELLS as f64 || area.is_nan() {
            let found = format!("found walks over {:.0} m × {:.0} m", high.x - low.x, high.y - low.y);
            let message = format!("{found}, expected at most {MAX_CELLS} hexagons: take larger ones");
            return Err(Error::input("hexagon radius", message));
        }
        let corner = grid.shape().locate([low.x as f32, low.y as f32]);
        let corner = [corner.q + corner.r.div_euclid(2), corner.r];
        Ok(Layout::new(columns as usize, rows as usize, corner))
    }

    /// True if a world point lies in the window itself, not only in its wrapped copies.
    pub fn contains(&self, grid: &HexGrid, world: Vec2) -> bool {
        let cell = grid.cell_at(world);
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
