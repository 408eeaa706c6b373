//! The map: how often the edge between two hexagons was crossed, in either direction.
//!
//! A walk back is as likely as the walk there, so N_h^e = N_h'^opp(e) and one number per undirected edge holds both.
//! Numbers are fixed point (2⁻³²): sums do not depend on their order, and "all walkers but this one" is an exact
//! difference. [`Prior`] is the same as seen by the filter: α + G·N per edge, ready to divide.

use super::hex::{Cell, HexGrid, opposite};
use super::layout::Layout;
use crate::geometry::Vec2;

/// One whole crossing.
const ONE: f64 = (1_u64 << 32) as f64;

/// Crossing counts on a window of a grid.
#[derive(Debug, Clone)]
pub struct TransitionMap {
    /// Where the cells lie.
    pub grid: HexGrid,
    /// How they are numbered.
    pub layout: Layout,
    /// Edges 0, 1, 2 of every cell, in pages; a page without a crossing does not exist.
    pages: Vec<Option<Box<Page>>>,
}

/// Cells of a page: a walk of some minutes comes through a small part of the window.
const PAGE: usize = 64;
type Page = [[u64; 3]; PAGE];

impl TransitionMap {
    /// No crossing yet.
    pub fn new(grid: HexGrid, layout: Layout) -> Self {
        TransitionMap { grid, layout, pages: vec![None; layout.len().div_ceil(PAGE)] }
    }

    /// A weight in 0..=1 (or a number of crossings) as fixed point.
    pub fn fixed(weight: f64) -> u64 {
        (weight * ONE).round() as u64
    }

    /// Adds crossings of the edge between two cells that share one; anything else is left out.
    #[inline]
    pub fn add(&mut self, from: Cell, edge: usize, fixed: u64) {
        let (cell, edge) = if edge < 3 { (from, edge) } else { (from.across(edge), opposite(edge)) };
        self.add_edge(self.layout.id(cell), edge, fixed);
    }

    /// Adds the crossings along a path of cell ids.
    pub fn add_ids(&mut self, path: &[u16], fixed: u64) {
        for pair in path.windows(2) {
            let (id, edge) = self.layout.edge_between(pair[0], pair[1]);
            self.add_edge(id, edge, fixed);
        }
    }

    /// Adds crossings of edge 0, 1 or 2 of the cell of that id.
    #[inline]
    pub fn add_edge(&mut self, id: u16, edge: usize, fixed: u64) {
        let page = self.pages[id as usize / PAGE].get_or_insert_with(|| Box::new([[0; 3]; PAGE]));
        page[id as usize % PAGE][edge] += fixed;
    }

    /// Edges 0, 1, 2 of a cell.
    fn own_edges(&self, id: u16) -> [u64; 3] {
        self.pages[id as usize / PAGE].as_ref().map_or([0; 3], |page| page[id as usize % PAGE])
    }

    /// Expected number of crossings of `edge` of `cell`.
    pub fn count(&self, cell: Cell, edge: usize) -> f64 {
        let (cell, edge) = if edge < 3 { (cell, edge) } else { (cell.across(edge), opposite(edge)) };
        self.own_edges(self.layout.id(cell))[edge] as f64 / ONE
    }

    /// Expected crossings of all six edges of a cell.
    pub fn counts_of(&self, cell: Cell) -> [f64; 6] {
        std::array::from_fn(|edge| self.count(cell, edge))
    }

    /// Adds a path of world points, each crossing counting `weight`.
    pub fn add_path(&mut self, path: &[Vec2], weight: f64) {
        let (shape, fixed) = (self.grid.shape(), TransitionMap::fixed(weight));
        let Some(first) = path.first() else { return };
        let to_grid = |p: Vec2| self.grid.to_grid(p);
        let start = to_grid(*first);
        let (mut cell, mut offset) = shape.enter([start.x as f32, start.y as f32]);
        let mut crossed = Vec::new();
        for pair in path.windows(2) {
            let d = to_grid(pair[1]) - to_grid(pair[0]);
            let limit = (4.0 * d.norm() / self.grid.radius_m) as usize + 4;
            (cell, offset) =
                shape.walk(cell, offset, [d.x as f32, d.y as f32], limit, |c, e| crossed.push((c, e)));
        }
        for (cell, edge) in crossed {
            self.add(cell, edge, fixed);
        }
    }

    /// Adds another map on the same grid.
    pub fn add_map(&mut self, other: &TransitionMap) {
        for (mine, theirs) in self.pages.iter_mut().zip(&other.pages) {
            match (mine, theirs) {
                (Some(mine), Some(theirs)) => {
                    let both = mine.as_flattened_mut().iter_mut().zip(theirs.as_flattened());
                    both.for_each(|(a, b)| *a += b);
                }
                (mine, Some(theirs)) => *mine = Some(theirs.clone()),
                (_, None) => {}
            }
        }
    }

    /// Takes away a map that was added before: the rest is exact.
    pub fn subtract(&mut self, other: &TransitionMap) {
        for (mine, theirs) in self.pages.iter_mut().zip(&other.pages) {
            if let (Some(mine), Some(theirs)) = (mine, theirs) {
                let both = mine.as_flattened_mut().iter_mut().zip(theirs.as_flattened());
                both.for_each(|(a, b)| *a = a.saturating_sub(*b));
            }
        }
    }

    /// All counts that are held.
    fn counts(&self) -> impl Iterator<Item = u64> {
        self.pages.iter().flatten().flat_map(|page| page.as_flattened().iter().copied())
    }

    /// Sum of all crossings.
    pub fn total(&self) -> f64 {
        self.counts().map(|c| c as f64).sum::<f64>() / ONE
    }

    /// How much two maps differ: ½ Σ|a − b| / mean of their sums; 0: equal, 1: nothing in common.
    pub fn change(&self, other: &TransitionMap) -> f64 {
        let difference = |(a, b): (&Option<Box<Page>>, &Option<Box<Page>>)| match (a, b) {
            (Some(a), Some(b)) => {
                let both = a.as_flattened().iter().zip(b.as_flattened());
                both.map(|(a, b)| a.abs_diff(*b) as f64).sum::<f64>()
            }
            (Some(one), None) | (None, Some(one)) => one.as_flattened().iter().map(|&c| c as f64).sum(),
            (None, None) => 0.0,
        };
        let sum: f64 = self.pages.iter().zip(&other.pages).map(difference).sum::<f64>() / ONE;
        let both = self.total() + other.total();
        if both > 0.0 { sum / both } else { 0.0 }
    }

    /// Every edge with crossings: the cell, the edge (0, 1 or 2) and the count.
    pub fn edges(&self) -> impl Iterator<Item = (Cell, usize, f64)> {
        let held = self.pages.iter().enumerate().filter_map(|(k, page)| Some((k, page.as_ref()?)));
        held.flat_map(|(k, page)| page.iter().enumerate().map(move |(i, counts)| (k * PAGE + i, counts)))
            .flat_map(move |(id, counts)| {
                let cell = self.layout.cell(id as u16);
                let crossed = counts.iter().enumerate().filter(|(_, c)| **c > 0);
                crossed.map(move |(edge, &c)| (cell, edge, c as f64 / ONE))
            })
    }

    /// Every cell with a crossing at any of its edges, and the sum of those crossings.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, f64)> {
        let sums = self.layout.ids().map(move |id| {
            let cell = self.layout.cell(id);
            (cell, self.counts_of(cell).iter().sum::<f64>())
        });
        sums.filter(|(_, sum)| *sum > 0.0)
    }
}

impl PartialEq for TransitionMap {
    fn eq(&self, other: &Self) -> bool {
        let empty: Page = [[0; 3]; PAGE];
        let page = |p: &Option<Box<Page>>| p.as_deref().copied().unwrap_or(empty);
        let pages = || self.pages.iter().zip(&other.pages);
        self.grid == other.grid && self.layout == other.layout && pages().all(|(a, b)| page(a) == page(b))
    }
}

/// A map as the filter needs it: Dirichlet parameters per directed edge.
#[derive(Debug, Clone)]
pub struct Prior {
    /// Per cell: α + G·N_h^e for the six edges, their sum, and nothing.
    cells: Vec<[f32; 8]>,
}

impl Prior {
    /// The Dirichlet parameters of `map`, its counts multiplied by `gain`.
    pub fn new(map: &TransitionMap, gain: f64, alpha: f64) -> Self {
        let parameters = |id: u16| {
            let counts = map.counts_of(map.layout.cell(id)).map(|n| gain * n);
            let mut row = [0.0; 8];
            for (parameter, n) in row.iter_mut().zip(counts) {
                *parameter = (alpha + n) as f32;
            }
            row[6] = (6.0 * alpha + counts.iter().sum::<f64>()) as f32;
            row
        };
        Prior { cells: map.layout.ids().map(parameters).collect() }
    }

    /// (α + G·N_h^e, 6α + G·N_h).
    #[inline(always)]
    pub fn at(&self, cell_id: u16, edge: usize) -> (f32, f32) {
        let row = &self.cells[cell_id as usize];
        (row[edge], row[6])
    }
}
