//! Graduated non-convexity: truncated least squares, approached from a problem without local minima.
//!
//! H. Yang, P. Antonante, V. Tzoumas, L. Carlone, *Graduated Non-Convexity for Robust Spatial Perception*, RA-L 2020
//! (GNC-TLS, eqs. 12–14). Knows weights only; who solves the weighted problem is somebody else's business.

/// μ grows by this factor a round (their value).
const GROWTH: f64 = 1.4;

/// From here on the weights are those of truncated least squares, for all that matters.
const LARGEST: f64 = 1e4;

/// The surrogate of one round: ρ_μ, between a convex function (μ → 0) and min(s, s̄) (μ → ∞).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gnc {
    /// s̄: squared norms from here on are outliers.
    threshold: f64,
    /// μ > 0.
    control: f64,
}

impl Gnc {
    /// The first round, for terms whose largest squared norm is `largest`; `None` where none exceeds the threshold
    /// (> 0): nothing is suspicious.
    pub fn start(threshold: f64, largest: f64) -> Option<Self> {
        let control = threshold / (2.0 * largest - threshold);
        (largest > threshold).then_some(Gnc { threshold, control: control.max(f64::MIN_POSITIVE) })
    }

    /// Weight of a term with squared norm `s`, 0 to 1.
    pub fn weight(self, s: f64) -> f64 {
        let Gnc { threshold, control } = self;
        if s >= threshold * (1.0 + 1.0 / control) {
            0.0
        } else if s * (1.0 + 1.0 / control) <= threshold {
            1.0
        } else {
            ((threshold / s * control * (control + 1.0)).sqrt() - control).clamp(0.0, 1.0)
        }
    }

    /// The next round; `None` after the last.
    pub fn next(self) -> Option<Self> {
        let control = self.control * GROWTH;
        (control <= LARGEST).then_some(Gnc { control, ..self })
    }

    /// Share of all rounds that lie behind, 0 to 1, if the first one was `first`.
    pub fn progress(self, first: Self) -> f64 {
        ((self.control / first.control).ln() / (LARGEST / first.control).ln()).clamp(0.0, 1.0)
    }
}

/// The squared norm that a whitened residual of three normal rows stays below with this probability (0 to 1, exclusive):
/// quantile of χ² with three degrees of freedom.
pub fn chi2_quantile_3(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while cumulative_chi2_3(high) < probability && high < 1e4 {
        (low, high) = (high, 2.0 * high);
    }
    while high - low > 1e-13 * high {
        let middle = 0.5 * (low + high);
        *(if cumulative_chi2_3(middle) < probability { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// ∫₀^√x √(2/π)·t²·exp(−t²/2) dt by Simpson's rule.
fn cumulative_chi2_3(x: f64) -> f64 {
    const HALVES: usize = 400;
    let density = |t: f64| (2.0 / std::f64::consts::PI).sqrt() * t * t * (-0.5 * t * t).exp();
    let h = x.sqrt() / (2 * HALVES) as f64;
    let sum: f64 = (0..=2 * HALVES)
        .map(|k| {
            let weight = if k == 0 || k == 2 * HALVES { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
            weight * density(k as f64 * h)
        })
        .sum();
    sum * h / 3.0
}
