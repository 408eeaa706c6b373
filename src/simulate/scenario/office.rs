//! `office-bent` and `office-kick`: a floor of two long corridors and two short ones, as in the paper's Fig. 6, driven
//! once round and then a good part of the first corridor again. Bent severely by a heading error that goes on all
//! the way, or hardly bent and broken in one place: 30° of heading are lost between two poses, and the odometry's
//! covariance says nothing of it.

use super::{Kick, Plan};
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
/// Step of the failure: in the middle of the north corridor.
const KICK_STEP: usize = 330;
const KICK_DEG: f64 = 30.0;
/// How much more than usual the person's word counts where the corridor is torn. At weight 1 a relation is good for
/// 0.6° and the step for 0.2°: least squares would then believe the step, which is off by 150 of its own σ.
const TORN_WEIGHT: f64 = 1e3;

pub fn bent() -> Plan {
    plan(Drift::scan_matched([25.0, 32.0], 6e-4), None, usual_drawings())
}

pub fn kick() -> Plan {
    let kick = Kick { step: KICK_STEP, heading_rad: KICK_DEG.to_radians() };
    let (before, after) = ([KICK_STEP - 30, KICK_STEP + 1], [KICK_STEP + 1, KICK_STEP + 31]);
    let torn = |wall: &str| Drawing {
        weight: TORN_WEIGHT,
        ..Drawing::new(
            Mode::Colocation,
            Piece::whole(wall, 0).within(before),
            Piece::whole(wall, 0).within(after),
        )
    };
    let mut drawings = vec![torn("office/north-outer/6"), torn("office/north-inner/4")];
    drawings.extend(usual_drawings());
    plan(Drift::scan_matched([6.2, 7.8], 6e-4), Some(kick), drawings)
}

/// What a person would say of either map: the lap is closed, the corridors are straight, their corners square, and
/// what of the first corridor is seen again is where it was.
fn usual_drawings() -> Vec<Drawing> {
    let first = |wall: &str| Piece::whole(wall, 0);
    let pair = |mode, a, b| Drawing::new(mode, first(a), first(b));
    let again = |wall: &str| Drawing::new(Mode::Colocation, first(wall), Piece::whole(wall, 1));
    vec![
        again("office/south-outer/4"),
        pair(Mode::Collinear, "office/south-outer/4", "office/south-outer/11"),
        pair(Mode::Perpendicular, "office/south-outer/9", "office/east-outer/2"),
        pair(Mode::Perpendicular, "office/east-outer/2", "office/north-outer/2"),
        pair(Mode::Collinear, "office/north-outer/2", "office/north-outer/10"),
        pair(Mode::Perpendicular, "office/north-outer/10", "office/west-outer/1"),
        pair(Mode::Collinear, "office/south-outer/4", "office/south-outer/6"),
        pair(Mode::Collinear, "office/north-outer/5", "office/north-outer/10"),
        again("office/south-outer/6"),
        again("office/south-outer/8"),
    ]
}

fn plan(drift: Drift, kick: Option<Kick>, drawings: Vec<Drawing>) -> Plan {
    let ring = Ring {
        name: "office",
        world_from_ring: Pose2::IDENTITY,
        half: Vec2::new(22.0, 6.5),
        corridor_m: 2.4,
        gates: Vec::new(),
        facade_m: None,
    };
    let mut floor_plan = FloorPlan::default();
    ring.build(&mut floor_plan);
    let mut waypoints = vec![ring.on_side(0, -0.6)];
    waypoints.extend((0..4).map(|side| ring.corner_after(side)));
    waypoints.push(ring.on_side(0, 0.5));
    Plan {
        world: World::new(floor_plan.walls),
        truth: Route::through(&waypoints, 1.0).poses(POSES),
        lidar: Lidar::half_circle(10.0),
        drift,
        drawings,
        rows: ring.outer_rows().collect(),
        kick,
        pairs: pairs(),
    }
}

/// As in the paper: the spacing of the two long corridors, which is the same all along them, and the angles between
/// walls that are known to be parallel or perpendicular.
fn pairs() -> Vec<WallPair> {
    let across = [(1, 11), (4, 7), (6, 5), (9, 2), (11, 1)];
    let walls = across.map(|(s, n)| (format!("office/south-outer/{s}"), format!("office/north-outer/{n}")));
    let mut pairs: Vec<WallPair> =
        walls.iter().flat_map(|(s, n)| Measure::ALL.map(|measure| WallPair::new(s, n, measure))).collect();
    for side in ["office/east-outer/2", "office/west-outer/2"] {
        for (s, n) in [&walls[1], &walls[3]] {
            pairs.extend([s, n].map(|wall| WallPair::new(wall, side, Measure::Angle)));
        }
    }
    pairs.push(WallPair::new("office/east-outer/2", "office/west-outer/2", Measure::Angle));
    pairs
}
