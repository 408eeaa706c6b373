//! Crossing counts of a piece of path that many particles share, by cell: a small hash table.
//!
//! Looking up a cell costs the same after one lap and after a hundred.

use super::layout::Layout;

/// Counts per edge of a cell stop here; N_h is their sum.
const MOST: u16 = 10_000;
const EMPTY: u16 = u16::MAX;

/// One cell: its id, N_h, and N_h^e for the six edges.
#[derive(Debug, Clone, Copy)]
struct Entry {
    cell: u16,
    all: u16,
    edges: [u16; 6],
}

const VACANT: Entry = Entry { cell: EMPTY, all: 0, edges: [0; 6] };

/// The table.
#[derive(Debug, Clone)]
pub struct Visits {
    /// Open addressing; a power of two, at most half full.
    entries: Vec<Entry>,
    used: usize,
}

impl Default for Visits {
    fn default() -> Self {
        Visits { entries: vec![VACANT; 64], used: 0 }
    }
}

impl Visits {
    /// (N_h^e, N_h) of cell h and edge e.
    #[inline]
    pub fn counts(&self, cell: u16, edge: usize) -> (u32, u32) {
        let entry = &self.entries[self.slot(cell)];
        if entry.cell == EMPTY { (0, 0) } else { (entry.edges[edge].into(), entry.all.into()) }
    }

    /// Adds the crossings along a piece of path.
    pub fn add(&mut self, layout: &Layout, path: &[u16]) {
        for pair in path.windows(2) {
            let (low, edge) = layout.edge_between(pair[0], pair[1]);
            let high = if low == pair[0] { pair[1] } else { pair[0] };
            self.count(low, edge);
            self.count(high, edge + 3);
        }
    }

    /// Every crossed edge 0, 1 or 2: cell, edge, count.
    pub fn edges(&self) -> impl Iterator<Item = (u16, usize, u64)> {
        let counted = self.entries.iter().filter(|e| e.cell != EMPTY);
        counted.flat_map(|e| (0..3).map(|k| (e.cell, k, u64::from(e.edges[k]))))
    }

    fn count(&mut self, cell: u16, edge: usize) {
        if 2 * self.used >= self.entries.len() {
            let old = std::mem::take(&mut self.entries);
            self.entries = vec![VACANT; 2 * old.len()];
            for entry in old.into_iter().filter(|e| e.cell != EMPTY) {
                let slot = self.slot(entry.cell);
                self.entries[slot] = entry;
            }
        }
        let slot = self.slot(cell);
        let entry = &mut self.entries[slot];
        if entry.cell == EMPTY {
            entry.cell = cell;
            self.used += 1;
        }
        if entry.edges[edge] < MOST {
            entry.edges[edge] += 1;
            entry.all += 1;
        }
    }

    /// Where a cell is, or the vacant place where it would be.
    #[inline]
    fn slot(&self, cell: u16) -> usize {
        let mask = self.entries.len() - 1;
        let mut slot = (u32::from(cell).wrapping_mul(0x9E37_79B1) >> 12) as usize & mask;
        while self.entries[slot].cell != cell && self.entries[slot].cell != EMPTY {
            slot = (slot + 1) & mask;
        }
        slot
    }
}
