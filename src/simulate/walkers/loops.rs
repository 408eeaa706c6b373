//! Laps: a ring of corridors, 36 m × 18 m, with a cross passage that is taken in every third lap.

use super::gait::{Drift, STEP_M, STEP_S};
use super::{Plan, Route, Settings};
use crate::geometry::{Segment, Vec2};
use crate::pedestrian::random::Key;

const SIZE_M: [f64; 2] = [36.0, 18.0];
const CROSS_M: f64 = 14.0;
const HALF_WIDTH_M: f64 = 1.2;
/// Drift of a foot-mounted sensor whose bias was mostly removed: standard deviation of the rate.
const RATE_DEG_PER_MIN: f64 = 4.0;

pub(super) fn plan(settings: &Settings, key: Key) -> Plan {
    let length_m = settings.minutes * 60.0 / STEP_S * STEP_M;
    let [w, h] = SIZE_M;
    let at = |x: f64, y: f64| Vec2::new(x, y);
    let long = [at(w, 0.0), at(w, h), at(0.0, h), at(0.0, 0.0)];
    let short = [at(CROSS_M, 0.0), at(CROSS_M, h), at(0.0, h), at(0.0, 0.0)];
    let mut points = vec![at(0.0, 0.0)];
    let (mut walked_m, mut lap) = (0.0, 0);
    'laps: loop {
        let corners: &[Vec2] = if lap % 3 == 2 { &short } else { &long };
        for &corner in corners {
            let here = points[points.len() - 1];
            let leg_m = (corner - here).norm();
            if walked_m + leg_m >= length_m {
                points.push(here + (corner - here) * ((length_m - walked_m).max(0.5 * STEP_M) / leg_m));
                break 'laps;
            }
            walked_m += leg_m;
            points.push(corner);
        }
        lap += 1;
    }
    let route = Route { points, marked: Vec::new() };
    let count = settings.walkers.max(1);
    let walkers = (0..count).map(|k| {
        let per_min = RATE_DEG_PER_MIN * key.named("drift").normal(k as u64);
        let rate_rad_per_m = per_min.to_radians() / (60.0 / STEP_S * STEP_M);
        (
            route.clone(),
            Drift { rate_rad_per_m, heading_rad: 0.2f64.to_radians(), scale: 0.003, ..Drift::STEADY },
        )
    });
    let ring = |a: Vec2, b: Vec2| {
        let c = [a, at(b.x, a.y), b, at(a.x, b.y), a];
        c.windows(2).map(|p| Segment::from_ends(p[0], p[1])).collect::<Vec<_>>()
    };
    let d = HALF_WIDTH_M;
    let mut walls = ring(at(-d, -d), at(w + d, h + d));
    walls.extend(ring(at(d, d), at(CROSS_M - d, h - d)));
    walls.extend(ring(at(CROSS_M + d, d), at(w - d, h - d)));
    Plan { walkers: walkers.collect(), walls, truth_every: 10 }
}
