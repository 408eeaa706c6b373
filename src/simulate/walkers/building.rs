//! Many walkers in a real building: each goes between a few places that all share, again and again.

use super::gait::{Drift, STEP_M, STEP_S};
use super::{Plan, Route, Settings};
use crate::error::Result;
use crate::geometry::{Segment, Vec2};
use crate::pedestrian::random::Key;
use crate::simulate::planner::Planner;

/// Places that people go to.
const PLACES: usize = 4;
/// Walks start and turn round at least this far apart, metres.
const APART_M: f64 = 12.0;
/// Standard deviation of the heading drift of a walker, degrees per minute.
const RATE_DEG_PER_MIN: f64 = 1.5;

pub(super) fn plan(settings: &Settings, walls: &[Segment], key: Key) -> Result<Plan> {
    let planner = Planner::new(walls)?;
    let places =
        spread_places(&planner, PLACES + if settings.strangers > 0 { 3 } else { 0 }, key.named("places"));
    let (shared, apart) = places.split_at(PLACES.min(places.len()));
    let count = if settings.walkers == 0 { 6 } else { settings.walkers };
    let walkers = (0..count).map(|k| {
        let key = key.named("walker").with(k as u64);
        let is_stranger = k + settings.strangers >= count && apart.len() > 1;
        let route = route(&planner, if is_stranger { apart } else { shared }, settings.minutes, key);
        let per_min = RATE_DEG_PER_MIN * key.named("drift").normal(0);
        let rate_rad_per_m = per_min.to_radians() / (60.0 / STEP_S * STEP_M);
        (route, Drift { rate_rad_per_m, heading_rad: 0.1f64.to_radians(), scale: 0.003, ..Drift::STEADY })
    });
    Ok(Plan { walkers: walkers.collect(), walls: walls.to_vec(), truth_every: 8 })
}

/// Places away from each other, as far as that can be had.
fn spread_places(planner: &Planner, count: usize, key: Key) -> Vec<Vec2> {
    let mut places: Vec<Vec2> = Vec::new();
    for attempt in 0..2_000 {
        let place = planner.place(key.uniform(attempt));
        if places.iter().all(|p| (p - place).norm() >= APART_M) {
            places.push(place);
        }
        if places.len() == count {
            break;
        }
    }
    places
}

fn route(planner: &Planner, places: &[Vec2], minutes: f64, key: Key) -> Route {
    let length_m = minutes * 60.0 / STEP_S * STEP_M;
    let mut at = (key.uniform(0) * places.len() as f64) as usize;
    let mut points: Vec<Vec2> = vec![places[at]];
    let mut walked_m = 0.0;
    for draw in 1..10_000 {
        if walked_m >= length_m {
            break;
        }
        let next = (key.uniform(draw) * places.len() as f64) as usize;
        let Some(way) = (next != at).then(|| planner.way(places[at], places[next])).flatten() else {
            continue;
        };
        for p in &way[1..] {
            let step = p - points[points.len() - 1];
            if step.norm() < 0.05 {
                continue;
            }
            walked_m += step.norm();
            points.push(*p);
            if walked_m >= length_m {
                break;
            }
        }
        at = next;
    }
    if points.len() < 2 {
        points.push(points[0] + Vec2::new(STEP_M, 0.0));
    }
    Route { points, marked: Vec::new() }
}
