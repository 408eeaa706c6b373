//! The hexagon grid: cells, edges, and which edges a straight step crosses.
//!
//! Pointy-top hexagons of circumradius R in axial coordinates (q, r): centre x = √3 R (q + r/2), y = 1.5 R r in the
//! **grid frame**, which is turned by `angle_rad` and moved by `origin` against the world. Edge e has the outward
//! normal at 60°·e; the opposite edge is (e + 3) mod 6. Particles live in the grid frame in `f32`, as a cell and an offset
//! from its centre, so precision does not depend on how far they walked.

use crate::geometry::Vec2;

/// √3 / 2: apothem of the unit hexagon.
const HALF_SQRT_3: f32 = 0.866_025_4;

/// Change of (q, r) across each edge.
pub const NEIGHBOURS: [[i16; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];

/// The edge seen from the other side.
#[inline(always)]
pub fn opposite(edge: usize) -> usize {
    if edge < 3 { edge + 3 } else { edge - 3 }
}

/// A hexagon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Cell {
    /// Axial coordinate along the row.
    pub q: i16,
    /// Row.
    pub r: i16,
}

impl Cell {
    /// The cell across `edge`.
    #[inline(always)]
    pub fn across(self, edge: usize) -> Cell {
        let [q, r] = NEIGHBOURS[edge];
        Cell { q: self.q.wrapping_add(q), r: self.r.wrapping_add(r) }
    }
}

/// Where the hexagons lie in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HexGrid {
    /// Circumradius = length of an edge, metres.
    pub radius_m: f64,
    /// Direction of the grid's x axis (normal of edge 0) in the world.
    pub angle_rad: f64,
    /// World position of the centre of cell (0, 0).
    pub origin: Vec2,
}

impl HexGrid {
    /// A world point in the grid frame.
    pub fn to_grid(&self, world: Vec2) -> Vec2 {
        self.rotate_to_grid(world - self.origin)
    }

    /// A world direction in the grid frame.
    pub fn rotate_to_grid(&self, d: Vec2) -> Vec2 {
        let (s, c) = self.angle_rad.sin_cos();
        Vec2::new(c * d.x + s * d.y, -s * d.x + c * d.y)
    }

    /// A point of the grid frame in the world.
    pub fn to_world(&self, p: Vec2) -> Vec2 {
        let (s, c) = self.angle_rad.sin_cos();
        self.origin + Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y)
    }

    /// The geometry of one cell.
    pub fn shape(&self) -> Hexagon {
        Hexagon::new(self.radius_m as f32)
    }

    /// World position of the corners of a cell, counter-clockwise.
    pub fn corners(&self, cell: Cell) -> [Vec2; 6] {
        let [x, y] = self.shape().centre(cell);
        let centre = Vec2::new(x.into(), y.into());
        std::array::from_fn(|k| {
            let (s, c) = (std::f64::consts::FRAC_PI_3 * k as f64 + std::f64::consts::FRAC_PI_6).sin_cos();
            self.to_world(centre + Vec2::new(c, s) * self.radius_m)
        })
    }

    /// World position of a cell's centre.
    pub fn centre(&self, cell: Cell) -> Vec2 {
        let [x, y] = self.shape().centre(cell);
        self.to_world(Vec2::new(x.into(), y.into()))
    }

    /// The cell at a world point.
    pub fn cell_at(&self, world: Vec2) -> Cell {
        let p = self.to_grid(world);
        self.shape().locate([p.x as f32, p.y as f32])
    }
}

/// One cell's geometry in the grid frame; `f32` metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hexagon {
    radius: f32,
    apothem: f32,
    /// Change of the centre across each edge.
    hops: [[f32; 2]; 6],
}

impl Hexagon {
    /// A hexagon of that circumradius.
    pub fn new(radius: f32) -> Self {
        let apothem = radius * HALF_SQRT_3;
        let hop = |e: usize| {
            let [q, r] = NEIGHBOURS[e];
            [2.0 * apothem * (f32::from(q) + f32::from(r) * 0.5), 1.5 * radius * f32::from(r)]
        };
        Hexagon { radius, apothem, hops: std::array::from_fn(hop) }
    }

    /// Centre of a cell.
    #[inline(always)]
    pub fn centre(&self, cell: Cell) -> [f32; 2] {
        [
            2.0 * self.apothem * (f32::from(cell.q) + 0.5 * f32::from(cell.r)),
            1.5 * self.radius * f32::from(cell.r),
        ]
    }

    /// The cell that contains a point: cube rounding.
    pub fn locate(&self, [x, y]: [f32; 2]) -> Cell {
        let qf = (x * (HALF_SQRT_3 / 1.5) - y / 3.0) / self.radius;
        let rf = y / (1.5 * self.radius);
        let sf = -qf - rf;
        let (mut q, mut r, s) = (qf.round(), rf.round(), sf.round());
        let (dq, dr, ds) = ((q - qf).abs(), (r - rf).abs(), (s - sf).abs());
        if dq > dr && dq > ds {
            q = -r - s;
        } else if dr > ds {
            r = -q - s;
        }
        Cell { q: q as i16, r: r as i16 }
    }

    /// The cell of a point, and the point's offset from its centre.
    pub fn enter(&self, [x, y]: [f32; 2]) -> (Cell, [f32; 2]) {
        let cell = self.locate([x, y]);
        let [cx, cy] = self.centre(cell);
        (cell, [x - cx, y - cy])
    }

    /// Walks the straight `step` from `offset` within `cell`; `cross` is called for every edge passed, in order, with
    /// the cell left behind and the edge. At most `limit` edges. Returns the new cell and offset.
    #[inline(always)]
    pub fn walk(
        &self,
        mut cell: Cell,
        [mut x, mut y]: [f32; 2],
        [dx, dy]: [f32; 2],
        limit: usize,
        mut cross: impl FnMut(Cell, usize),
    ) -> (Cell, [f32; 2]) {
        // Motion along the three edge normals; the smallest t at which a side is reached is the exit.
        let (half_x, high_y) = (0.5 * dx, HALF_SQRT_3 * dy);
        let motion = [dx, half_x + high_y, high_y - half_x];
        // Along a side there is no way out through it: t is infinite, and never a NaN.
        let is_still = |v: f32| v.abs() < 1e-30;
        let inverse = motion.map(|v| if is_still(v) { 1.0 } else { 1.0 / v });
        let side = motion.map(|v| if is_still(v) { f32::INFINITY } else { self.apothem.copysign(v) });
        for _ in 0..limit {
            let (half_x, high_y) = (0.5 * x, HALF_SQRT_3 * y);
            let t0 = (side[0] - x) * inverse[0];
            let t1 = (side[1] - (half_x + high_y)) * inverse[1];
            let t2 = (side[2] - (high_y - half_x)) * inverse[2];
            let (mut t, mut axis) = (t0, 0);
            if t1 < t {
                (t, axis) = (t1, 1);
            }
            if t2 < t {
                (t, axis) = (t2, 2);
            }
            if t >= 1.0 {
                break;
            }
            let edge = axis + if motion[axis] < 0.0 { 3 } else { 0 };
            cross(cell, edge);
            cell = cell.across(edge);
            x -= self.hops[edge][0];
            y -= self.hops[edge][1];
        }
        (cell, [x + dx, y + dy])
    }
}
