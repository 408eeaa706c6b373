//! Steps of a foot-mounted sensor: strapdown between stances, zero-velocity updates in them, one step from the end of a
//! stance to the end of the next. After each step position and heading begin anew, so that a step's covariance is its own.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::check::{Prepared, Trust};
use super::filter::{ATTITUDE, FORCE_BIAS, Filter, Matrix15, Noise, Nominal, POSITION, RATE_BIAS, VELOCITY};
use super::stance::{self, Run};
use super::{Mount, Options, Pdr, StepEvent, heading, still};
use crate::error::{Error, Result};
use crate::geometry::angle_diff;
use crate::pedestrian::Step;

/// A foot that moved and turned less than this between two stances stayed where it was.
const STAYED: (f64, f64) = (0.03, 0.035);
/// Start uncertainties: velocity m/s, tilt rad, b_a m/s², b_ω rad/s without and with a still period.
const START: [f64; 5] = [0.01, 0.01, 0.05, 5e-3, 3e-4];
/// How the biases wander: m/s² and rad/s per √s.
const WANDER: [f64; 2] = [1e-3, 1e-5];
/// A sample's rate in a still period against the bias, rad/s.
const STILL_RATE_RADPS: f64 = 5e-3;
/// By how much the noise of a clipped sample is greater, as a variance.
const CLIPPED: f64 = 400.0;
/// What a swing may do unseen: m/s and rad per √s.
const UNSEEN: [f64; 2] = [8.0, 0.5];
/// The sensor's distance from where the resting foot still rolls, metres: with its rate, a speed that is no error.
const LEVER_M: f64 = 0.03;
/// By how much of its length a stride may be wrong for that (2.4 % short in the median of 16 measured walks).
const ROLLS: f64 = 0.025;
/// Samples that level the sensor, seconds of the first stance.
const LEVEL_S: f64 = 1.0;

/// A step in the navigation frame.
struct Leg {
    moved: Vector3<f64>,
    from: UnitQuaternion<f64>,
    to: UnitQuaternion<f64>,
    /// Of (x, y, heading).
    covariance: Matrix3<f64>,
    left_s: f64,
    landed_s: f64,
    rests_until_s: f64,
    unseen_s: f64,
}

/// Steps of a foot.
///
/// # Errors
/// [`Error::Input`] if the foot never rests, or never moves.
pub fn reckon(name: &str, prepared: &Prepared, options: &Options) -> Result<Pdr> {
    let recording = &prepared.recording;
    let stills = if options.still_bias { still::periods(recording) } else { Vec::new() };
    let bias = stills.first().map(|s| s.rate_radps);
    let offset = bias.unwrap_or_else(Vector3::zeros);
    let mut statistic = stance::statistic(recording, offset, options.gravity_mps2);
    for (value, _) in statistic.iter_mut().zip(&prepared.trust).filter(|(_, t)| **t == Trust::MadeUp) {
        *value = f64::INFINITY;
    }
    let thresholds = stance::thresholds(recording, &statistic, options.stance_threshold);
    let stances = stance::stances(recording, &statistic, &thresholds, options.stance_threshold);
    if stances.is_empty() {
        let message = "found no time at which the foot rests, expected one in every stride: is it in a hand (--mount hand)?";
        return Err(Error::input(name, message));
    }
    let legs = legs(prepared, options, &stances, &stills, bias.is_some());
    let Some(first) = legs.first() else {
        return Err(Error::input(name, "found no step, expected a foot that moves and rests"));
    };
    let starts_s = first.left_s;
    let mut steps = events(&legs);
    bridge(&legs, &mut steps);
    let mut remarks = Vec::new();
    let times = |s: &still::Still| [recording.samples[s.first].time_s, recording.samples[s.end - 1].time_s];
    if options.still_bias && bias.is_none() {
        remarks.push(
            "nothing is still for half a second: the gyroscope's bias is taken as zero at the start".into(),
        );
    }
    Ok(Pdr {
        mount: Mount::Foot,
        steps,
        starts_s,
        gyro_bias_radps: bias.map(Into::into),
        bias_from_s: stills.first().map(times),
        dropouts: Vec::new(),
        remarks,
    })
}

/// The filter's first state, and what is known of it.
fn start(prepared: &Prepared, options: &Options, first: &Run, still: &[still::Still], known: bool) -> Filter {
    let recording = &prepared.recording;
    let interval_s = recording.interval_s().unwrap_or(0.01);
    let length = first.len().min((LEVEL_S / interval_s) as usize).max(1);
    let (_, force) = still::means(recording, first.start, first.start + length);
    let bias = still.first().map_or_else(Vector3::zeros, |s| s.rate_radps);
    let mut covariance = Matrix15::zeros();
    let mut set = |at: usize, count: usize, sigma: f64| {
        (at..at + count).for_each(|k| covariance[(k, k)] = sigma * sigma);
    };
    set(POSITION, 3, 0.0);
    set(VELOCITY, 3, START[0]);
    set(ATTITUDE, 2, START[1]);
    set(FORCE_BIAS, 3, START[2]);
    set(RATE_BIAS, 3, START[if known { 4 } else { 3 }]);
    let per_second = |sigma: f64| sigma * sigma * 0.01;
    let noise = Noise {
        force: per_second(options.force_noise_mps2),
        rate: per_second(options.rate_noise_radps),
        force_bias: WANDER[0].powi(2),
        rate_bias: WANDER[1].powi(2),
    };
    Filter::new(Nominal::at_rest(force, bias, options.gravity_mps2), covariance, options.gravity_mps2, noise)
}

fn legs(
    prepared: &Prepared,
    options: &Options,
    stances: &[Run],
    stills: &[still::Still],
    known: bool,
) -> Vec<Leg> {
    let samples = &prepared.recording.samples;
    let mut filter = start(prepared, options, &stances[0], stills, known);
    let mut legs: Vec<Leg> = Vec::new();
    let mut from = filter.nominal.n_from_b;
    let mut left_s = samples[stances[0].end - 1].time_s;
    let mut unseen_s = 0.0;
    let (mut next, mut still) = (0, 0);
    for k in stances[0].start + 1..samples.len() {
        let (a, b) = (&samples[k - 1], &samples[k]);
        let dt = b.time_s - a.time_s;
        let made_up = prepared.trust[k - 1..=k].contains(&Trust::MadeUp);
        let clipped = prepared.trust[k - 1..=k].contains(&Trust::Clipped);
        let (force, rate) = ((a.force_mps2 + b.force_mps2) * 0.5, (a.rate_radps + b.rate_radps) * 0.5);
        filter.predict(force, rate, dt, if clipped { CLIPPED } else { 1.0 });
        if made_up {
            filter.doubt(UNSEEN[0].powi(2) * dt, UNSEEN[1].powi(2) * dt);
            unseen_s += dt;
        }
        let Some(run) = stances.get(next) else { break };
        if k >= run.start {
            let turning = LEVER_M * (b.rate_radps - filter.nominal.rate_bias_radps).norm();
            filter.rest(options.stance_speed_mps.hypot(turning));
        }
        while stills.get(still).is_some_and(|s| s.end <= k) {
            still += 1;
        }
        if stills.get(still).is_some_and(|s| s.first <= k) {
            filter.stop_turning(b.rate_radps, STILL_RATE_RADPS);
        }
        if k + 1 < run.end {
            continue;
        }
        next += 1;
        let (moved, to) = (filter.nominal.position_m, filter.nominal.n_from_b);
        if next > 1
            && (moved.x.hypot(moved.y) > STAYED.0
                || heading::turn_about_vertical(&from, &to).abs() > STAYED.1)
        {
            let rows = [POSITION, POSITION + 1, ATTITUDE + 2];
            legs.push(Leg {
                moved,
                from,
                to,
                covariance: Matrix3::from_fn(|r, c| filter.covariance[(rows[r], rows[c])]),
                left_s,
                landed_s: samples[run.start].time_s,
                rests_until_s: b.time_s,
                unseen_s,
            });
            filter.begin_here();
            (from, unseen_s) = (to, 0.0);
        } else if next == 1 {
            filter.begin_here();
            (from, unseen_s) = (to, 0.0);
        } else if let Some(leg) = legs.last_mut() {
            leg.rests_until_s = b.time_s;
        }
        left_s = b.time_s;
    }
    legs
}

/// Steps in the walker's heading frame.
fn events(legs: &[Leg]) -> Vec<StepEvent> {
    let axis = heading::forward_axis(legs.iter().map(|l| (&l.from, &l.moved)));
    let of = |q: &UnitQuaternion<f64>| axis.as_ref().and_then(|axis| heading::of_axis(q, axis));
    // Where the axis says nothing, the twist goes on from the heading before.
    let mut heading_rad = legs.first().and_then(|l| of(&l.from)).unwrap_or(0.0);
    let event = |leg: &Leg| {
        let before = heading_rad;
        let twisted = before + heading::turn_about_vertical(&leg.from, &leg.to);
        heading_rad = of(&leg.to).unwrap_or(twisted);
        let (s, c) = before.sin_cos();
        let turn = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
        let moved = turn * leg.moved;
        StepEvent {
            step: Step {
                time_s: leg.landed_s,
                forward_m: moved.x,
                left_m: moved.y,
                turn_rad: angle_diff(heading_rad, before),
            },
            rests_until_s: leg.rests_until_s,
            covariance: turn * leg.covariance * turn.transpose() + rolls(moved.x.hypot(moved.y)),
        }
    };
    legs.iter().map(event).collect()
}

/// What the filter does not know of: a resting foot rolls and the sensor with it, so that strides come out short.
fn rolls(length_m: f64) -> Matrix3<f64> {
    let variance = (ROLLS * length_m).powi(2);
    Matrix3::from_diagonal(&Vector3::new(variance, variance, 0.0))
}

/// Where a good part of a step was not seen, the walker's other strides say what is likely: the step becomes the mean of
/// what the filter says and of so many typical strides as there was time for, weighted by their information.
fn bridge(legs: &[Leg], steps: &mut [StepEvent]) {
    const UNSEEN_S: f64 = 0.1;
    let clean: Vec<usize> = (0..legs.len()).filter(|&k| legs[k].unseen_s == 0.0).collect();
    if clean.len() < 3 || clean.len() == legs.len() {
        return;
    }
    let median = |of: &dyn Fn(usize) -> f64| {
        let mut values: Vec<f64> = clean.iter().map(|&k| of(k)).collect();
        values.sort_unstable_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (forward_m, left_m) = (median(&|k| steps[k].step.forward_m), median(&|k| steps[k].step.left_m));
    let takes_s = median(&|k| legs[k].rests_until_s - legs[k].left_s).max(0.1);
    let spread = |middle: f64, of: &dyn Fn(usize) -> f64| {
        clean.iter().map(|&k| (of(k) - middle).powi(2)).sum::<f64>() / clean.len() as f64 + 1e-4
    };
    let var_forward = spread(forward_m, &|k| steps[k].step.forward_m);
    let var_left = spread(left_m, &|k| steps[k].step.left_m);
    for (leg, event) in legs.iter().zip(steps.iter_mut()).filter(|(leg, _)| leg.unseen_s > UNSEEN_S) {
        let strides = ((leg.rests_until_s - leg.left_s) / takes_s).round().max(1.0);
        let seen = event.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let typical = nalgebra::Matrix2::new(strides * var_forward, 0.0, 0.0, strides * var_left);
        let Some(inverse) = (seen + typical).try_inverse() else { continue };
        let gain = seen * inverse;
        let here = nalgebra::Vector2::new(event.step.forward_m, event.step.left_m);
        let there = nalgebra::Vector2::new(strides * forward_m, strides * left_m);
        let mixed = here + gain * (there - here);
        (event.step.forward_m, event.step.left_m) = (mixed.x, mixed.y);
        let covariance = seen - gain * seen;
        event.covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&covariance);
        event.covariance.fixed_view_mut::<2, 1>(0, 2).fill(0.0);
        event.covariance.fixed_view_mut::<1, 2>(2, 0).fill(0.0);
    }
}
