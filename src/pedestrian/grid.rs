//! Which hexagon grid: turned to the group's walking direction, fixed, or drawn anew; and when not to trust the first.
//!
//! A hexagon map holds paths near the grid's axes more easily than others. On an axis that is a straight-corridor
//! prior and takes out drift; a leg that truly runs a few degrees off an axis would be bent onto it. Walkers drift each
//! in their own way but turn where the building turns: a change of direction that *all* walkers have at the same place
//! is the building's. If it leaves the direction within reach of an axis but off it, the aligned grid does harm, and the
//! run goes on with [`GridChoice::Regrid`](super::GridChoice), which prefers no direction.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use super::hex::HexGrid;
use super::random::Key;
use crate::geometry::{Vec2, angle_diff, wrap_angle};

/// The direction is taken from this much of every walk, metres, or from the first round if that is shorter.
pub const ALIGN_WITHIN_M: f64 = 15.0;
/// Below this concentration there is no common direction.
pub const MIN_CONCENTRATION: f64 = 0.9;
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

/// Where a group is heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupDirection {
    /// Direction modulo 90°, radians in (−π/4, π/4].
    pub angle_rad: f64,
    /// 1: all steps go along it or across; 0: they go anywhere.
    pub concentration: f64,
}

/// The common direction (modulo 90°) of tracks: arg Σ (|v|/3L)⁸ e^{4iθ} / 4 over the chords v of three steps of
/// typical length L; the power keeps out chords that span a corner. `None` if nobody moves.
pub fn group_direction<'a>(tracks: impl Iterator<Item = (&'a [Vec2], f64)>) -> Option<GroupDirection> {
    let (mut sum, mut weights) = (Vec2::zeros(), 0.0);
    for (track, typical_m) in tracks {
        for chord in track.windows(4) {
            let v = chord[3] - chord[0];
            let weight = (v.norm() / (3.0 * typical_m)).min(1.2).powi(8);
            let (s, c) = (4.0 * v.y.atan2(v.x)).sin_cos();
            sum += Vec2::new(c, s) * weight;
            weights += weight;
        }
    }
    let direction =
        GroupDirection { angle_rad: sum.y.atan2(sum.x) / 4.0, concentration: sum.norm() / weights };
    (weights > 0.0).then_some(direction)
}

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

/// Mean and standard error over the walkers of the angle between the chords before and after `at_m`.
fn mean_bend(tracks: &[&[Vec2]], lengths: &[Vec<f64>], at_m: f64, chord_m: f64) -> Option<(f64, f64)> {
    let mut angles = Vec::new();
    for (track, lengths) in tracks.iter().zip(lengths) {
        let at = |s| point_at(track, lengths, s);
        let (Some(a), Some(b), Some(c)) = (at(at_m - chord_m), at(at_m), at(at_m + chord_m)) else {
            continue;
        };
        let (before, after) = (b - a, c - b);
        if before.norm().min(after.norm()) > STRAIGHT * chord_m {
            angles.push(angle_diff(after.y.atan2(after.x), before.y.atan2(before.x)));
        }
    }
    if angles.len() < 2 {
        return None;
    }
    let count = angles.len() as f64;
    let mean = angles.iter().sum::<f64>() / count;
    let variance = angles.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Some((mean, (variance / count).sqrt()))
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

/// A grid with a random angle and offset: the same for all walkers of an iteration.
pub fn random_grid(radius_m: f64, origin: Vec2, key: Key) -> HexGrid {
    let offset = Vec2::new(key.uniform(1), key.uniform(2)) * (2.0 * radius_m);
    let angle_rad = wrap_angle(key.uniform(0) * FRAC_PI_2 * (2.0 / 3.0));
    HexGrid { radius_m, angle_rad, origin: origin + offset }
}
