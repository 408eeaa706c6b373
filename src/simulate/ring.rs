//! A building: a rectangular ring of corridors, with doors, alcoves and pillars, and gates in the middle of its sides.
//!
//! Frame: the ring's middle, x to the east. Sides are numbered and named in driving order, counter-clockwise:
//! south, east, north, west. Rows are named `building/side-outer/…`, `-inner`, `-facade`.

use super::floor_plan::{Feature, FloorPlan, Shape};
use crate::geometry::{Pose2, Vec2};

const SIDES: [&str; 4] = ["south", "east", "north", "west"];
const GATE_M: f64 = 1.8;
/// Nothing else interrupts a wall so close to the middle of a gate.
const GATE_CLEARANCE_M: f64 = 2.8;

/// A ring of corridors.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// Prefix of its walls' names.
    pub name: &'static str,
    /// Where it stands.
    pub world_from_ring: Pose2,
    /// Half the extent of the corridors' centre line, metres.
    pub half: Vec2,
    /// Width of the corridors, metres.
    pub corridor_m: f64,
    /// Sides (0 south, 1 east, 2 north, 3 west) that have a gate in their middle.
    pub gates: Vec<usize>,
    /// Distance of an outside wall from the corridors, with rooms between; `None`: the building has no outside.
    pub facade_m: Option<f64>,
}

impl Ring {
    /// A point on the centre line, world frame: `share` −1..=1 along a side, in driving order.
    pub fn on_side(&self, side: usize, share: f64) -> Vec2 {
        let [from, to] = corners(self.half, side);
        self.world_from_ring.transform_point((from + to) / 2.0 + (to - from) * (share / 2.0))
    }

    /// The corner at the end of a side, world frame.
    pub fn corner_after(&self, side: usize) -> Vec2 {
        self.on_side(side, 1.0)
    }

    /// A point in front of the gate in the middle of a side, `distance_m` outside the outermost wall, world frame.
    pub fn before_gate(&self, side: usize, distance_m: f64) -> Vec2 {
        let middle = self.on_side(side, 0.0);
        let [from, to] = corners(self.half, side);
        let along = (to - from).normalize();
        let out = self.corridor_m / 2.0 + self.facade_m.unwrap_or(0.0) + distance_m;
        middle + self.world_from_ring.rotate(Vec2::new(along.y, -along.x) * out)
    }

    /// Names of the four rows of wall that the corridors' outer sides are.
    pub fn outer_rows(&self) -> impl Iterator<Item = String> {
        SIDES.map(|side| format!("{}/{side}-outer", self.name)).into_iter()
    }

    /// Draws the building.
    pub fn build(&self, plan: &mut FloorPlan) {
        let half_corridor = Vec2::repeat(self.corridor_m / 2.0);
        let (outer, inner) = (self.half + half_corridor, self.half - half_corridor);
        for (side, side_name) in SIDES.iter().enumerate() {
            let has_gate = self.gates.contains(&side);
            let mut row = |kind: &str, [from, to]: [Vec2; 2], features: Vec<Feature>| {
                let name = format!("{}/{side_name}-{kind}", self.name);
                plan.row(self.world_from_ring, &name, from, to, &features);
            };
            let ends = corners(outer, side);
            row("outer", ends, features(&OUTER, side, ends, has_gate));
            let [to, from] = corners(inner, side);
            row("inner", [from, to], features(&INNER, side, [from, to], false));
            if let Some(facade_m) = self.facade_m {
                let [to, from] = corners(outer + Vec2::repeat(facade_m), side);
                row("facade", [from, to], features(&FACADE, side, [from, to], has_gate));
            }
            if let (true, Some(facade_m)) = (has_gate, self.facade_m) {
                self.passage(plan, side_name, ends, facade_m);
            }
        }
    }

    /// The two walls of the way from the corridor through the rooms to the outside.
    fn passage(&self, plan: &mut FloorPlan, side_name: &str, ends: [Vec2; 2], depth_m: f64) {
        let along = (ends[1] - ends[0]).normalize();
        let into = Vec2::new(along.y, -along.x) * depth_m;
        for (k, half_m) in [-GATE_M / 2.0, GATE_M / 2.0].into_iter().enumerate() {
            let jamb = (ends[0] + ends[1]) / 2.0 + along * half_m;
            let name = format!("{}/{side_name}-gate/{k}", self.name);
            plan.wall(self.world_from_ring, name, jamb, jamb + into);
        }
    }
}

/// Start and end of a side of a rectangle, counter-clockwise.
fn corners(half: Vec2, side: usize) -> [Vec2; 2] {
    let corner = |k: usize| match k % 4 {
        0 => Vec2::new(-half.x, -half.y),
        1 => Vec2::new(half.x, -half.y),
        2 => Vec2::new(half.x, half.y),
        _ => Vec2::new(-half.x, half.y),
    };
    [corner(side), corner(side + 1)]
}

/// Pattern of a row: distance from the feature before, and what is there.
type Pattern = [(f64, Shape); 5];

const OUTER: Pattern = [
    (3.1, Shape::Box { width_m: 0.9, depth_m: 0.2 }),
    (4.1, Shape::Room { width_m: 2.4, depth_m: 3.0 }),
    (2.7, Shape::Box { width_m: 0.4, depth_m: -0.25 }),
    (3.6, Shape::Box { width_m: 1.0, depth_m: 0.25 }),
    (4.8, Shape::Room { width_m: 2.0, depth_m: 2.4 }),
];
const INNER: Pattern = [
    (4.4, Shape::Box { width_m: 0.9, depth_m: 0.2 }),
    (3.3, Shape::Box { width_m: 1.2, depth_m: 0.6 }),
    (3.9, Shape::Box { width_m: 0.4, depth_m: -0.2 }),
    (2.8, Shape::Box { width_m: 0.9, depth_m: 0.2 }),
    (5.2, Shape::Box { width_m: 1.6, depth_m: 0.5 }),
];
const FACADE: Pattern = [
    (3.5, Shape::Box { width_m: 0.5, depth_m: -0.3 }),
    (4.2, Shape::Box { width_m: 1.5, depth_m: 0.15 }),
    (2.9, Shape::Box { width_m: 1.5, depth_m: 0.15 }),
    (4.6, Shape::Box { width_m: 0.5, depth_m: -0.3 }),
    (3.8, Shape::Box { width_m: 2.0, depth_m: 0.4 }),
];

/// The pattern repeated along a row, each side entering it elsewhere so that no two sides look the same.
fn features(pattern: &Pattern, side: usize, [from, to]: [Vec2; 2], has_gate: bool) -> Vec<Feature> {
    let length_m = (to - from).norm();
    let middle_m = length_m / 2.0;
    let mut at_m = 0.0;
    let mut features: Vec<Feature> = pattern
        .iter()
        .cycle()
        .skip(2 * side)
        .map(|&(distance_m, shape)| {
            at_m += distance_m;
            Feature { at_m, shape }
        })
        .take_while(|f| f.at_m < length_m - 1.8)
        .filter(|f| !has_gate || (f.at_m - middle_m).abs() > GATE_CLEARANCE_M)
        .collect();
    if has_gate {
        let gate = Feature { at_m: middle_m, shape: Shape::Gap { width_m: GATE_M } };
        features.insert(features.partition_point(|f| f.at_m < middle_m), gate);
    }
    features
}
