//! Candidate motions that bring one set of paths onto another, by voting (Garcia Puyol 2017, after Hough).
//!
//! Rotation: circular cross-correlation of the histograms of walking directions (modulo 180°: ways lead both ways).
//! Translation, for each good rotation: every pair of places with like direction votes for its difference.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::geometry::{Pose2, Vec2};

/// Histogram of directions: bins over 180°.
const BINS: usize = 180;
/// Side of a place, and of a bin of translations, metres.
const PLACE_M: f64 = 0.5;
/// Places whose directions fall into the same of so many classes over 180° vote.
const CLASSES: usize = 9;
/// Rotations tried (each also turned by 180°), and peaks of translation kept for each.
const ROTATIONS: usize = 10;
const TRANSLATIONS: usize = 4;
/// Peaks of rotation are this far apart at least, bins.
const APART: usize = 3;

/// Places on paths: where, direction modulo π, how often.
#[derive(Debug, Clone)]
struct Place {
    at: Vec2,
    direction_rad: f64,
    weight: f64,
}

/// Motions that take `paths` onto `fixed`, most votes first within each rotation.
pub fn candidates(fixed: &[&[Vec2]], paths: &[&[Vec2]]) -> Vec<Pose2> {
    let (fixed, moving) = (places(fixed), places(paths));
    let (a, b) = (histogram(&fixed), histogram(&moving));
    let score = |shift: usize| (0..BINS).map(|k| a[(k + shift) % BINS] * b[k]).sum::<f64>();
    let mut shifts: Vec<(f64, usize)> = (0..BINS).map(|shift| (score(shift), shift)).collect();
    shifts.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut chosen: Vec<usize> = Vec::new();
    for (_, shift) in shifts {
        let distance = |other: &usize| shift.abs_diff(*other).min(BINS - shift.abs_diff(*other));
        if chosen.len() < ROTATIONS && chosen.iter().all(|c| distance(c) >= APART) {
            chosen.push(shift);
        }
    }
    let mut motions = Vec::new();
    for shift in chosen {
        for half_turn in [0.0, PI] {
            let angle_rad = shift as f64 * PI / BINS as f64 + half_turn;
            for t in translations(&fixed, &moving, angle_rad) {
                motions.push(Pose2::new(t.x, t.y, angle_rad));
            }
        }
    }
    motions
}

/// Places that paths come through, in a fixed order.
fn places(paths: &[&[Vec2]]) -> Vec<Place> {
    let mut found: BTreeMap<(i64, i64, usize), Place> = BTreeMap::new();
    for path in paths {
        // Over three steps: a single one says little about the direction.
        for chord in path.windows(4) {
            let v = chord[3] - chord[0];
            if v.norm() < 1.0 {
                continue;
            }
            let (at, direction_rad) = ((chord[1] + chord[2]) / 2.0, v.y.atan2(v.x).rem_euclid(PI));
            let class = (direction_rad / PI * CLASSES as f64) as usize % CLASSES;
            let key = ((at.x / PLACE_M).floor() as i64, (at.y / PLACE_M).floor() as i64, class);
            let place = found.entry(key).or_insert(Place { at, direction_rad, weight: 0.0 });
            place.weight += 1.0;
        }
    }
    // A place visited often counts more, but not in proportion: the shape of the ways matters.
    found.into_values().map(|p| Place { weight: p.weight.sqrt(), ..p }).collect()
}

/// Weights of the directions, a little smoothed.
fn histogram(places: &[Place]) -> Vec<f64> {
    let mut raw = vec![0.0; BINS];
    for place in places {
        raw[(place.direction_rad / PI * BINS as f64) as usize % BINS] += place.weight;
    }
    let at = |k: usize, d: usize| raw[(k + BINS - 2 + d) % BINS];
    (0..BINS).map(|k| at(k, 0) + 2.0 * at(k, 1) + 3.0 * at(k, 2) + 2.0 * at(k, 3) + at(k, 4)).collect()
}

/// The translations with the most votes after turning by an angle.
fn translations(fixed: &[Place], moving: &[Place], angle_rad: f64) -> Vec<Vec2> {
    let turn = Pose2::new(0.0, 0.0, angle_rad);
    let class = |direction_rad: f64| (direction_rad.rem_euclid(PI) / PI * CLASSES as f64) as usize % CLASSES;
    let turned: Vec<(Vec2, usize, f64)> = moving
        .iter()
        .map(|p| (turn.transform_point(p.at), class(p.direction_rad + angle_rad), p.weight))
        .collect();
    let mut by_class = vec![Vec::new(); CLASSES];
    for place in fixed {
        by_class[class(place.direction_rad)].push((place.at, place.weight));
    }
    let extent = |points: &mut dyn Iterator<Item = Vec2>| {
        points
            .fold(None, |e: Option<(Vec2, Vec2)>, p| Some(e.map_or((p, p), |(l, h)| (l.inf(&p), h.sup(&p)))))
    };
    let Some((low_a, high_a)) = extent(&mut fixed.iter().map(|p| p.at)) else { return Vec::new() };
    let Some((low_b, high_b)) = extent(&mut turned.iter().map(|p| p.0)) else { return Vec::new() };
    let (low, high) = (low_a - high_b, high_a - low_b);
    let columns = ((high.x - low.x) / PLACE_M) as usize + 3;
    let rows = ((high.y - low.y) / PLACE_M) as usize + 3;
    let mut votes = vec![0.0_f32; columns * rows];
    for (at, class, weight) in &turned {
        for (other, other_weight) in &by_class[*class] {
            let d = (other - at - low) / PLACE_M;
            votes[(d.y as usize + 1) * columns + d.x as usize + 1] += (weight * other_weight) as f32;
        }
    }
    let mut peaks: Vec<(f32, usize)> = Vec::new();
    for row in 1..rows - 1 {
        for column in 1..columns - 1 {
            let at = row * columns + column;
            let sum: f32 = [at - columns, at, at + columns]
                .iter()
                .map(|k| votes[k - 1] + votes[*k] + votes[k + 1])
                .sum();
            if sum > 0.0 {
                peaks.push((sum, at));
            }
        }
    }
    peaks.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    let mut chosen: Vec<Vec2> = Vec::new();
    for (_, at) in peaks {
        let (column, row) = ((at % columns) as f64 - 0.5, (at / columns) as f64 - 0.5);
        let t = low + Vec2::new(column, row) * PLACE_M;
        if chosen.iter().all(|c| (c - t).norm() > 2.0) {
            chosen.push(t);
        }
        if chosen.len() == TRANSLATIONS {
            break;
        }
    }
    chosen
}
