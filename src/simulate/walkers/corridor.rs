//! The paper's experiment and its controls: 4 m down, a turn to the left, 38 m of corridor.
//!
//! Drifts are given as the sideways error at the corridor's end: a heading error that grows evenly over the corridor
//! by 2e/L² per metre gives e there. The paper has two walks that end too low, two a little and two well too high; it
//! names no magnitudes, these are ours (mean +1.2 m), and vary by ±15 % from seed to seed.

use super::gait::Drift;
use super::{Plan, Route, Scenario, Settings};
use crate::geometry::{Segment, Vec2};
use crate::pedestrian::random::Key;

const ENTRANCE_M: f64 = 4.0;
const CORRIDOR_M: f64 = 38.0;
/// Half the corridor's width.
const HALF_WIDTH_M: f64 = 1.2;
const DOOR_M: f64 = 1.0;
/// Marked points of the corridor (the paper's rounds end there).
const MARKS_M: [f64; 3] = [10.0, 20.0, 30.0];

pub(super) fn plan(scenario: Scenario, settings: &Settings, key: Key) -> Plan {
    let ends_m: &[f64] = match scenario {
        Scenario::Opposite => &[3.0, 2.0, 1.0, -1.0, -2.0, -3.0],
        Scenario::OneSided => &[3.0; 6],
        _ => &[4.0, 3.4, 0.8, 0.6, -0.8, -1.0],
    };
    let count = if settings.walkers == 0 { ends_m.len() } else { settings.walkers };
    let centre_line = centre_line(scenario, settings);
    let walkers = (0..count).map(|k| {
        let spread = if scenario == Scenario::Opposite { 0.0 } else { 0.15 };
        let factor = 1.0 + spread * (2.0 * key.named("drift").uniform(k as u64) - 1.0);
        let end_m = ends_m[k % ends_m.len()] * factor;
        let rate_rad_per_m = 2.0 * end_m / (CORRIDOR_M * CORRIDOR_M);
        let route = if scenario == Scenario::Rooms && k % 2 == 1 {
            with_room(&centre_line)
        } else {
            centre_line.clone()
        };
        (route, Drift { rate_rad_per_m, from_m: ENTRANCE_M, ..Drift::STEADY })
    });
    Plan { walkers: walkers.collect(), walls: walls(&centre_line, scenario), truth_every: 0 }
}

/// The corridor's middle at a distance from its start.
fn corridor_point(scenario: Scenario, settings: &Settings, along_m: f64) -> Vec2 {
    let start = Vec2::new(0.0, -ENTRANCE_M);
    match scenario {
        Scenario::Corner => {
            let straight_m = along_m.min(settings.bend_at_m);
            let (s, c) = settings.bend_deg.to_radians().sin_cos();
            start + Vec2::new(straight_m, 0.0) + Vec2::new(c, s) * (along_m - straight_m)
        }
        Scenario::Curve => {
            // Straight for the first 10 m, then an arc.
            let straight_m = along_m.min(MARKS_M[0]);
            let (s, c) = ((along_m - straight_m) / settings.radius_m).sin_cos();
            start + Vec2::new(straight_m, 0.0) + Vec2::new(s, 1.0 - c) * settings.radius_m
        }
        _ => start + Vec2::new(along_m, 0.0),
    }
}

fn centre_line(scenario: Scenario, settings: &Settings) -> Route {
    let mut stations: Vec<(f64, bool)> = MARKS_M.map(|m| (m, true)).to_vec();
    stations.push((CORRIDOR_M, true));
    match scenario {
        Scenario::Corner if !MARKS_M.contains(&settings.bend_at_m) => {
            stations.push((settings.bend_at_m, false))
        }
        Scenario::Curve => {
            stations.extend((0..).map(|k| 11.4 + 1.4 * f64::from(k)).take(19).map(|m| (m, false)))
        }
        _ => {}
    }
    stations.sort_by(|a, b| a.0.total_cmp(&b.0));
    stations.dedup_by(|a, b| (a.0 - b.0).abs() < 0.2);
    let mut route = Route { points: vec![Vec2::zeros(), Vec2::new(0.0, -ENTRANCE_M)], marked: vec![0, 1] };
    for (along_m, is_marked) in stations {
        if is_marked {
            route.marked.push(route.points.len());
        }
        route.points.push(corridor_point(scenario, settings, along_m));
    }
    route
}

/// The route with a detour of 3 m into a room on the left before the first mark.
fn with_room(route: &Route) -> Route {
    let door = Vec2::new(6.0, -ENTRANCE_M);
    let inside = door + Vec2::new(0.0, 3.0);
    let mut points = route.points.clone();
    points.splice(2..2, [door, inside, inside + Vec2::new(0.7, 0.0), door + Vec2::new(0.7, 0.0)]);
    let marked = route.marked.iter().map(|&k| if k >= 2 { k + 4 } else { k }).collect();
    Route { points, marked }
}

fn walls(route: &Route, scenario: Scenario) -> Vec<Segment> {
    let mut walls = Vec::new();
    let mut add = |points: &[Vec2]| walls.extend(points.windows(2).map(|w| Segment::from_ends(w[0], w[1])));
    let w = HALF_WIDTH_M;
    // The entrance comes from above; the corridor closes below it.
    add(&[Vec2::new(-w, 1.0), Vec2::new(-w, -ENTRANCE_M - w)]);
    let line = &route.points[1..];
    let side = |k: usize, across_m: f64| {
        let (a, b) = (line[k.saturating_sub(1)], line[(k + 1).min(line.len() - 1)]);
        let d = (b - a).normalize();
        line[k] + Vec2::new(-d.y, d.x) * across_m
    };
    let mut lower: Vec<Vec2> = (0..line.len()).map(|k| side(k, -w)).collect();
    lower[0] = Vec2::new(-w, -ENTRANCE_M - w);
    add(&lower);
    let mut upper = vec![Vec2::new(w, 1.0), Vec2::new(w, -ENTRANCE_M + w)];
    if scenario == Scenario::Rooms {
        let (left, right, y) = (6.35 - DOOR_M, 6.35 + DOOR_M, -ENTRANCE_M + w);
        upper.push(Vec2::new(left, y));
        add(&upper);
        add(&[
            [left, y],
            [left - 1.0, y],
            [left - 1.0, y + 4.0],
            [right + 1.0, y + 4.0],
            [right + 1.0, y],
            [right, y],
        ]
        .map(|[x, y]| Vec2::new(x, y)));
        upper = vec![Vec2::new(right, y)];
    }
    upper.extend((1..line.len()).map(|k| side(k, w)));
    add(&upper);
    walls
}
