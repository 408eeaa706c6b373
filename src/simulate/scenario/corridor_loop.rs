//! `loop`: a ring of corridors of 34 × 23 m, driven once and then 21 m more, so that the start is seen again.
//!
//! The first correction closes the loop with the piece of wall that both visits show best. The other two straighten
//! what a loop closure leaves bent in the middle of the loop, which is little: the west corridor is at a right angle
//! to the one where the robot started, the north corridor parallel to it.

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

const POSES: usize = 650;

pub fn plan() -> Plan {
    let ring = Ring {
        name: "ring",
        world_from_ring: Pose2::IDENTITY,
        half: Vec2::new(17.0, 11.5),
        corridor_m: 2.4,
        gates: Vec::new(),
        facade_m: None,
    };
    let mut floor_plan = FloorPlan::default();
    ring.build(&mut floor_plan);
    let mut waypoints = vec![ring.on_side(0, -0.35)];
    waypoints.extend((0..4).map(|side| ring.corner_after(side)));
    waypoints.push(ring.on_side(0, 0.88));

    Plan {
        world: World::new(floor_plan.walls),
        truth: Route::through(&waypoints, 1.0).poses(POSES),
        lidar: Lidar::half_circle(10.0),
        drift: Drift::scan_matched([6.2, 7.8], 6e-4),
        drawings: vec![
            Drawing::new(
                Mode::Colocation,
                Piece::whole("ring/south-outer/8", 0),
                Piece::whole("ring/south-outer/8", 1),
            ),
            Drawing::new(
                Mode::Perpendicular,
                Piece::whole("ring/south-outer/8", 0),
                Piece::whole("ring/west-outer/3", 0),
            ),
            Drawing::new(
                Mode::Parallel,
                Piece::whole("ring/south-outer/8", 0),
                Piece::whole("ring/north-outer/4", 0),
            ),
        ],
        rows: ring.outer_rows().collect(),
        kick: None,
        pairs: pairs(),
    }
}

/// Each side against the one across and the one after it.
fn pairs() -> Vec<WallPair> {
    let pair = |a: &str, b: &str, measure| WallPair::new(&format!("ring/{a}"), &format!("ring/{b}"), measure);
    vec![
        pair("south-outer/6", "north-outer/4", Measure::Angle),
        pair("east-outer/3", "west-outer/3", Measure::Angle),
        pair("south-outer/6", "east-outer/3", Measure::Angle),
        pair("east-outer/3", "north-outer/4", Measure::Angle),
        pair("north-outer/4", "west-outer/3", Measure::Angle),
        pair("south-outer/6", "north-outer/4", Measure::Distance),
        pair("east-outer/3", "west-outer/3", Measure::Distance),
    ]
}
