//! `lost-poses`: the paper's first experiment (Fig. 8, Table 1). A room of 6.33 m and a laser that sees 1.5 m, so that no
//! two parallel walls are ever seen together: between the walls the robot is lost and has its odometry alone.
//!
//! The person knows that a room has right angles (perpendicular, at the corners and between neighbouring walls) and
//! recognises a wall on a later visit (collinear: a plain wall says nothing about the place along it; colocation where
//! a corner shows where it ends). Nothing that is said holds a dimension of the room.

use super::Plan;
use crate::geometry::{Pose2, Vec2};
use crate::map::{Measure, Mode, WallPair};
use crate::simulate::drift::Drift;
use crate::simulate::floor_plan::FloorPlan;
use crate::simulate::lidar::Lidar;
use crate::simulate::route::Route;
use crate::simulate::strokes::{Drawing, Piece};
use crate::simulate::world::World;

const POSES: usize = 270;
/// West to east, metres.
const WIDTH_M: f64 = 6.33;
/// South to north, metres.
const LENGTH_M: f64 = 8.4;
/// How far from a wall the robot drives along it, metres.
const BESIDE_M: f64 = 0.55;

pub fn plan() -> Plan {
    let mut floor_plan = FloorPlan::default();
    let corners =
        [(0.0, 0.0), (WIDTH_M, 0.0), (WIDTH_M, LENGTH_M), (0.0, LENGTH_M)].map(|(x, y)| Vec2::new(x, y));
    for (side, name) in ["south", "east", "north", "west"].into_iter().enumerate() {
        floor_plan.wall(Pose2::IDENTITY, name.into(), corners[side], corners[(side + 1) % 4]);
    }
    let (low, right, top) = (BESIDE_M, WIDTH_M - BESIDE_M, LENGTH_M - BESIDE_M);
    let way = [
        (3.6, low),
        (low, low),
        (low, top),
        (3.4, top),
        (3.2, low),
        (right, low),
        (right, top),
        (low, top),
        (low, 5.6),
        (right, 4.4),
        (right, 2.0),
        (low, 3.3),
        (low, low),
        (1.7, low),
    ];
    Plan {
        world: World::new(floor_plan.walls),
        truth: Route::through(&way.map(|(x, y)| Vec2::new(x, y)), 0.7).poses(POSES),
        lidar: Lidar::half_circle(1.5),
        drift: Drift::scan_matched([24.0, 30.0], 6e-4),
        drawings: drawings(),
        rows: Vec::new(),
        kick: None,
        pairs: pairs(),
    }
}

fn drawings() -> Vec<Drawing> {
    use Mode::{Collinear, Perpendicular};
    let piece = |wall: &str, span_m, visit| Piece::part(wall, span_m, visit);
    let (south, south_later) = (piece("south", [1.1, 2.3], 0), piece("south", [4.4, 5.5], 0));
    let (west, west_later) = (piece("west", [5.6, 6.8], 0), piece("west", [1.2, 2.3], 1));
    let (north, north_later) = (piece("north", [3.6, 4.8], 0), piece("north", [3.0, 4.2], 1));
    let (east, east_later) = (piece("east", [3.0, 4.2], 0), piece("east", [2.5, 3.6], 1));
    vec![
        Drawing::new(Perpendicular, south.clone(), west.clone()),
        Drawing::new(Perpendicular, west.clone(), north.clone()),
        Drawing::new(Collinear, south.clone(), south_later.clone()),
        Drawing::new(Perpendicular, south_later, east.clone()),
        Drawing::new(Collinear, north.clone(), north_later),
        Drawing::new(Perpendicular, north, east.clone()),
        Drawing::new(Collinear, west.clone(), west_later),
        Drawing::new(Collinear, east, east_later),
        Drawing::new(Collinear, south, piece("south", [1.1, 2.3], 1)),
        Drawing::new(Collinear, west, piece("west", [5.6, 6.8], 1)),
    ]
}

fn pairs() -> Vec<WallPair> {
    let mut pairs: Vec<WallPair> = Vec::new();
    for (a, b) in [("west", "east"), ("south", "north")] {
        pairs.extend(Measure::ALL.map(|measure| WallPair::new(a, b, measure)));
    }
    for (a, b) in [("south", "east"), ("east", "north"), ("north", "west"), ("west", "south")] {
        pairs.push(WallPair::new(a, b, Measure::Angle));
    }
    pairs
}
