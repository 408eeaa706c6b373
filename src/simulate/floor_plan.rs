//! Draws floor plans: rows of wall with recesses, pillars, rooms and gates, in a building's own frame.
//!
//! A row runs from one point to another with the free space on its **left**. What interrupts it splits it into
//! pieces named `row/0`, `row/1`, …; the walls of the k-th interruption are `row/k+0`, `row/k+1`, ….

use super::world::Wall;
use crate::geometry::{Pose2, Segment, Vec2};

/// Something in a row of wall, by the distance of its middle from the row's start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feature {
    /// Metres along the row.
    pub at_m: f64,
    /// What is there.
    pub shape: Shape,
}

/// What can interrupt a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A box into the wall (a closed door in its recess, an alcove); with a negative depth a pillar in front of it.
    Box {
        /// Along the wall, metres.
        width_m: f64,
        /// Into the wall, metres.
        depth_m: f64,
    },
    /// An open door, 0.9 m wide, with a room behind it.
    Room {
        /// Along the wall, metres; at least the door's width.
        width_m: f64,
        /// Into the wall, metres.
        depth_m: f64,
    },
    /// A way through.
    Gap {
        /// Along the wall, metres.
        width_m: f64,
    },
}

const DOOR_M: f64 = 0.9;
const WALL_THICKNESS_M: f64 = 0.15;

/// Collects walls.
#[derive(Debug, Clone, Default)]
pub struct FloorPlan {
    /// What has been drawn so far, world frame.
    pub walls: Vec<Wall>,
}

impl FloorPlan {
    /// One wall between two points of a frame.
    pub fn wall(&mut self, world_from_plan: Pose2, name: String, from: Vec2, to: Vec2) {
        let segment = Segment::from_ends(from, to).transformed(world_from_plan);
        self.walls.push(Wall { name, segment });
    }

    /// A row of wall with `features`, ascending and apart from each other.
    pub fn row(&mut self, world_from_plan: Pose2, name: &str, from: Vec2, to: Vec2, features: &[Feature]) {
        let along = (to - from).normalize();
        let into = Vec2::new(along.y, -along.x);
        let place = |along_m: f64, into_m: f64| from + along * along_m + into * into_m;
        let mut start_m = 0.0;
        for (k, feature) in features.iter().enumerate() {
            let (half_m, outline) = feature.shape.outline();
            let piece = format!("{name}/{k}");
            self.wall(world_from_plan, piece, place(start_m, 0.0), place(feature.at_m - half_m, 0.0));
            for (m, ends) in outline.windows(2).enumerate() {
                let [p, q] = [ends[0], ends[1]].map(|[x, y]| place(feature.at_m + x, y));
                self.wall(world_from_plan, format!("{name}/{k}+{m}"), p, q);
            }
            start_m = feature.at_m + half_m;
        }
        self.wall(world_from_plan, format!("{name}/{}", features.len()), place(start_m, 0.0), to);
    }
}

impl Shape {
    /// Half the width of the hole in the row, and the polyline (along from the middle, into the wall) that lines it.
    fn outline(self) -> (f64, Vec<[f64; 2]>) {
        match self {
            Shape::Gap { width_m } => (width_m / 2.0, Vec::new()),
            Shape::Box { width_m, depth_m } => {
                let half = width_m / 2.0;
                (half, vec![[-half, 0.0], [-half, depth_m], [half, depth_m], [half, 0.0]])
            }
            Shape::Room { width_m, depth_m } => {
                let (door, half, front) = (DOOR_M / 2.0, width_m / 2.0, WALL_THICKNESS_M);
                let back = front + depth_m;
                let left = [[-door, 0.0], [-door, front], [-half, front], [-half, back]];
                let right = [[half, back], [half, front], [door, front], [door, 0.0]];
                (door, left.into_iter().chain(right).collect())
            }
        }
    }
}
