//! Where a damage happens: drawn among the places where it hurts, which is where the robot moves and has been and will be.

use rand_chacha::rand_core::Rng;
use rand_distr::{Distribution, StandardUniform};

use super::{Kind, Settings};
use crate::error::{Error, Result};
use crate::geometry::Pose2;

/// Length of a slip, metres.
const SLIP_M: f64 = 20.0;
/// Length of a blindness or of a gap, seconds.
const GAP_S: f64 = 60.0;
/// Shares of the whole way between which a damage lies: before, there is no map to bend; after, none that is bent.
const MIDDLE: [f64; 2] = [0.1, 0.9];
/// A robot moves if it goes at least this share of its mean speed.
const MOVING: f64 = 0.5;

/// The way that a robot took, by its odometry or its map.
pub(super) struct Drive {
    pub poses: Vec<Pose2>,
    pub stamps_s: Option<Vec<f64>>,
}

impl Drive {
    /// Way between two of its poses.
    pub fn path_m(&self, first: usize, last: usize) -> f64 {
        self.poses[first..=last].windows(2).map(|p| step_m(p[0], p[1])).sum()
    }

    /// Way from the first pose to each.
    fn odometer_m(&self) -> Vec<f64> {
        let mut odometer_m = vec![0.0];
        for (k, pair) in self.poses.windows(2).enumerate() {
            odometer_m.push(odometer_m[k] + step_m(pair[0], pair[1]));
        }
        odometer_m
    }
}

fn step_m(a: Pose2, b: Pose2) -> f64 {
    (b.translation() - a.translation()).norm()
}

/// The spans (first, last) of `settings.count` damages, apart from each other, in the order of the drive.
pub(super) fn choose(
    place: &str,
    drive: &Drive,
    settings: &Settings,
    random: &mut impl Rng,
) -> Result<Vec<(usize, usize)>> {
    let mut candidates = candidates(place, drive, settings.kind)?;
    let mut chosen: Vec<(usize, usize)> = Vec::with_capacity(settings.count);
    while chosen.len() < settings.count {
        if candidates.is_empty() {
            let message = format!(
                "found room for {} of {} damages ({}), expected a longer drive or a smaller --count",
                chosen.len(),
                settings.count,
                settings.kind
            );
            return Err(Error::input(place, message));
        }
        let share: f64 = StandardUniform.sample(random);
        let span = candidates[((share * candidates.len() as f64) as usize).min(candidates.len() - 1)];
        candidates.retain(|c| c.1 < span.0 || c.0 > span.1);
        chosen.push(span);
    }
    chosen.sort_unstable();
    Ok(chosen)
}

/// Every span that such a damage could have.
fn candidates(place: &str, drive: &Drive, kind: Kind) -> Result<Vec<(usize, usize)>> {
    let n = drive.poses.len();
    let odometer_m = drive.odometer_m();
    let way_m = odometer_m[n.saturating_sub(1)];
    if way_m <= 0.0 {
        return Err(Error::input(place, "found a robot that does not move, expected one that drives"));
    }
    let [from_m, to_m] = MIDDLE.map(|share| share * way_m);
    let inside = |&(first, last): &(usize, usize)| odometer_m[first] >= from_m && odometer_m[last] <= to_m;
    let spans: Vec<(usize, usize)> = match kind {
        Kind::Drift => return Ok(vec![(0, n - 1)]),
        Kind::Kick => {
            let fair_m = MOVING * way_m / (n - 1) as f64;
            let moves = |k: &usize| odometer_m[k + 1] - odometer_m[*k] >= fair_m;
            (0..n - 1).filter(moves).map(|k| (k, k + 1)).collect()
        }
        Kind::Slip => {
            let end = |k: usize| odometer_m.partition_point(|&m| m < odometer_m[k] + SLIP_M);
            let moves = |k: &usize| odometer_m[k + 1] > odometer_m[*k];
            (0..n - 1).filter(moves).map(|k| (k, end(k))).take_while(|s| s.1 < n).collect()
        }
        Kind::Blind | Kind::Drop => {
            let Some(stamps_s) = &drive.stamps_s else { return Ok(Vec::new()) };
            let last_s = stamps_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let fair_m = MOVING * way_m * GAP_S / (last_s - stamps_s[0]).max(GAP_S);
            // Stamps need not increase: the first scan that is late enough ends it.
            let end = |k: usize| (k..n).find(|&l| stamps_s[l] >= stamps_s[k] + GAP_S);
            let far = |s: &(usize, usize)| odometer_m[s.1] - odometer_m[s.0] >= fair_m;
            (0..n).filter_map(|k| Some((k, end(k)?.checked_sub(1)?))).filter(far).collect()
        }
    };
    Ok(spans.into_iter().filter(inside).collect())
}
