//! The map of one particle is its path: the ids of the hexagons it came through.
//!
//! Since crossings count both ways, N_h and N_h^e follow from looking for h along the path. The recent part of
//! the path is the particle's own [`Tail`]; older parts are [`Chunk`]s that all descendants share. A chunk knows
//! its bounding box, so that most are passed over. Consecutive parts overlap by one cell, so that no crossing is lost.

use super::layout::Layout;

/// Longest tail.
const TAIL: usize = 96;
/// Longer tails are moved to a chunk between steps; the rest is room for one step's crossings.
const FULL: usize = 64;
/// Crossings in one step at most.
pub const CROSSINGS_PER_STEP: usize = TAIL - FULL;
const NO_CELL: u16 = u16::MAX;

/// The recent cells of a particle's path, the last one being where it is.
#[derive(Debug, Clone, Copy)]
pub struct Tail {
    cells: [u16; TAIL],
    length: u16,
}

/// An older part of a path.
#[derive(Debug, Clone)]
struct Chunk {
    cells: Vec<u16>,
    low: [u16; 2],
    high: [u16; 2],
}

/// The chunks of all particles of a filter.
#[derive(Debug, Clone, Default)]
pub struct Archive {
    chunks: Vec<Chunk>,
    live: usize,
}

impl Tail {
    /// A path that begins in a cell.
    pub fn new(cell: u16) -> Self {
        let mut cells = [NO_CELL; TAIL];
        cells[0] = cell;
        Tail { cells, length: 1 }
    }

    /// Enters a cell.
    #[inline(always)]
    pub fn push(&mut self, cell: u16) {
        if (self.length as usize) < TAIL {
            self.cells[self.length as usize] = cell;
            self.length += 1;
        }
    }

    /// Becomes a copy of another tail.
    #[inline]
    pub fn copy_from(&mut self, other: &Tail) {
        // In steps of 32 cells: what lies behind the length must stay "no cell" for the search in blocks of 16.
        let used =
            (other.length as usize).next_multiple_of(32).max((self.length as usize).next_multiple_of(32));
        self.cells[..used].copy_from_slice(&other.cells[..used]);
        self.length = other.length;
    }

    /// (N_h^e, N_h) of this part of the path, h being the last cell and e leading to `to`.
    #[inline(always)]
    fn counts_here(&self, to: u16) -> (u32, u32) {
        let length = self.length as usize;
        let here = self.cells[length - 1];
        let mut equal = 0_u16;
        for block in self.cells[..length.next_multiple_of(16)].chunks_exact(16) {
            equal += block.iter().map(|&c| u16::from(c == here)).sum::<u16>();
        }
        if equal == 1 {
            // First time in this cell: the only crossing is the one that led here.
            return match length {
                1 => (0, 0),
                _ => (u32::from(self.cells[length - 2] == to), 1),
            };
        }
        crossings(&self.cells[..length], here, to)
    }

    fn cells(&self) -> &[u16] {
        &self.cells[..self.length as usize]
    }
}

/// (crossings between `here` and `to`, crossings at `here`) along a piece of path.
fn crossings(path: &[u16], here: u16, to: u16) -> (u32, u32) {
    let (mut edge, mut all) = (0, 0);
    for pair in path.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        all += u32::from(a == here) + u32::from(b == here);
        edge += u32::from((a == here) & (b == to)) + u32::from((a == to) & (b == here));
    }
    (edge, all)
}

impl Archive {
    /// (N_h^e, N_h) of a whole path, h being its last cell and e leading to `to`.
    #[inline(always)]
    pub fn counts(&self, layout: &Layout, chunks: &[u32], tail: &Tail, to: u16) -> (u32, u32) {
        let (mut edge, mut all) = tail.counts_here(to);
        if chunks.is_empty() {
            return (edge, all);
        }
        let here = tail.cells[tail.length as usize - 1];
        let [column, row] = layout.place(here);
        for &chunk in chunks {
            let chunk = &self.chunks[chunk as usize];
            let inside = (column >= chunk.low[0]) & (column <= chunk.high[0]);
            if inside & (row >= chunk.low[1]) & (row <= chunk.high[1]) && chunk.cells.contains(&here) {
                let (e, a) = crossings(&chunk.cells, here, to);
                (edge, all) = (edge + e, all + a);
            }
        }
        (edge, all)
    }

    /// Moves a tail that became long to a chunk.
    pub fn flush(&mut self, layout: &Layout, chunks: &mut Vec<u32>, tail: &mut Tail) {
        if (tail.length as usize) <= FULL {
            return;
        }
        let (mut low, mut high) = ([u16::MAX; 2], [0; 2]);
        for &cell in tail.cells() {
            for (k, v) in layout.place(cell).into_iter().enumerate() {
                (low[k], high[k]) = (v.min(low[k]), v.max(high[k]));
            }
        }
        chunks.push(self.chunks.len() as u32);
        self.chunks.push(Chunk { cells: tail.cells().to_vec(), low, high });
        *tail = Tail::new(tail.cells[tail.length as usize - 1]);
    }

    /// True if so many chunks have come since the last [`Archive::sweep`] that one is worth while.
    pub fn wants_sweep(&self) -> bool {
        self.chunks.len() > 2 * self.live + (1 << 14)
    }

    /// Forgets the chunks that no particle holds, and renumbers the rest.
    pub fn sweep<'a>(&mut self, holders: impl Iterator<Item = &'a mut Vec<u32>>) {
        let mut renumbered = vec![u32::MAX; self.chunks.len()];
        let mut kept = Vec::new();
        for chunk in holders.flatten() {
            let number = &mut renumbered[*chunk as usize];
            if *number == u32::MAX {
                *number = kept.len() as u32;
                let empty = Chunk { cells: Vec::new(), low: [0; 2], high: [0; 2] };
                kept.push(std::mem::replace(&mut self.chunks[*chunk as usize], empty));
            }
            *chunk = *number;
        }
        self.chunks = kept;
        self.live = self.chunks.len();
    }

    /// Calls `visit` with every piece of path and the summed weight of the particles that hold it.
    pub fn pieces<'a>(
        &self,
        particles: impl Iterator<Item = (u64, &'a [u32], &'a Tail)>,
        mut visit: impl FnMut(&[u16], u64),
    ) {
        let mut weights = vec![0; self.chunks.len()];
        for (weight, chunks, tail) in particles.filter(|(w, ..)| *w > 0) {
            for &chunk in chunks {
                weights[chunk as usize] += weight;
            }
            visit(tail.cells(), weight);
        }
        for (chunk, &weight) in self.chunks.iter().zip(&weights).filter(|(_, w)| **w > 0) {
            visit(&chunk.cells, weight);
        }
    }
}
