//! When a foot rests on the ground: the SHOE detector (Skog, Händel, Nilsson, Rantakokko 2010), a generalised likelihood
//! ratio test for "only gravity is felt, and nothing turns":
//!
//! T(k) = 1/W Σ_{l in the window} ( ‖f_l − g f̄/‖f̄‖‖²/σ_a² + ‖ω_l‖²/σ_ω² ) < γ

use nalgebra::Vector3;

use super::Recording;

/// σ_a, m/s².
pub const FORCE_SIGMA_MPS2: f64 = 0.01;
/// σ_ω, rad/s (0.1°/s).
pub const RATE_SIGMA_RADPS: f64 = 1.745_329_251_994_33e-3;
/// The window W, seconds.
pub const WINDOW_S: f64 = 0.025;
/// Shorter stances are chance, and shorter movements within a stance are noise, seconds.
pub const SHORTEST_S: f64 = 0.06;
/// The same where γ says that the walker runs.
const SHORTEST_RUNNING_S: f64 = 0.015;

/// From a sample to the next stance at most, seconds.
const STRIDE_S: f64 = 0.75;
/// γ over the least T nearby.
const FACTOR: f64 = 3.0;
/// A runner's γ over a walker's, at most (as Wagstaff and Kelly's thresholds for walking and running).
const RUNNING: f64 = 40.0;

/// A run of samples: the first and one past the last.
pub type Run = std::ops::Range<usize>;

/// T for every sample: the mean over the window around it (shorter at the ends).
pub fn statistic(recording: &Recording, rate_bias_radps: Vector3<f64>, gravity_mps2: f64) -> Vec<f64> {
    let samples = &recording.samples;
    let interval_s = recording.interval_s().unwrap_or(WINDOW_S);
    let half = ((WINDOW_S / interval_s - 1.0) / 2.0).round().max(1.0) as usize;
    let at = |k: usize| {
        let window = &samples[k.saturating_sub(half)..(k + half + 1).min(samples.len())];
        let mean = window.iter().fold(Vector3::zeros(), |sum, s| sum + s.force_mps2);
        let up = mean.try_normalize(1e-9).unwrap_or_else(Vector3::zeros) * gravity_mps2;
        let sum: f64 = window
            .iter()
            .map(|s| {
                (s.force_mps2 - up).norm_squared() / FORCE_SIGMA_MPS2.powi(2)
                    + (s.rate_radps - rate_bias_radps).norm_squared() / RATE_SIGMA_RADPS.powi(2)
            })
            .sum();
        sum / window.len() as f64
    };
    (0..samples.len()).map(at).collect()
}

/// γ for every sample. Who runs never rests as calmly as who walks: within a stride's time to either side T must have been
/// lowest in a stance, so that `FACTOR` times that is γ where it is more than the walker's γ, and at most `RUNNING` times it.
pub fn thresholds(recording: &Recording, statistic: &[f64], walking: f64) -> Vec<f64> {
    let samples = &recording.samples;
    // A deque of samples whose T ascends: its first is the least of the window.
    let mut rising: std::collections::VecDeque<usize> = std::collections::VecDeque::new();
    let mut next = 0;
    let least = |k: usize| {
        while next < samples.len() && samples[next].time_s <= samples[k].time_s + STRIDE_S {
            while rising.back().is_some_and(|&last| statistic[last] >= statistic[next]) {
                rising.pop_back();
            }
            rising.push_back(next);
            next += 1;
        }
        while rising.front().is_some_and(|&first| samples[first].time_s < samples[k].time_s - STRIDE_S) {
            rising.pop_front();
        }
        rising.front().map_or(f64::INFINITY, |&first| statistic[first])
    };
    (0..samples.len()).map(least).map(|least| (FACTOR * least).clamp(walking, RUNNING * walking)).collect()
}

/// The stances of a recording: T < γ; gaps of less than [`SHORTEST_S`] closed, then runs of less than that dropped.
pub fn stances(recording: &Recording, statistic: &[f64], thresholds: &[f64], walking: f64) -> Vec<Run> {
    let samples = &recording.samples;
    let mut runs: Vec<Run> = Vec::new();
    for k in (0..samples.len()).filter(|&k| statistic[k] < thresholds[k]) {
        match runs.last_mut() {
            Some(run) if samples[k].time_s - samples[run.end - 1].time_s < SHORTEST_S => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    let runs_fast = |run: &Run| run.clone().all(|k| thresholds[k] > walking);
    runs.retain(|run| {
        let lasts_s = samples[run.end - 1].time_s - samples[run.start].time_s;
        lasts_s >= if runs_fast(run) { SHORTEST_RUNNING_S } else { SHORTEST_S }
    });
    runs
}
