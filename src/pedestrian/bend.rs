//! Where the building turns by a small angle, or bends gently: what an aligned grid would straighten.
//!
//! Walkers drift each in their own way, and a drift keeps its rate for a while; but they all turn where the building
//! turns. So a change of direction that *all* walkers have at the same place is the building's ([`harmful_bend`]), and
//! so is a change of their rates of turning ([`harmful_curve`]): where a corridor begins to curve, every walker's track
//! begins to curve by the same amount more than it did.

use std::f64::consts::FRAC_PI_6;

use crate::geometry::{Vec2, angle_diff};

/// Lengths of the two chords that meet at a bend, metres.
const CHORDS_M: [f64; 2] = [5.0, 10.0];
/// A chord must be this straight: its length over that of the path. Keeps out chords that clip a corner.
const STRAIGHT: f64 = 0.985;
/// Bends this far from a multiple of 30° are pulled onto the axis, radians.
const HARMFUL_RAD: [f64; 2] = [0.050, 0.160];
/// A bend is common to all if its mean is this many standard errors from the nearest multiple of 30°.
const SIGNIFICANT: f64 = 4.0;
/// Standard error that is assumed at least, radians.
const SMALLEST_ERROR_RAD: f64 = 0.003;
/// Lengths of the chords before and after the place where a curve may begin, metres: shortest and longest.
const CURVE_CHORDS_M: [f64; 2] = [5.0, 10.0];
/// Curves at least this tight do harm, radians per metre: 400 m of radius.
const HARMFUL_RAD_PER_M: f64 = 0.0025;
/// Standard error of a rate that is assumed at least, radians per metre.
const SMALLEST_ERROR_RAD_PER_M: f64 = 0.0003;
/// Two walkers' rates may agree by chance.
const LEAST_WALKERS: usize = 3;

/// A change of direction that all walkers share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Path length at which it is, metres.
    pub at_m: f64,
    /// Mean over the walkers, radians.
    pub angle_rad: f64,
}

/// The first common bend that an aligned grid would get wrong; needs at least two walkers.
pub fn harmful_bend(tracks: &[&[Vec2]]) -> Option<Bend> {
    let lengths: Vec<Vec<f64>> = tracks.iter().map(|t| path_lengths(t)).collect();
    let longest_m = lengths.iter().filter_map(|l| l.last().copied()).fold(0.0, f64::max);
    for chord_m in CHORDS_M {
        // Every half metre: mean and standard error of the change of direction, where two walkers have one.
        let bends: Vec<Option<(f64, f64)>> = (0..(2.0 * longest_m) as usize)
            .map(|k| mean_bend(tracks, &lengths, 0.5 * k as f64, chord_m))
            .collect();
        let reach = (2.0 * chord_m) as usize;
        for (k, bend) in bends.iter().enumerate() {
            let Some((angle_rad, error_rad)) = *bend else { continue };
            let near = &bends[k.saturating_sub(reach)..(k + reach).min(bends.len())];
            let is_peak = near.iter().flatten().all(|(other, _)| other.abs() <= angle_rad.abs());
            let off_axis = angle_rad - (angle_rad / FRAC_PI_6).round() * FRAC_PI_6;
            let harmful = (HARMFUL_RAD[0]..=HARMFUL_RAD[1]).contains(&off_axis.abs());
            if is_peak && harmful && off_axis.abs() > SIGNIFICANT * error_rad.max(SMALLEST_ERROR_RAD) {
                return Some(Bend { at_m: 0.5 * k as f64, angle_rad });
            }
        }
    }
    None
}

/// A change of the rate of turning that all walkers share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve {
    /// Path length at which it is, metres.
    pub at_m: f64,
    /// Mean over the walkers, radians per metre.
    pub rate_rad_per_m: f64,
}

/// The clearest place where all walkers' tracks begin (or cease) to curve; needs at least three walkers.
pub fn harmful_curve(tracks: &[&[Vec2]]) -> Option<Curve> {
    let lengths: Vec<Vec<f64>> = tracks.iter().map(|t| path_lengths(t)).collect();
    let longest_m = lengths.iter().filter_map(|l| l.last().copied()).fold(0.0, f64::max);
    let mut clearest: Option<(f64, Curve)> = None;
    for k in 0..longest_m as usize {
        let at_m = k as f64;
        let changes: Vec<f64> =
            tracks.iter().zip(&lengths).filter_map(|(t, l)| change_of_rate(t, l, at_m)).collect();
        if changes.len() < LEAST_WALKERS {
            continue;
        }
        let (rate_rad_per_m, error) = mean_and_error(&changes);
        let clear = rate_rad_per_m.abs() / error.max(SMALLEST_ERROR_RAD_PER_M);
        if rate_rad_per_m.abs() >= HARMFUL_RAD_PER_M
            && clear > SIGNIFICANT
            && clearest.is_none_or(|(c, _)| clear > c)
        {
            clearest = Some((clear, Curve { at_m, rate_rad_per_m }));
        }
    }
    clearest.map(|(_, curve)| curve)
}

/// How much more a track turns per metre behind `at_m` than before it; `None` where it is too short or has a corner.
fn change_of_rate(track: &[Vec2], lengths: &[f64], at_m: f64) -> Option<f64> {
    let [shortest_m, longest_m] = CURVE_CHORDS_M;
    let left_m = lengths.last()? - at_m;
    let rate = |middle_m: f64, chord_m: f64| {
        let angle_rad = turn_at(track, lengths, middle_m, chord_m)?;
        (angle_rad.abs() < HARMFUL_RAD[1]).then_some(angle_rad / chord_m)
    };
    // As long as the straight part before it allows.
    let before = rate(at_m - longest_m, longest_m).or_else(|| rate(at_m - shortest_m, shortest_m))?;
    let chord_m = (left_m / 2.0 - 1e-6).min(longest_m);
    let after = (chord_m >= shortest_m).then(|| rate(at_m + chord_m, chord_m)).flatten()?;
    Some(after - before)
}

/// Mean and standard error over the walkers of the angle between the chords before and after `at_m`.
fn mean_bend(tracks: &[&[Vec2]], lengths: &[Vec<f64>], at_m: f64, chord_m: f64) -> Option<(f64, f64)> {
    let angles: Vec<f64> =
        tracks.iter().zip(lengths).filter_map(|(t, l)| turn_at(t, l, at_m, chord_m)).collect();
    (angles.len() >= 2).then(|| mean_and_error(&angles))
}

/// The angle between the chords before and after `at_m`, if both are nearly straight.
fn turn_at(track: &[Vec2], lengths: &[f64], at_m: f64, chord_m: f64) -> Option<f64> {
    let at = |s| point_at(track, lengths, s);
    let (a, b, c) = (at(at_m - chord_m)?, at(at_m)?, at(at_m + chord_m)?);
    let (before, after) = (b - a, c - b);
    (before.norm().min(after.norm()) > STRAIGHT * chord_m)
        .then(|| angle_diff(after.y.atan2(after.x), before.y.atan2(before.x)))
}

/// Mean and its standard error, of at least two values.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn path_lengths(track: &[Vec2]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut lengths = vec![0.0];
    for pair in track.windows(2) {
        sum += (pair[1] - pair[0]).norm();
        lengths.push(sum);
    }
    lengths
}

fn point_at(track: &[Vec2], lengths: &[f64], at_m: f64) -> Option<Vec2> {
    if at_m < 0.0 {
        return None;
    }
    let next = lengths.partition_point(|&l| l < at_m);
    let end = *track.get(next)?;
    let Some(before) = next.checked_sub(1) else { return Some(end) };
    let share = (at_m - lengths[before]) / (lengths[next] - lengths[before]);
    Some(track[before] + (end - track[before]) * share)
}
