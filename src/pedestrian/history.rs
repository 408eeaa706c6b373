//! The map of one particle is its path: the ids of the hexagons it came through.
//!
//! Since crossings count both ways, N_h and N_h^e follow from looking for h along the path. The recent part of
//! the path is the particle's own [`Tail`]; older parts are [`Chunk`]s that all descendants share. A chunk knows its
//! bounding box, so that most are passed over; what a family of particles has in common becomes a table ([`Visits`]).
//! Consecutive parts overlap by one cell, so that no crossing is lost.

use super::layout::Layout;
use super::visits::Visits;

/// Longest tail.
const TAIL: usize = 96;
/// Longer tails are moved to a chunk between steps; the rest is room for one step's crossings.
const FULL: usize = 64;
/// Crossings in one step at most.
pub const CROSSINGS_PER_STEP: usize = TAIL - FULL;
const NO_CELL: u16 = u16::MAX;
/// No table.
const NONE: u32 = u32::MAX;
/// So many relatives are worth a table.
const FAMILY: usize = 16;
/// Tidy up when this many chunks are listed, and again whenever they have doubled.
const TIDY_AT: usize = 1 << 14;

/// The recent cells of a particle's path, the last one being where it is.
#[derive(Debug, Clone, Copy)]
pub struct Tail {
    cells: [u16; TAIL],
    length: u16,
}

/// An older part of a path, and the box around it.
#[derive(Debug, Clone, Copy)]
struct Chunk {
    low: [u16; 2],
    high: [u16; 2],
    path: Tail,
}

/// What a particle's path was before its tail: a table of the oldest part, then chunks.
#[derive(Debug, PartialEq)]
pub struct Past {
    table: u32,
    chunks: Vec<u32>,
}

impl Clone for Past {
    fn clone(&self) -> Self {
        Past { table: self.table, chunks: self.chunks.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.table = other.table;
        self.chunks.clone_from(&other.chunks); // keeps its memory
    }
}

impl Default for Past {
    fn default() -> Self {
        Past { table: NONE, chunks: Vec::new() }
    }
}

/// The tables and chunks of all particles of a filter.
#[derive(Debug, Clone, Default)]
pub struct Archive {
    tables: Vec<Visits>,
    chunks: Vec<Chunk>,
    /// Chunks that particles have in their lists, about.
    listed: usize,
    tidy_at: usize,
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

    /// How often the path was in a cell.
    #[inline(always)]
    fn stays(&self, cell: u16) -> u16 {
        let mut equal = 0_u16;
        for block in self.cells[..(self.length as usize).next_multiple_of(16)].chunks_exact(16) {
            equal += block.iter().map(|&c| u16::from(c == cell)).sum::<u16>();
        }
        equal
    }

    /// (N_h^e, N_h) of this part of the path, h being the last cell and e leading to `to`.
    #[inline(always)]
    fn counts_here(&self, to: u16) -> (u32, u32) {
        let length = self.length as usize;
        let here = self.cells[length - 1];
        if self.stays(here) == 1 {
            // First time in this cell: the only crossing is the one that led here.
            return match length {
                1 => (0, 0),
                _ => (u32::from(self.cells[length - 2] == to), 1),
            };
        }
        crossings(&self.cells[..length], here, to)
    }

    fn last(&self) -> u16 {
        self.cells[self.length as usize - 1]
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

impl Past {
    /// True if the tail is all there is.
    pub fn is_empty(&self) -> bool {
        self.table == NONE && self.chunks.is_empty()
    }
}

impl Archive {
    /// (N_h^e, N_h) of a whole path, h being its last cell and e the edge that leads to `to`.
    #[inline(always)]
    pub fn counts(&self, layout: &Layout, past: &Past, tail: &Tail, edge: usize, to: u16) -> (u32, u32) {
        let (at_edge, at_cell) = tail.counts_here(to);
        if past.is_empty() {
            return (at_edge, at_cell);
        }
        let (e, c) = self.counts_before(layout, past, tail.last(), edge, to);
        (at_edge + e, at_cell + c)
    }

    fn counts_before(&self, layout: &Layout, past: &Past, here: u16, edge: usize, to: u16) -> (u32, u32) {
        let (mut at_edge, mut at_cell) = match self.tables.get(past.table as usize) {
            Some(table) => table.counts(here, edge),
            None => (0, 0),
        };
        let [column, row] = layout.place(here);
        for &chunk in &past.chunks {
            let chunk = &self.chunks[chunk as usize];
            let inside = (column >= chunk.low[0]) & (column <= chunk.high[0]);
            // Most chunks around a cell never came through it, and looking for one number is quick.
            if inside & (row >= chunk.low[1]) & (row <= chunk.high[1]) && chunk.path.stays(here) > 0 {
                let (e, c) = crossings(chunk.path.cells(), here, to);
                (at_edge, at_cell) = (at_edge + e, at_cell + c);
            }
        }
        (at_edge, at_cell)
    }

    /// Moves a tail that became long to a chunk.
    pub fn flush(&mut self, layout: &Layout, past: &mut Past, tail: &mut Tail) {
        if (tail.length as usize) <= FULL {
            return;
        }
        let (mut low, mut high) = ([u16::MAX; 2], [0; 2]);
        for &cell in tail.cells() {
            for (k, v) in layout.place(cell).into_iter().enumerate() {
                (low[k], high[k]) = (v.min(low[k]), v.max(high[k]));
            }
        }
        past.chunks.push(self.chunks.len() as u32);
        self.chunks.push(Chunk { low, high, path: *tail });
        *tail = Tail::new(tail.last());
        self.listed += 1;
    }

    /// True if it is time for [`Archive::tidy`].
    pub fn wants_tidying(&self) -> bool {
        self.listed > self.tidy_at.max(TIDY_AT)
    }

    /// Turns pieces of past that many particles share into tables, and forgets what no particle holds.
    pub fn tidy(&mut self, layout: &Layout, pasts: &mut [&mut Past]) {
        // Relatives stand side by side after resampling: sorting is not needed, equal neighbours are enough.
        let mut first = 0;
        while first < pasts.len() {
            let (table, oldest) = (pasts[first].table, pasts[first].chunks.first().copied());
            let related = |p: &&&mut Past| p.table == table && p.chunks.first().copied() == oldest;
            let family = pasts[first..].iter().take_while(related).count();
            let Some(oldest) = oldest.filter(|_| family >= FAMILY) else {
                first += family;
                continue;
            };
            // Stays at the same particle: the next chunk may be shared as well.
            let mut grown = self.tables.get(table as usize).cloned().unwrap_or_default();
            grown.add(layout, self.chunks[oldest as usize].path.cells());
            for past in &mut pasts[first..first + family] {
                past.chunks.remove(0);
                past.table = self.tables.len() as u32;
            }
            self.tables.push(grown);
        }
        keep(&mut self.tables, pasts, |past| std::slice::from_mut(&mut past.table));
        keep(&mut self.chunks, pasts, |past| &mut past.chunks);
        self.listed = pasts.iter().map(|p| p.chunks.len()).sum();
        self.tidy_at = 2 * self.listed;
    }

    /// Adds up the crossings of all particles: `path` gets pieces of path, `edge` a cell, one of its edges 0, 1, 2 and
    /// how often; each with the summed weight of the particles that hold it.
    pub fn sum_up<'a>(
        &self,
        particles: impl Iterator<Item = (u64, &'a Past, &'a Tail)>,
        map: &mut impl FnMut(Piece),
    ) {
        let mut chunk_weights = vec![0; self.chunks.len()];
        let mut table_weights = vec![0; self.tables.len()];
        for (weight, past, tail) in particles.filter(|(w, ..)| *w > 0) {
            for &chunk in &past.chunks {
                chunk_weights[chunk as usize] += weight;
            }
            if let Some(table) = table_weights.get_mut(past.table as usize) {
                *table += weight;
            }
            map(Piece::Path(tail.cells(), weight));
        }
        for (chunk, &weight) in self.chunks.iter().zip(&chunk_weights).filter(|(_, w)| **w > 0) {
            map(Piece::Path(chunk.path.cells(), weight));
        }
        for (table, &weight) in self.tables.iter().zip(&table_weights).filter(|(_, w)| **w > 0) {
            for (cell, edge, count) in table.edges() {
                map(Piece::Edge(cell, edge, count * weight));
            }
        }
    }
}

/// Crossings with their weight.
pub enum Piece<'a> {
    /// Along a piece of path.
    Path(&'a [u16], u64),
    /// Of one edge (0, 1 or 2) of a cell.
    Edge(u16, usize, u64),
}

/// Keeps the items that are referred to, in their place in memory, and renumbers the references.
fn keep<T>(items: &mut Vec<T>, pasts: &mut [&mut Past], references: impl Fn(&mut Past) -> &mut [u32]) {
    let mut numbers = vec![NONE; items.len()];
    let mut each = |change: &mut dyn FnMut(&mut u32)| {
        let all = pasts.iter_mut().flat_map(|past| references(past));
        all.filter(|reference| **reference != NONE).for_each(change);
    };
    each(&mut |reference| numbers[*reference as usize] = 0);
    let (mut next, mut kept) = (0, 0);
    items.retain(|_| {
        let number = &mut numbers[next];
        next += 1;
        if *number == NONE {
            return false;
        }
        *number = kept;
        kept += 1;
        true
    });
    each(&mut |reference| *reference = numbers[*reference as usize]);
}
