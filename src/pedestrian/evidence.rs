//! How much more likely two sets of ways are if one building made both: the Dirichlet-multinomial evidence, ready for many trials.
//!
//! ln p = Σ_h [ln B(α + N_A + N_B) − ln B(α + N_A) − ln B(α + N_B) + ln B(α)], B = multivariate Beta, h over the hexagons.
//!
//! Ways are drawn in [`COPIES`] that are a little apart and together count once, so every count is a whole number of copies: ln Γ comes
//! from tables, ln B(α + N_A) is kept per hexagon, and a trial only visits the hexagons that it comes through.

use super::hex::{Cell, HexGrid, opposite};
use super::layout::Layout;
use crate::error::Result;
use crate::geometry::Vec2;

/// A path is drawn in copies that are moved by this much, metres: its own uncertainty, and hides the cells' borders.
pub const BLUR_M: f64 = 0.35;
/// So many copies count as one path: six around, one in the middle.
pub const COPIES: usize = 7;
/// Table entries beyond what the map itself has, copies; a greater count is computed.
const ROOM: usize = 1_024;

/// Crossings of the six edges of a cell, copies; their sum; and nothing.
type Counts = [u32; 8];

/// The ways of those who are placed, ready to be compared with others.
#[derive(Debug, Clone)]
pub struct Board {
    grid: HexGrid,
    layout: Layout,
    alpha: f64,
    counts: Vec<Counts>,
    /// ln B(α + N_A) − ln B(α) per cell, where there are ways; else NaN.
    ln_beta: Vec<f64>,
    /// ln Γ(n/COPIES + α) and ln Γ(n/COPIES + 6α).
    tables: [Vec<f64>; 2],
}

/// Room for one trial after the other.
#[derive(Debug, Clone, Default)]
pub struct Trial {
    counts: Vec<Counts>,
    touched: Vec<u16>,
}

impl Trial {
    fn clear(&mut self, cells: usize) {
        for id in self.touched.drain(..) {
            self.counts[id as usize] = [0; 8];
        }
        self.counts.resize(cells, [0; 8]);
    }
}

impl Board {
    /// Of these paths on hexagons of that grid; α as in the filter.
    ///
    /// # Errors
    /// [`crate::error::Error::Input`] if they would need too many hexagons.
    pub fn new(grid: HexGrid, paths: &[&[Vec2]], alpha: f64) -> Result<Board> {
        let layout = Layout::around(&grid, paths.iter().flat_map(|p| p.iter().copied()))?;
        let mut counts = vec![[0; 8]; layout.len()];
        for path in paths {
            draw(&grid, &layout, path, |cell, edge| counts[layout.id(cell) as usize][edge] += 1);
        }
        for cell in &mut counts {
            cell[6] = cell[..6].iter().sum();
        }
        let table = |kind: usize, most: u32| -> Vec<f64> {
            let shift = if kind == 0 { alpha } else { 6.0 * alpha };
            (0..most as usize + ROOM).map(|n| ln_gamma(n as f64 / COPIES as f64 + shift)).collect()
        };
        let most = |from: usize, to: usize| counts.iter().flat_map(|c| c[from..to].iter().copied()).max();
        let tables = [table(0, most(0, 6).unwrap_or(0)), table(1, most(6, 7).unwrap_or(0))];
        let mut board = Board { grid, layout, alpha, counts, ln_beta: Vec::new(), tables };
        let nothing = board.ln_beta(&[0; 8]);
        let own = |c: &Counts| if c[6] == 0 { f64::NAN } else { board.ln_beta(c) - nothing };
        board.ln_beta = board.counts.iter().map(own).collect();
        Ok(board)
    }

    /// The evidence that one building made these ways and that path, natural logarithm; 0 where they do not meet.
    pub fn evidence(&self, path: &[Vec2], trial: &mut Trial) -> f64 {
        trial.clear(self.counts.len());
        let Trial { counts, touched } = trial;
        draw(&self.grid, &self.layout, path, |cell, edge| {
            let id = self.layout.id(cell);
            // Where nobody was there is nothing to compare with.
            if self.counts[id as usize][6] > 0 {
                let cell = &mut counts[id as usize];
                if cell[6] == 0 {
                    touched.push(id);
                }
                cell[edge] += 1;
                cell[6] += 1;
            }
        });
        let one = |&id: &u16| {
            let (a, b) = (&self.counts[id as usize], &counts[id as usize]);
            let both = std::array::from_fn(|e| a[e] + b[e]);
            self.ln_beta(&both) - self.ln_beta[id as usize] - self.ln_beta(b)
        };
        touched.iter().map(one).sum()
    }

    /// ln B(α + N).
    #[inline]
    fn ln_beta(&self, n: &Counts) -> f64 {
        let gamma = |kind: usize, n: u32, shift: f64| match self.tables[kind].get(n as usize) {
            Some(known) => *known,
            None => ln_gamma(f64::from(n) / COPIES as f64 + shift),
        };
        let edges: f64 = n[..6].iter().map(|&n| gamma(0, n, self.alpha)).sum();
        edges - gamma(1, n[6], 6.0 * self.alpha)
    }
}

/// Calls `cross` for both cells of every edge that the copies of a path come through, with the edge as that cell has it. What lies
/// outside the window is left out: it would wrap around, and there is nothing there to compare with.
fn draw(grid: &HexGrid, layout: &Layout, path: &[Vec2], mut cross: impl FnMut(Cell, usize)) {
    let shape = grid.shape();
    let (s, c) = grid.angle_rad.sin_cos();
    for copy in 0..COPIES {
        let offset = offset_of(copy) - grid.origin;
        let mut before: Option<(Vec2, (Cell, [f32; 2]))> = None;
        for p in path {
            let p = p + offset;
            let p = Vec2::new(c * p.x + s * p.y, -s * p.x + c * p.y);
            let to = [p.x as f32, p.y as f32];
            let inside = layout.holds(shape.locate(to));
            before = match before {
                _ if !inside => None,
                None => Some((p, shape.enter(to))),
                Some((last, (cell, offset))) => {
                    let d = p - last;
                    let limit = (4.0 * d.norm() / grid.radius_m) as usize + 4;
                    let step = [d.x as f32, d.y as f32];
                    let there = shape.walk(cell, offset, step, limit, |cell, edge| {
                        cross(cell, edge);
                        cross(cell.across(edge), opposite(edge));
                    });
                    Some((p, there))
                }
            };
        }
    }
}

/// How far a copy of a path is moved.
pub fn offset_of(copy: usize) -> Vec2 {
    if copy + 1 == COPIES {
        return Vec2::zeros();
    }
    let (s, c) = (copy as f64 * std::f64::consts::TAU / (COPIES - 1) as f64).sin_cos();
    Vec2::new(c, s) * BLUR_M
}

/// ln Γ(x) for x > 0, to 1e-10: Stirling's series above 8, the recurrence below.
pub fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut product) = (x, 1.0);
    while x < 8.0 {
        product *= x;
        x += 1.0;
    }
    let i = 1.0 / (x * x);
    let series = (1.0 / 12.0 - i * (1.0 / 360.0 - i * (1.0 / 1260.0 - i / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - f64::ln(product)
}
