//! Is a recording what it claims to be? Units, working sensors, dropouts; and what the sensor was fixed to.

use super::{Dropout, Mount, Recording, Sample};
use crate::error::{Error, Result};

/// Shortest recording that holds a walk, seconds.
pub const SHORTEST_S: f64 = 2.0;
/// Dropouts up to this long are bridged, seconds.
pub const LONGEST_DROPOUT_S: f64 = 1.0;
/// At most this share of a recording may be bridged.
const MOST_BRIDGED: f64 = 0.1;
/// A gap is a dropout from this many sample intervals on …
const GAP_INTERVALS: f64 = 5.0;
/// … and from this many seconds on.
const GAP_S: f64 = 0.04;
/// An axis that shows the same number for this long while others move is stuck, seconds.
const STUCK_S: f64 = 0.15;
/// More samples at an axis' extreme than this share are no walk but a saturated sensor.
const MOST_SATURATED: f64 = 0.01;
/// So many samples at an extreme in a row are saturation, not chance.
const SATURATED_RUN: usize = 3;
/// Extremes below these are not the end of any sensor's range: m/s², rad/s.
const RANGE_FROM: [f64; 2] = [15.0, 3.0];
/// A foot's fastest hundredth of rates is above this, a hand's below, rad/s.
const FOOT_RATE_RADPS: f64 = 3.5;
/// Nobody walks without turning the sensor faster than this now and then, rad/s …
const SLOWEST_WALK_RADPS: f64 = 0.1;
/// … if the specific force varies by more than this, m/s².
const WALK_SPREAD_MPS2: f64 = 0.7;
const AXES: [&str; 6] =
    ["acc_x_mps2", "acc_y_mps2", "acc_z_mps2", "gyro_x_radps", "gyro_y_radps", "gyro_z_radps"];

/// How far a sample is to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Trust {
    /// As measured.
    #[default]
    Measured,
    /// At an end of the sensor's range.
    Clipped,
    /// On a straight line over a dropout.
    MadeUp,
}

/// A recording that is fit for dead reckoning.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// Without what was wrong, gaps filled by straight lines.
    pub recording: Recording,
    /// How far each sample is to be trusted.
    pub trust: Vec<Trust>,
    /// What was bridged.
    pub dropouts: Vec<Dropout>,
    /// For a person.
    pub remarks: Vec<String>,
}

/// Checks a recording and bridges its dropouts.
///
/// # Errors
/// [`Error::Input`], its place `name`, if it is too short, time does not ascend, numbers are not finite, the units are
/// others, a sensor is stuck or saturated all along, or a dropout is too long to be bridged.
pub fn prepare(name: &str, recording: &Recording) -> Result<Prepared> {
    let samples = &recording.samples;
    let refuse = |message: String| Err(Error::input(name, message));
    let length_s = samples.last().map_or(0.0, |s| s.time_s) - samples.first().map_or(0.0, |s| s.time_s);
    let Some(interval_s) = recording.interval_s() else {
        return refuse(format!("found {} samples, expected at least {SHORTEST_S} s of them", samples.len()));
    };
    if let Some(pair) =
        samples.windows(2).find(|w| w[1].time_s.partial_cmp(&w[0].time_s).is_none_or(|o| o.is_le()))
    {
        let (time, before) = (pair[1].time_s, pair[0].time_s);
        return refuse(format!("time_s: found {time} after {before}, expected a later time"));
    }
    if let Some(bad) = samples.iter().find(|s| values(s).iter().any(|v| !v.is_finite())) {
        return refuse(format!(
            "found a number that is not finite at {} s, expected finite numbers",
            bad.time_s
        ));
    }
    if !(0.0004..=0.05).contains(&interval_s) {
        return refuse(format!(
            "found {interval_s} s between samples, expected 0.0005 to 0.05 (20 to 2,000 samples a second): is the time in seconds?"
        ));
    }
    if length_s < SHORTEST_S {
        return refuse(format!("found {length_s:.2} s of samples, expected at least {SHORTEST_S} s"));
    }
    units(name, recording)?;
    let mut remarks = Vec::new();
    let clipped = saturated(name, recording, &mut remarks)?;
    let stuck = stuck(name, recording, interval_s)?;
    let keep: Vec<usize> = (0..samples.len()).filter(|&k| !stuck[k]).collect();
    let mut filled =
        Prepared { recording: Recording::default(), trust: Vec::new(), dropouts: Vec::new(), remarks };
    let mut bridged_s = 0.0;
    for (n, &k) in keep.iter().enumerate() {
        let sample = samples[k];
        if let Some(&before) = n.checked_sub(1).and_then(|n| keep.get(n)) {
            let last = samples[before];
            let gap_s = sample.time_s - last.time_s;
            if gap_s > (GAP_INTERVALS * interval_s).max(GAP_S) {
                let what = if k == before + 1 { "samples are missing" } else { "a sensor was stuck" };
                if gap_s > LONGEST_DROPOUT_S {
                    let place = format!("from {:.2} s to {:.2} s", last.time_s, sample.time_s);
                    return refuse(format!(
                        "found a dropout {place} ({what}), expected at most {LONGEST_DROPOUT_S} s: cut the recording there"
                    ));
                }
                bridged_s += gap_s;
                filled.dropouts.push(Dropout { from_s: last.time_s, to_s: sample.time_s, what });
                let count = (gap_s / interval_s).round().max(2.0);
                for j in 1..count as usize {
                    filled.recording.samples.push(between(&last, &sample, j as f64 / count));
                    filled.trust.push(Trust::MadeUp);
                }
            }
        }
        filled.recording.samples.push(sample);
        filled.trust.push(if clipped[k] { Trust::Clipped } else { Trust::Measured });
    }
    if bridged_s > MOST_BRIDGED * length_s {
        let share = 100.0 * bridged_s / length_s;
        return refuse(format!(
            "found dropouts over {share:.0} % of the recording, expected at most {:.0} %",
            100.0 * MOST_BRIDGED
        ));
    }
    if filled.recording.samples.len() < 2 {
        return refuse("found a sensor that is stuck all along, expected one that works".to_owned());
    }
    Ok(filled)
}

/// Told from how fast the sensor turns: a foot swings, a hand does not.
///
/// # Errors
/// [`Error::Input`] if the recording lies between.
pub fn mount(name: &str, recording: &Recording) -> Result<Mount> {
    let fast = recording.rate_quantile_radps(0.99);
    match fast / FOOT_RATE_RADPS {
        r if r > 1.15 => Ok(Mount::Foot),
        r if r < 0.87 => Ok(Mount::Hand),
        _ => {
            let found = format!("found turns of {fast:.1} rad/s, which a foot or a hand may make");
            Err(Error::input(name, format!("{found}, expected to be told which: --mount foot|hand")))
        }
    }
}

fn values(sample: &Sample) -> [f64; 6] {
    let (f, w) = (&sample.force_mps2, &sample.rate_radps);
    [f.x, f.y, f.z, w.x, w.y, w.z]
}

fn between(a: &Sample, b: &Sample, share: f64) -> Sample {
    Sample {
        time_s: a.time_s + share * (b.time_s - a.time_s),
        force_mps2: a.force_mps2.lerp(&b.force_mps2, share),
        rate_radps: a.rate_radps.lerp(&b.rate_radps, share),
    }
}

/// Gravity has one length, and nobody turns a foot more than some times a second.
fn units(name: &str, recording: &Recording) -> Result<()> {
    let force = recording.gravity_length();
    if !(8.0..=12.0).contains(&force) {
        let hint = match force {
            f if (0.8..=1.2).contains(&f) => ": is it in g?",
            f if (800.0..=1200.0).contains(&f) => ": is it in thousandths of g?",
            _ => "",
        };
        let message = format!("acc_x_mps2…: found gravity of {force:.3}, expected about 9.8 m/s²{hint}");
        return Err(Error::input(name, message));
    }
    let fast = recording.rate_quantile_radps(0.99);
    if fast > 40.0 {
        let message = format!(
            "gyro_x_radps…: found turns of {fast:.0} rad/s, expected at most 40: are they in degrees per second?"
        );
        return Err(Error::input(name, message));
    }
    if fast < SLOWEST_WALK_RADPS && recording.force_spread_mps2() > WALK_SPREAD_MPS2 {
        let message = format!(
            "gyro_x_radps…: found turns of at most {fast:.3} rad/s of somebody who moves, expected more than {SLOWEST_WALK_RADPS}: does the gyroscope work?"
        );
        return Err(Error::input(name, message));
    }
    Ok(())
}

/// Which samples lie at an end of an axis' range.
fn saturated(name: &str, recording: &Recording, remarks: &mut Vec<String>) -> Result<Vec<bool>> {
    let samples = &recording.samples;
    let mut all = vec![false; samples.len()];
    for (axis, column) in AXES.iter().enumerate() {
        let value = |k: usize| values(&samples[k])[axis];
        let mut at_end = vec![false; samples.len()];
        for sign in [1.0, -1.0] {
            let extreme = (0..samples.len()).map(|k| sign * value(k)).fold(f64::NEG_INFINITY, f64::max);
            if extreme < RANGE_FROM[axis / 3] {
                continue;
            }
            let mut first = 0;
            while first < samples.len() {
                let run = (first..samples.len()).take_while(|&k| sign * value(k) >= extreme).count();
                if run >= SATURATED_RUN {
                    at_end[first..first + run].fill(true);
                }
                first += run + 1;
            }
        }
        let count = at_end.iter().filter(|&&b| b).count();
        let share = count as f64 / samples.len() as f64;
        if share > MOST_SATURATED {
            let message = format!(
                "{column}: found {:.1} % of the samples at the end of the sensor's range, expected at most {:.0} %",
                100.0 * share,
                100.0 * MOST_SATURATED
            );
            return Err(Error::input(name, message));
        }
        if count > 0 {
            remarks.push(format!("{column}: {count} samples are at the end of the sensor's range"));
            all.iter_mut().zip(&at_end).for_each(|(a, b)| *a |= b);
        }
    }
    Ok(all)
}

/// Which samples repeat an axis' number while the others move on, or all axes' with numbers that are not of rest.
fn stuck(name: &str, recording: &Recording, interval_s: f64) -> Result<Vec<bool>> {
    let samples = &recording.samples;
    let mut all = vec![false; samples.len()];
    let changes = |k: usize| {
        let (now, before) = (values(&samples[k]), values(&samples[k - 1]));
        std::array::from_fn::<bool, 6, _>(|axis| now[axis] != before[axis])
    };
    let changed: Vec<[bool; 6]> = (1..samples.len()).map(changes).collect();
    let shortest = (STUCK_S / interval_s).ceil().max(8.0) as usize;
    for (axis, column) in AXES.iter().enumerate() {
        let mut first = 0;
        while first < changed.len() {
            let run = changed[first..].iter().take_while(|c| !c[axis]).count();
            if run >= shortest {
                let part = &changed[first..first + run];
                let moving = part.iter().filter(|c| c.iter().any(|&moves| moves)).count();
                let sample = &samples[first];
                let at_rest = sample.rate_radps.norm() < 0.2 && (sample.force_mps2.norm() - 9.81).abs() < 1.0;
                if 2 * moving > run || !at_rest {
                    all[first + 1..=first + run].fill(true);
                    if run == changed.len() {
                        let value = values(sample)[axis];
                        let message =
                            format!("{column}: found {value} in every sample, expected a sensor that works");
                        return Err(Error::input(name, message));
                    }
                }
            }
            first += run + 1;
        }
    }
    Ok(all)
}
