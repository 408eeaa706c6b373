//! Many walkers in a real building: each goes between a few places that all share, again and again.

use super::gait::{Drift, STEP_M, STEP_S};
use super::{Plan, Route, Settings};
use crate::error::{Error, Result};
use crate::geometry::{Segment, Vec2};
use crate::pedestrian::random::Key;
use crate::simulate::planner::Planner;

/// Places that people go to.
const PLACES: usize = 4;
/// Walks start and turn round at least this far apart, metres.
const APART_M: f64 = 12.0;
/// Strangers keep this far from everybody's ways, metres.
const KEPT_APART_M: f64 = 3.0;
/// Standard deviation of the heading drift of a walker, degrees per minute.
const RATE_DEG_PER_MIN: f64 = 1.5;

pub(super) fn plan(settings: &Settings, walls: &[Segment], key: Key) -> Result<Plan> {
    let planner = Planner::new(walls)?;
    let shared = spread_places(&planner, PLACES, key.named("places"));
    let apart = match settings.strangers + settings.half_strangers {
        0 => Vec::new(),
        _ => places_apart(&planner, &shared, key.named("apart"))?,
    };
    let count = if settings.walkers == 0 { 6 } else { settings.walkers };
    let walkers = (0..count).map(|k| {
        let key = key.named("walker").with(k as u64);
        let is_stranger = k + settings.strangers >= count;
        let is_half = !is_stranger && k + settings.strangers + settings.half_strangers >= count;
        // Of the half strangers every second one begins apart.
        let parts = match (is_stranger, is_half) {
            (true, _) => vec![&apart],
            (_, false) => vec![&shared],
            _ if k % 2 == 0 => vec![&shared, &apart],
            _ => vec![&apart, &shared],
        };
        let route = route(&planner, &parts, settings.minutes, key);
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

/// Two or three places whose ways to each other keep away from all ways between the shared ones.
fn places_apart(planner: &Planner, shared: &[Vec2], key: Key) -> Result<Vec<Vec2>> {
    let way = |from: &Vec2, to: &Vec2| planner.way(*from, *to).unwrap_or_default();
    let sampled = |way: &[Vec2]| -> Vec<Vec2> {
        let along = |pair: &[Vec2]| {
            let (a, d) = (pair[0], pair[1] - pair[0]);
            let count = d.norm().ceil().max(1.0) as usize;
            (0..=count).map(move |k| a + d * (k as f64 / count as f64)).collect::<Vec<_>>()
        };
        way.windows(2).flat_map(along).collect()
    };
    let taken: Vec<Vec2> = shared
        .iter()
        .flat_map(|from| shared.iter().map(move |to| (from, to)))
        .flat_map(|(from, to)| sampled(&way(from, to)))
        .collect();
    let is_apart = |p: &Vec2, by_m: f64| taken.iter().all(|q| (p - q).norm() >= by_m);
    let mut draws =
        (0..2_000).map(|k| planner.place(key.uniform(k))).filter(|p| is_apart(p, 2.0 * KEPT_APART_M));
    for _ in 0..20 {
        let Some(first) = draws.next() else { break };
        let mut found = vec![first];
        for place in draws.by_ref().take(12) {
            let far_enough = found.iter().all(|p| (p - place).norm() >= APART_M / 2.0);
            let ways_apart = || {
                found.iter().flat_map(|p| [(*p, place), (place, *p)]).all(|(from, to)| {
                    let way = sampled(&way(&from, &to));
                    !way.is_empty() && way.iter().all(|p| is_apart(p, KEPT_APART_M))
                })
            };
            if far_enough && ways_apart() {
                found.push(place);
            }
            if found.len() == 3 {
                break;
            }
        }
        if found.len() >= 2 {
            return Ok(found);
        }
    }
    let message =
        "found no part of the building where nobody else goes, expected fewer strangers or a larger one";
    Err(Error::input("strangers", message))
}

/// Between places of the first part for the first part of the time, then of the next.
fn route(planner: &Planner, parts: &[&Vec<Vec2>], minutes: f64, key: Key) -> Route {
    let length_m = minutes * 60.0 / STEP_S * STEP_M;
    let mut here = parts[0][(key.uniform(0) * parts[0].len() as f64) as usize];
    let mut points: Vec<Vec2> = vec![here];
    let mut walked_m = 0.0;
    for draw in 1..10_000 {
        if walked_m >= length_m {
            break;
        }
        let part = (walked_m / length_m * parts.len() as f64) as usize;
        let places = parts[part.min(parts.len() - 1)];
        let next = places[(key.uniform(draw) * places.len() as f64) as usize];
        let Some(way) = (next != here).then(|| planner.way(here, next)).flatten() else {
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
        here = next;
    }
    if points.len() < 2 {
        points.push(points[0] + Vec2::new(STEP_M, 0.0));
    }
    Route { points, marked: Vec::new() }
}
