//! The robot's way through a world: straight lines between waypoints, corners rounded to arcs.

use crate::geometry::{Pose2, Vec2, angle_diff};

/// A piece of constant curvature.
#[derive(Debug, Clone, Copy)]
struct Arc {
    start: Pose2,
    length_m: f64,
    /// Turn per metre, radians; zero on straight pieces.
    curvature_radpm: f64,
}

/// A smooth path with a heading along it.
#[derive(Debug, Clone)]
pub struct Route {
    arcs: Vec<Arc>,
}

impl Route {
    /// A path through `waypoints` (two at least) that turns with `turn_radius_m`, or tighter where the waypoints are too close.
    /// It cuts corners; it starts at the first waypoint and ends at the last. Reversals are not for it.
    pub fn through(waypoints: &[Vec2], turn_radius_m: f64) -> Self {
        let mut arcs = Vec::new();
        let heading = |leg: Vec2| leg.y.atan2(leg.x);
        let mut position = waypoints[0];
        for k in 1..waypoints.len() {
            let leg = waypoints[k] - waypoints[k - 1];
            let heading_rad = heading(leg);
            let corner = waypoints.get(k + 1).map(|next| {
                let turn_rad = angle_diff(heading(next - waypoints[k]), heading_rad);
                let tangent = (turn_rad.abs() / 2.0).tan();
                let room_m = leg.norm().min((next - waypoints[k]).norm()) / 2.0;
                let cut_m = (turn_radius_m * tangent).min(room_m);
                (turn_rad, cut_m, cut_m / tangent)
            });
            let cut_m = corner.map_or(0.0, |(_, cut_m, _)| cut_m);
            let end = waypoints[k] - leg.normalize() * cut_m;
            let start = Pose2::new(position.x, position.y, heading_rad);
            arcs.push(Arc { start, length_m: (end - position).norm(), curvature_radpm: 0.0 });
            position = end;
            if let Some((turn_rad, _, radius_m)) = corner.filter(|c| c.1 > 0.0) {
                let start = Pose2::new(end.x, end.y, heading_rad);
                let curvature_radpm = turn_rad.signum() / radius_m;
                let arc = Arc { start, length_m: turn_rad.abs() * radius_m, curvature_radpm };
                arcs.push(arc);
                position = arc.at(arc.length_m).translation();
            }
        }
        Route { arcs }
    }

    /// Length of the path.
    pub fn length_m(&self) -> f64 {
        self.arcs.iter().map(|a| a.length_m).sum()
    }

    /// `world_from_robot` at `count` (two at least) equally spaced places from the start to the end.
    pub fn poses(&self, count: usize) -> Vec<Pose2> {
        let step_m = self.length_m() / (count - 1) as f64;
        let (mut arc, mut before_m) = (0, 0.0);
        (0..count)
            .map(|k| {
                let at_m = k as f64 * step_m;
                while arc + 1 < self.arcs.len() && at_m > before_m + self.arcs[arc].length_m {
                    before_m += self.arcs[arc].length_m;
                    arc += 1;
                }
                self.arcs[arc].at(at_m - before_m)
            })
            .collect()
    }
}

impl Arc {
    fn at(&self, along_m: f64) -> Pose2 {
        let turn_rad = self.curvature_radpm * along_m;
        let chord = if turn_rad == 0.0 {
            Vec2::new(along_m, 0.0)
        } else {
            Vec2::new(turn_rad.sin(), 1.0 - turn_rad.cos()) / self.curvature_radpm
        };
        self.start.compose(Pose2::new(chord.x, chord.y, turn_rad))
    }
}
