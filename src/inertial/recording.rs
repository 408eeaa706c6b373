//! What an inertial sensor recorded.

use nalgebra::Vector3;

/// One reading of both sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// When, seconds.
    pub time_s: f64,
    /// Specific force, sensor axes, m/s²: 9.8 upwards at rest.
    pub force_mps2: Vector3<f64>,
    /// Angular rate, sensor axes, rad/s.
    pub rate_radps: Vector3<f64>,
}

/// Samples in strictly ascending time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// The samples.
    pub samples: Vec<Sample>,
}

/// A part of a recording in which the sensor did not tell the truth, and which was bridged.
#[derive(Debug, Clone, PartialEq)]
pub struct Dropout {
    /// Last good time before it, seconds.
    pub from_s: f64,
    /// First good time after it, seconds.
    pub to_s: f64,
    /// What was wrong, for a person.
    pub what: &'static str,
}

impl Recording {
    /// Median time between samples, seconds; `None` below two samples.
    pub fn interval_s(&self) -> Option<f64> {
        let mut gaps: Vec<f64> = self.samples.windows(2).map(|w| w[1].time_s - w[0].time_s).collect();
        gaps.sort_unstable_by(f64::total_cmp);
        gaps.get(gaps.len() / 2).copied()
    }

    /// How long gravity is in this recording: the median length of the specific force over the fifth of the samples that
    /// turn least. (Over all of them a walking foot's swings weigh more than gravity.)
    pub fn gravity_length(&self) -> f64 {
        let calm = self.rate_quantile_radps(0.2);
        let slow = self.samples.iter().filter(|s| s.rate_radps.norm() <= calm);
        let mut norms: Vec<f64> = slow.map(|s| s.force_mps2.norm()).collect();
        norms.sort_unstable_by(f64::total_cmp);
        norms.get(norms.len() / 2).copied().unwrap_or(0.0)
    }

    /// Standard deviation of the specific force's length, m/s².
    pub fn force_spread_mps2(&self) -> f64 {
        let n = self.samples.len().max(1) as f64;
        let norms = || self.samples.iter().map(|s| s.force_mps2.norm());
        let mean = norms().sum::<f64>() / n;
        (norms().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
    }

    /// The rate below which `share` of the samples lie, rad/s.
    pub fn rate_quantile_radps(&self, share: f64) -> f64 {
        let mut norms: Vec<f64> = self.samples.iter().map(|s| s.rate_radps.norm()).collect();
        norms.sort_unstable_by(f64::total_cmp);
        let at = (norms.len().saturating_sub(1) as f64 * share).round() as usize;
        norms.get(at).copied().unwrap_or(0.0)
    }
}
