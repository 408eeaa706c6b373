//! A robot's run through a real building: again and again between a few places, so that it sees walls more than once.

use rand_chacha::rand_core::Rng;
use rand_distr::{Distribution, StandardUniform};

use super::drift::Drift;
use super::lidar::Lidar;
use super::planner::Planner;
use super::route::Route;
use super::scenario::Plan;
use super::world::{Wall, World};
use crate::error::{Error, Result};
use crate::geometry::{Segment, Vec2};

/// Places that the robot goes to.
const PLACES: usize = 5;
/// They are at least this far apart, metres.
const APART_M: f64 = 10.0;
/// From one pose to the next, metres.
const STEP_M: f64 = 0.3;
/// Turning radius, metres.
const TURN_M: f64 = 0.4;
/// Shortest and longest run that makes sense, metres.
const LENGTHS_M: [f64; 2] = [10.0, 5_000.0];

pub(super) fn plan(walls: &[Segment], length_m: f64, random: &mut impl Rng) -> Result<Plan> {
    let [shortest_m, longest_m] = LENGTHS_M;
    if !(shortest_m..=longest_m).contains(&length_m) {
        let message = format!("found {length_m}, expected metres from {shortest_m} to {longest_m}");
        return Err(Error::input("length", message));
    }
    let planner = Planner::new(walls)?;
    let mut share = || -> f64 { StandardUniform.sample(random) };
    let mut places: Vec<Vec2> = Vec::new();
    for _ in 0..1_000 {
        let place = planner.place(share());
        if places.len() < PLACES && places.iter().all(|p| (p - place).norm() >= APART_M) {
            places.push(place);
        }
    }
    let (mut at, mut way, mut driven_m) = (0, vec![places[0]], 0.0);
    for _ in 0..1_000 {
        let next = (share() * places.len() as f64) as usize;
        let leg = if next == at { None } else { planner.way(places[at], places[next]) };
        for p in leg.iter().flatten() {
            let step_m = (p - way[way.len() - 1]).norm();
            if step_m > STEP_M && driven_m < length_m {
                way.push(*p);
                driven_m += step_m;
            }
        }
        at = if leg.is_some() { next } else { at };
    }
    if way.len() < 2 {
        return Err(Error::input("plan", "found nowhere to go, expected a building of more than 10 m"));
    }
    let route = Route::through(&way, TURN_M);
    let named = |(k, segment): (usize, &Segment)| Wall { name: format!("wall/{k}"), segment: *segment };
    Ok(Plan {
        world: World::new(walls.iter().enumerate().map(named).collect()),
        truth: route.poses((route.length_m() / STEP_M).ceil() as usize + 1),
        lidar: Lidar::half_circle(10.0),
        drift: Drift::scan_matched([10.0, 20.0], 6e-4),
        drawings: Vec::new(),
        rows: Vec::new(),
        kick: None,
        pairs: Vec::new(),
    })
}
