//! Steps of a hand-held sensor: swings of the vertical acceleration, Weinberg's step length (2002), heading from the
//! rate about gravity. The hand keeps its angle to the walker.

use nalgebra::{Matrix3, Vector3};

use super::check::{Prepared, Trust};
use super::{Mount, Options, Pdr, Recording, StepEvent, still};
use crate::error::{Error, Result};
use crate::pedestrian::Step;

/// Time constant with which "up" follows the specific force, seconds: long against a step.
const UP_S: f64 = 4.0;
/// What levels the sensor at the start, seconds.
const LEVEL_S: f64 = 1.0;
/// The vertical acceleration is smoothed twice over this long, seconds.
const SMOOTH_S: f64 = 0.12;
/// Nobody takes steps faster than this, seconds.
const FASTEST_STEP_S: f64 = 0.25;
/// A pause in which nobody stands: longer than this many typical steps.
const PAUSE: f64 = 1.6;
/// The walk's own frame faces where the first steps go, so many of them: how the hand turns before says nothing of the walker.
const FIRST: usize = 4;
/// A step's standard deviations: a share of its length ahead, metres to the side, radians of turn.
const SIGMAS: (f64, f64, f64) = (0.1, 0.05, 0.02);

/// Steps of a walker who holds the sensor.
///
/// # Errors
/// [`Error::Input`] if no step is found.
pub fn reckon(name: &str, prepared: &Prepared, options: &Options) -> Result<Pdr> {
    let recording = &prepared.recording;
    let stills = if options.still_bias { still::periods(recording) } else { Vec::new() };
    let bias = stills.first().map(|s| s.rate_radps);
    let (vertical, heading) = in_gravity_frame(recording, bias.unwrap_or_else(Vector3::zeros), options);
    let interval_s = recording.interval_s().unwrap_or(0.01);
    let half = (SMOOTH_S / interval_s / 2.0).round() as usize;
    let vertical = smooth(&smooth(&vertical, half), half);
    let swings = swings(recording, &vertical, options.step_swing_mps2);
    if swings.is_empty() {
        let message = format!(
            "found no step: the vertical acceleration never swings by {} m/s², expected a walk",
            options.step_swing_mps2
        );
        return Err(Error::input(name, message));
    }
    let time = |k: usize| recording.samples[k].time_s;
    let mut gaps: Vec<f64> = swings.windows(2).map(|w| time(w[1].at) - time(w[0].at)).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let typical_s = gaps.get(gaps.len() / 2).copied().unwrap_or(0.6);
    // A body sways to and fro with every second step: the heading is the mean over two.
    let heading = smooth(&heading, (typical_s / interval_s).round() as usize);
    let length = |swing: &Swing| options.weinberg_gain * swing.size_mps2.powf(0.25);
    let mut steps: Vec<StepEvent> = Vec::new();
    let first = &swings[..swings.len().min(FIRST)];
    let mut facing = first.iter().map(|s| heading[s.at]).sum::<f64>() / first.len() as f64;
    let mut step = |time_s: f64, length_m: f64, now: f64| {
        let turn_rad = now - facing;
        // The displacement is in the heading before the step: half of the turn is already made.
        let (s, c) = (0.5 * turn_rad).sin_cos();
        facing = now;
        let sigmas = Vector3::new(SIGMAS.0 * length_m, SIGMAS.1, SIGMAS.2);
        StepEvent {
            step: Step { time_s, forward_m: length_m * c, left_m: length_m * s, turn_rad },
            rests_until_s: time_s,
            covariance: Matrix3::from_diagonal(&sigmas.component_mul(&sigmas)),
        }
    };
    for (n, swing) in swings.iter().enumerate() {
        if let Some(before) = n.checked_sub(1).map(|n| &swings[n]) {
            let (from_s, to_s) = (time(before.at), time(swing.at));
            let unseen = prepared.trust[before.at..swing.at].contains(&Trust::MadeUp);
            let missing = ((to_s - from_s) / typical_s).round() as usize;
            if unseen && to_s - from_s > PAUSE * typical_s {
                for k in 1..missing {
                    let share = k as f64 / missing as f64;
                    let at = before.at + ((swing.at - before.at) as f64 * share) as usize;
                    steps.push(step(from_s + share * (to_s - from_s), length(before), heading[at]));
                }
            }
        }
        steps.push(step(time(swing.at), length(swing), heading[swing.at]));
    }
    let mut remarks = Vec::new();
    if options.still_bias && bias.is_none() {
        remarks.push("nothing is still for half a second: the gyroscope's bias is taken as zero".into());
    }
    Ok(Pdr {
        mount: Mount::Hand,
        starts_s: steps.first().map_or(0.0, |s| s.step.time_s) - typical_s,
        steps,
        gyro_bias_radps: bias.map(Into::into),
        bias_from_s: stills.first().map(|s| [time(s.first), time(s.end - 1)]),
        dropouts: Vec::new(),
        remarks,
    })
}

/// Vertical acceleration (m/s²) and heading (radians, from 0, not wrapped) of every sample. "Up", in the sensor's axes,
/// is carried along by the rate and drawn to the specific force: u̇ = −ω × u + (f/‖f‖ − u)/τ.
fn in_gravity_frame(recording: &Recording, bias: Vector3<f64>, options: &Options) -> (Vec<f64>, Vec<f64>) {
    let samples = &recording.samples;
    let first_s = samples[0].time_s;
    let level = samples.iter().take_while(|s| s.time_s <= first_s + LEVEL_S).count();
    let mut up = still::means(recording, 0, level).1.normalize();
    let (mut vertical, mut headings) = (Vec::with_capacity(samples.len()), Vec::with_capacity(samples.len()));
    let (mut heading, mut before_s) = (0.0, first_s);
    for sample in samples {
        let dt = sample.time_s - before_s;
        before_s = sample.time_s;
        let rate = sample.rate_radps - bias;
        let turned = nalgebra::UnitQuaternion::from_scaled_axis(rate * -dt) * up;
        let force = sample.force_mps2.try_normalize(1e-6).unwrap_or(turned);
        up = (turned + (force - turned) * (dt / UP_S).min(1.0)).normalize();
        heading += rate.dot(&up) * dt;
        vertical.push(sample.force_mps2.dot(&up) - options.gravity_mps2);
        headings.push(heading);
    }
    (vertical, headings)
}

/// Mean over `half` samples to both sides (fewer at the ends).
fn smooth(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(values.len() + 1);
    sums.push(0.0);
    let mut sum = 0.0;
    for value in values {
        sum += value;
        sums.push(sum);
    }
    let mean = |k: usize| {
        let reach = half.min(k).min(values.len() - 1 - k);
        (sums[k + reach + 1] - sums[k - reach]) / (2 * reach + 1) as f64
    };
    (0..values.len()).map(mean).collect()
}

/// A step as the acceleration shows it.
struct Swing {
    /// Its highest point.
    at: usize,
    /// From there down to the lowest point after it.
    size_mps2: f64,
}

/// Alternating extremes that differ by at least `least`; the maxima are the steps.
fn swings(recording: &Recording, vertical: &[f64], least: f64) -> Vec<Swing> {
    let mut found: Vec<Swing> = Vec::new();
    let (mut high, mut low) = (0, 0);
    let mut rising = true;
    for k in 0..vertical.len() {
        if rising {
            high = if vertical[k] > vertical[high] { k } else { high };
            if vertical[high] - vertical[k] >= least {
                (rising, low) = (false, k);
            }
            continue;
        }
        low = if vertical[k] < vertical[low] { k } else { low };
        let last = k + 1 == vertical.len();
        if vertical[k] - vertical[low] >= least || last {
            let size_mps2 = vertical[high] - vertical[low];
            let time = |k: usize| recording.samples[k].time_s;
            match found.last_mut() {
                Some(before) if time(high) - time(before.at) < FASTEST_STEP_S => {
                    before.size_mps2 = before.size_mps2.max(size_mps2);
                }
                _ => found.push(Swing { at: high, size_mps2 }),
            }
            (rising, high) = (true, k);
        }
    }
    found
}
