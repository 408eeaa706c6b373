//! Robust losses ρ(s) on the squared norm s of a whitened residual (Ceres' convention): ρ(s) ≈ s near zero.

/// A robust loss with its scale c, in standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Loss {
    /// ρ(s) = s: plain least squares.
    #[default]
    None,
    /// ρ(s) = s for s ≤ c², 2c√s − c² beyond.
    Huber(f64),
    /// ρ(s) = c² ln(1 + s/c²).
    Cauchy(f64),
    /// ρ(s) = s / (1 + s/c²).
    GemanMcClure(f64),
}

impl Loss {
    /// c, if it has one.
    pub fn scale(self) -> Option<f64> {
        match self {
            Loss::None => None,
            Loss::Huber(c) | Loss::Cauchy(c) | Loss::GemanMcClure(c) => Some(c),
        }
    }

    /// ρ(s).
    pub fn rho(self, s: f64) -> f64 {
        match self {
            Loss::None => s,
            Loss::Huber(c) if s <= c * c => s,
            Loss::Huber(c) => 2.0 * c * s.sqrt() - c * c,
            Loss::Cauchy(c) => c * c * (s / (c * c)).ln_1p(),
            Loss::GemanMcClure(c) => s / (1.0 + s / (c * c)),
        }
    }

    /// ρ′(s): the weight that the term gets in the normal equations.
    pub fn weight(self, s: f64) -> f64 {
        match self {
            Loss::None => 1.0,
            Loss::Huber(c) if s <= c * c => 1.0,
            Loss::Huber(c) => c / s.sqrt(),
            Loss::Cauchy(c) => 1.0 / (1.0 + s / (c * c)),
            Loss::GemanMcClure(c) => (1.0 + s / (c * c)).powi(-2),
        }
    }
}
