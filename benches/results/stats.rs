//! Means with 95 % intervals by Student's t.

/// A sample of one quantity over many runs.
#[derive(Debug, Clone)]
pub struct Sample(pub Vec<f64>);

impl Sample {
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        Sample(values.into_iter().collect())
    }

    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    /// Half of the 95 % interval of the mean.
    pub fn half_interval(&self) -> f64 {
        let (n, mean) = (self.0.len() as f64, self.mean());
        if n < 2.0 {
            return f64::NAN;
        }
        let variance = self.0.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        t_975(n - 1.0) * (variance / n).sqrt()
    }

    pub fn largest(&self) -> f64 {
        self.0.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    pub fn smallest(&self) -> f64 {
        self.0.iter().copied().fold(f64::INFINITY, f64::min)
    }

    pub fn median(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len();
        if n == 0 { f64::NAN } else { (sorted[n / 2] + sorted[(n - 1) / 2]) / 2.0 }
    }

    /// `mean ± half interval`.
    pub fn with_interval(&self, decimals: usize) -> String {
        format!("{:.decimals$} ± {:.decimals$}", self.mean(), self.half_interval())
    }

    /// `median (smallest–largest)`.
    pub fn with_range(&self, decimals: usize) -> String {
        format!("{:.decimals$} ({:.decimals$}–{:.decimals$})", self.median(), self.smallest(), self.largest())
    }
}

/// 97.5 % quantile of Student's t: Abramowitz & Stegun 26.7.5, good to 0.01 from five degrees of freedom on.
fn t_975(degrees: f64) -> f64 {
    let z = 1.959_963_985_f64;
    let g1 = (z.powi(3) + z) / 4.0;
    let g2 = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let g3 = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + g1 / degrees + g2 / degrees.powi(2) + g3 / degrees.powi(3)
}
