//! `campus`: three buildings at angles to each other, a lap and a quarter of each, and the walkways between them.
//!
//! One correction closes the lap of each building where the robot comes round to where it entered, close to a
//! corner: there the two visits lie farthest apart across the corridor and are not mistaken for each other. In building
//! `a` the visits show different pieces of one long wall, so the person can only say that they are collinear. The fourth
//! closes the tour through all three buildings, in the corridor by which the robot comes back.

use super::Plan;
use crate::geometry::{Pose2, Vec2};
use crate::map::{Measure, Mode, WallPair};
use crate::simulate::drift::Drift;
use crate::simulate::floor_plan::FloorPlan;
use crate::simulate::lidar::Lidar;
use crate::simulate::ring::Ring;
use crate::simulate::route::Route;
use crate::simulate::strokes::{Drawing, Piece};
use crate::simulate::world::World;

const POSES: usize = 3_100;
const SOUTH: usize = 0;
const EAST: usize = 1;
const NORTH: usize = 2;
const WEST: usize = 3;

pub fn plan() -> Plan {
    let building = |name, x_m: f64, y_m: f64, turn_deg: f64, gates: [usize; 2]| Ring {
        name,
        world_from_ring: Pose2::new(x_m, y_m, turn_deg.to_radians()),
        half: Vec2::new(20.0, 12.0),
        corridor_m: 2.4,
        gates: gates.to_vec(),
        facade_m: Some(4.5),
    };
    let a = building("a", 0.0, 0.0, 0.0, [EAST, NORTH]);
    let b = building("b", 72.0, 12.0, 25.0, [WEST, NORTH]);
    let c = building("c", 28.0, 68.0, -40.0, [EAST, SOUTH]);

    let mut floor_plan = FloorPlan::default();
    [&a, &b, &c].iter().for_each(|building| building.build(&mut floor_plan));
    walkway(&mut floor_plan, "walk-ab", a.before_gate(EAST, 2.0), b.before_gate(WEST, 2.0));
    walkway(&mut floor_plan, "walk-bc", b.before_gate(NORTH, 2.0), c.before_gate(EAST, 2.0));
    walkway(&mut floor_plan, "walk-ca", c.before_gate(SOUTH, 2.0), a.before_gate(NORTH, 2.0));

    Plan {
        world: World::new(floor_plan.walls),
        truth: Route::through(&waypoints(&a, &b, &c), 1.0).poses(POSES),
        lidar: Lidar::half_circle(12.0),
        drift: Drift::scan_matched([10.0, 12.5], 4e-4),
        drawings: drawings(),
        rows: [&a, &b, &c].into_iter().flat_map(Ring::outer_rows).collect(),
        kick: None,
        pairs: pairs(),
    }
}

/// The outer walls of each building: what runs along one corridor against what runs along the others.
fn pairs() -> Vec<WallPair> {
    let mut pairs = Vec::new();
    for building in ["a", "b", "c"] {
        let wall = |piece: &str| format!("{building}/{piece}");
        let (south, north) = (wall("south-outer/2"), wall("north-outer/4"));
        let (east, west) = (wall("east-outer/3"), wall("west-outer/3"));
        pairs.push(WallPair::new(&south, &north, Measure::Angle));
        pairs.push(WallPair::new(&east, &west, Measure::Angle));
        pairs.push(WallPair::new(&south, &east, Measure::Angle));
        pairs.push(WallPair::new(&north, &west, Measure::Angle));
        pairs.push(WallPair::new(&south, &north, Measure::Distance));
        pairs.push(WallPair::new(&east, &west, Measure::Distance));
    }
    pairs
}

fn drawings() -> Vec<Drawing> {
    let same = |wall| Drawing::new(Mode::Colocation, Piece::whole(wall, 0), Piece::whole(wall, 1));
    vec![
        Drawing::new(
            Mode::Collinear,
            Piece::whole("a/south-outer/10", 0),
            Piece::whole("a/south-outer/11", 1),
        ),
        same("b/north-outer/9"),
        same("c/south-outer/10"),
        same("a/west-outer/3"),
    ]
}

/// A lap and a quarter of each building, and back to the first: 660 m.
fn waypoints(a: &Ring, b: &Ring, c: &Ring) -> Vec<Vec2> {
    let mut way = vec![a.on_side(SOUTH, -0.3)];
    way.extend([SOUTH, EAST, NORTH, WEST, SOUTH].map(|side| a.corner_after(side)));
    leave(&mut way, a, EAST);
    enter(&mut way, b, WEST);
    // Clockwise: every corner is the one before its side.
    way.extend([NORTH, EAST, SOUTH, WEST].map(|side| b.corner_after(side)).into_iter().cycle().take(5));
    leave(&mut way, b, NORTH);
    enter(&mut way, c, EAST);
    way.extend([SOUTH, WEST, NORTH, EAST].map(|side| c.corner_after(side)).into_iter().cycle().take(5));
    leave(&mut way, c, SOUTH);
    enter(&mut way, a, NORTH);
    way.extend([NORTH, WEST].map(|side| a.corner_after(side)));
    way.push(a.on_side(SOUTH, 0.3));
    way
}

fn leave(way: &mut Vec<Vec2>, building: &Ring, side: usize) {
    way.extend([building.on_side(side, 0.0), building.before_gate(side, 2.0)]);
}

fn enter(way: &mut Vec<Vec2>, building: &Ring, side: usize) {
    way.extend([building.before_gate(side, 2.0), building.on_side(side, 0.0)]);
}

/// Broken rows of hedge on both sides of a straight way.
fn walkway(plan: &mut FloorPlan, name: &str, from: Vec2, to: Vec2) {
    let way = to - from;
    let world_from_way = Pose2::new(from.x, from.y, way.y.atan2(way.x));
    for (side, across_m, first) in [("left", 2.0, 0), ("right", -2.2, 1)] {
        let mut at_m = 1.0;
        for (k, (hedge_m, gap_m)) in
            [(3.2, 0.8), (1.9, 1.4), (4.1, 0.6)].into_iter().cycle().skip(first).enumerate()
        {
            if at_m + hedge_m > way.norm() - 1.0 {
                break;
            }
            let [p, q] = [at_m, at_m + hedge_m].map(|x_m| Vec2::new(x_m, across_m));
            plan.wall(world_from_way, format!("{name}/{side}/{k}"), p, q);
            at_m += hedge_m + gap_m;
        }
    }
}
