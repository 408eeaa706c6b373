//! Periods in which the sensor does not move at all: there a gyroscope shows its bias, and an accelerometer gravity.

use nalgebra::Vector3;

use super::Recording;

/// Shorter periods say nothing, seconds.
const SHORTEST_S: f64 = 0.45;
/// What comes right before and after a movement is left out, seconds.
const MARGIN_S: f64 = 0.1;
/// Windows over which the noise is taken, seconds.
const WINDOW_S: f64 = 0.25;
/// Greatest standard deviation of the rate within a window (all axes together), rad/s.
const RATE_NOISE_RADPS: f64 = 0.025;
/// Greatest standard deviation of the specific force within a window, m/s².
const FORCE_NOISE_MPS2: f64 = 0.25;
/// A greater mean rate is a slow turn, not a bias, rad/s.
const GREATEST_BIAS_RADPS: f64 = 0.1;

/// A period without motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// First sample.
    pub first: usize,
    /// One past the last sample.
    pub end: usize,
    /// Mean rate: the gyroscope's bias, rad/s.
    pub rate_radps: Vector3<f64>,
    /// Mean specific force, m/s².
    pub force_mps2: Vector3<f64>,
}

/// All still periods of at least half a second (nearly), in order.
pub fn periods(recording: &Recording) -> Vec<Still> {
    let Some(interval_s) = recording.interval_s() else { return Vec::new() };
    let samples = &recording.samples;
    let window = ((WINDOW_S / interval_s).round() as usize).max(3);
    let mut quiet = vec![false; samples.len()];
    let mut first = 0;
    while first + window <= samples.len() {
        if is_quiet(recording, first, first + window) {
            quiet[first..first + window].fill(true);
        }
        first += window.div_ceil(4);
    }
    let mut found = Vec::new();
    let mut at = 0;
    let margin = (MARGIN_S / interval_s).round() as usize;
    while at < quiet.len() {
        let end = (at..quiet.len()).find(|&k| !quiet[k]).unwrap_or(quiet.len());
        if end > at && samples[end - 1].time_s - samples[at].time_s >= SHORTEST_S {
            // At the ends of the recording nothing moved that we know of.
            let from = if at == 0 { 0 } else { at + margin };
            let to = if end == quiet.len() { end } else { end - margin };
            let (rate_radps, force_mps2) = means(recording, from, to);
            if rate_radps.norm() < GREATEST_BIAS_RADPS {
                found.push(Still { first: from, end: to, rate_radps, force_mps2 });
            }
        }
        at = end + 1;
    }
    found
}

/// Mean rate and mean specific force of some samples.
pub fn means(recording: &Recording, first: usize, end: usize) -> (Vector3<f64>, Vector3<f64>) {
    let part = &recording.samples[first..end];
    let n = part.len().max(1) as f64;
    let rate = part.iter().fold(Vector3::zeros(), |sum, s| sum + s.rate_radps) / n;
    let force = part.iter().fold(Vector3::zeros(), |sum, s| sum + s.force_mps2) / n;
    (rate, force)
}

fn is_quiet(recording: &Recording, first: usize, end: usize) -> bool {
    let (rate, force) = means(recording, first, end);
    let part = &recording.samples[first..end];
    let n = part.len() as f64;
    let rate_var = part.iter().map(|s| (s.rate_radps - rate).norm_squared()).sum::<f64>() / n;
    let force_var = part.iter().map(|s| (s.force_mps2 - force).norm_squared()).sum::<f64>() / n;
    rate_var < RATE_NOISE_RADPS.powi(2) && force_var < FORCE_NOISE_MPS2.powi(2)
}
