//! The local map: oriented wall pieces ("surfels") in a grid.
//!
//! Every input point becomes a surfel at the weighted mean of the points around it that face the same way, with the normal
//! of the line through them; one surfel is kept per small voxel and direction. Smoothing takes range noise out of the
//! lines that scans are matched to; facing the same way keeps the two sides of a wall apart.

use std::collections::HashSet;
use std::f64::consts::FRAC_PI_4;

use rayon::prelude::*;

use crate::geometry::{Vec2, principal_direction};

/// Side of a grid cell, metres: about the largest search radius over two.
const CELL_M: f64 = 0.25;
/// Points within this radius are smoothed together, metres.
const SMOOTHING_RADIUS_M: f64 = 0.2;
/// … if their normals agree to within acos of this.
const SMOOTHING_COSINE: f64 = 0.75;
/// One surfel per voxel of this side and eighth of the circle, metres.
const VOXEL_M: f64 = 0.05;
/// Points make a line if their scatter is this much longer than wide …
const LINE_RATIO: f64 = 0.3;
/// … and at least 2 cm long (its variance, m²).
const LINE_VARIANCE_M2: f64 = 4e-4;

/// Where the nearest surfel is looked for first, metres: a little more than their spacing.
const NEAR_M: f64 = 0.06;
/// Surfels that are worth a thread.
const LEAST_WORK: usize = 256;

/// A short piece of wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfel {
    /// Its middle, map frame, metres.
    pub mean: Vec2,
    /// Unit normal towards the side it was seen from.
    pub normal: Vec2,
}

/// Surfels, sorted by grid cell.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfelMap {
    surfels: Vec<Surfel>,
    /// Surfels of cell c are `starts[c]..starts[c + 1]`.
    starts: Vec<u32>,
    corner: Vec2,
    columns: usize,
    rows: usize,
}

impl SurfelMap {
    /// Smooths oriented points (map frame; points without a normal must be left out) into surfels.
    pub fn new(points: Vec<Surfel>) -> Self {
        let raw = Self::sorted(points);
        let mut taken = HashSet::with_capacity(raw.surfels.len() / 2);
        let is_first = |surfel: &&Surfel| {
            let voxel = (surfel.mean / VOXEL_M).map(f64::floor);
            let eighth = (surfel.normal.y.atan2(surfel.normal.x) / FRAC_PI_4).round() as i32 & 7;
            taken.insert((voxel.x as i32, voxel.y as i32, eighth))
        };
        let kept: Vec<&Surfel> = raw.surfels.iter().filter(is_first).collect();
        Self::sorted(kept.into_par_iter().with_min_len(LEAST_WORK).map(|s| raw.smoothed(s)).collect())
    }

    /// All surfels, by cell.
    pub fn surfels(&self) -> &[Surfel] {
        &self.surfels
    }

    /// The nearest surfel within `radius_m` whose normal agrees to within acos of `cosine`; a zero normal agrees
    /// with all.
    pub fn nearest(&self, point: Vec2, normal: Vec2, radius_m: f64, cosine: f64) -> Option<&Surfel> {
        let any = normal == Vec2::zeros();
        let within = |radius_m: f64| {
            let mut best = (radius_m * radius_m, None);
            self.near(point, radius_m, |surfel, distance2| {
                if distance2 < best.0 && (any || surfel.normal.dot(&normal) > cosine) {
                    best = (distance2, Some(surfel));
                }
            });
            best.1
        };
        // Nearly all points of a matched scan have a surfel this near: few cells to look at.
        within(radius_m.min(NEAR_M)).or_else(|| within(radius_m))
    }

    fn smoothed(&self, at: &Surfel) -> Surfel {
        let (mut weight, mut sum, mut scatter) = (0.0, Vec2::zeros(), [0.0; 3]);
        self.near(at.mean, SMOOTHING_RADIUS_M, |other, distance2| {
            if other.normal.dot(&at.normal) > SMOOTHING_COSINE {
                let w = 1.0 - distance2 / (SMOOTHING_RADIUS_M * SMOOTHING_RADIUS_M);
                let d = other.mean - at.mean;
                weight += w;
                sum += d * w;
                scatter[0] += w * d.x * d.x;
                scatter[1] += w * d.x * d.y;
                scatter[2] += w * d.y * d.y;
            }
        });
        let mean = sum / weight;
        let [xx, xy, yy] = [
            scatter[0] / weight - mean.x * mean.x,
            scatter[1] / weight - mean.x * mean.y,
            scatter[2] / weight - mean.y * mean.y,
        ];
        let spread = ((xx - yy) / 2.0).hypot(xy);
        let (narrow, wide) = ((xx + yy) / 2.0 - spread, (xx + yy) / 2.0 + spread);
        let mut normal = at.normal;
        if wide > LINE_VARIANCE_M2 && narrow < LINE_RATIO * wide {
            let (sin, cos) = principal_direction([xx, xy, yy]).sin_cos();
            normal = Vec2::new(-sin, cos);
            if normal.dot(&at.normal) < 0.0 {
                normal = -normal;
            }
        }
        Surfel { mean: at.mean + mean, normal }
    }

    /// Counting sort into cells.
    fn sorted(points: Vec<Surfel>) -> Self {
        let (mut low, mut high) = (Vec2::repeat(f64::INFINITY), Vec2::repeat(f64::NEG_INFINITY));
        for p in &points {
            low = low.inf(&p.mean);
            high = high.sup(&p.mean);
        }
        if points.is_empty() {
            (low, high) = (Vec2::zeros(), Vec2::zeros());
        }
        let size = (high - low) / CELL_M;
        let mut map = SurfelMap {
            surfels: points.clone(),
            starts: Vec::new(),
            corner: low,
            columns: size.x as usize + 1,
            rows: size.y as usize + 1,
        };
        let cell = |p: &Surfel| {
            let at = (p.mean - low) / CELL_M;
            at.y as usize * map.columns + at.x as usize
        };
        let mut starts = vec![0_u32; map.columns * map.rows + 1];
        for p in &points {
            starts[cell(p) + 1] += 1;
        }
        for c in 1..starts.len() {
            starts[c] += starts[c - 1];
        }
        let mut next = starts.clone();
        let mut surfels = points.clone();
        for p in &points {
            let slot = &mut next[cell(p)];
            surfels[*slot as usize] = *p;
            *slot += 1;
        }
        map.surfels = surfels;
        map.starts = starts;
        map
    }

    /// Calls `visit` with every surfel within `radius_m` and its squared distance.
    fn near<'a>(&'a self, point: Vec2, radius_m: f64, mut visit: impl FnMut(&'a Surfel, f64)) {
        let low = (point - self.corner).add_scalar(-radius_m) / CELL_M;
        let high = (point - self.corner).add_scalar(radius_m) / CELL_M;
        if high.x < 0.0 || high.y < 0.0 || low.x >= self.columns as f64 || low.y >= self.rows as f64 {
            return;
        }
        // From here on all is ≥ 0 once clamped, where a cast is a floor.
        let (left, right) = (low.x.max(0.0) as usize, (high.x as usize).min(self.columns - 1));
        let (bottom, top) = (low.y.max(0.0) as usize, (high.y as usize).min(self.rows - 1));
        for row in bottom..=top {
            let from = self.starts[row * self.columns + left] as usize;
            let to = self.starts[row * self.columns + right + 1] as usize;
            for surfel in &self.surfels[from..to] {
                let distance2 = (surfel.mean - point).norm_squared();
                if distance2 < radius_m * radius_m {
                    visit(surfel, distance2);
                }
            }
        }
    }
}
