//! Mean and scatter of a handful of points, numerically sound for points on a line.

use super::Vec2;

/// Mean of some points and the square root of their scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Number of points, ≥ 1.
    pub count: usize,
    /// Mean, metres.
    pub mean: Vec2,
    /// (r11, r12, r22) of the upper triangular W with WᵀW = Σ (q − mean)(q − mean)ᵀ, metres.
    pub root: [f64; 3],
}

impl Scatter {
    /// Of the points that `points` yields, which must be at least one.
    ///
    /// W by modified Gram–Schmidt on the centred columns: a Cholesky of the scatter itself would fail on a
    /// straight wall, where it is singular.
    pub fn of(points: impl Iterator<Item = Vec2> + Clone) -> Scatter {
        let count = points.clone().count();
        let mean = points.clone().sum::<Vec2>() / count as f64;
        let centred = points.map(|p| p - mean);
        let r11 = centred.clone().map(|q| q.x * q.x).sum::<f64>().sqrt();
        let r12 = if r11 > 0.0 { centred.clone().map(|q| q.x * q.y).sum::<f64>() / r11 } else { 0.0 };
        let slope = if r11 > 0.0 { r12 / r11 } else { 0.0 };
        let r22 = centred.map(|q| (q.y - slope * q.x).powi(2)).sum::<f64>().sqrt();
        Scatter { count, mean, root: [r11, r12, r22] }
    }

    /// Σ (q − mean)(q − mean)ᵀ as (xx, xy, yy), m².
    pub fn second_moments(&self) -> [f64; 3] {
        let [r11, r12, r22] = self.root;
        [r11 * r11, r11 * r12, r12 * r12 + r22 * r22]
    }
}

impl Scatter {
    /// Σ (distance to the best line)², m²: the smaller eigenvalue of the scatter.
    pub fn across_squared(&self) -> f64 {
        let [xx, xy, yy] = self.second_moments();
        // The larger eigenvalue and the determinant, which the root gives without cancellation.
        let larger = (xx + yy) / 2.0 + ((xx - yy) / 2.0).hypot(xy);
        let determinant = (self.root[0] * self.root[2]).powi(2);
        if larger > 0.0 { determinant / larger } else { 0.0 }
    }
}

/// Direction of the principal axis of a scatter (xx, xy, yy), radians in (−π/2, π/2].
pub fn principal_direction([xx, xy, yy]: [f64; 3]) -> f64 {
    0.5 * (2.0 * xy).atan2(xx - yy)
}
