//! What the laser saw: every return of every pose, in that pose's robot frame.

use std::ops::Range;

use crate::geometry::Vec2;

/// All points of a map, grouped by pose in ascending order. 28 bytes a point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observations {
    /// Robot frame, metres.
    pub points: Vec<[f64; 2]>,
    /// Unit normals towards the sensor, robot frame; (0, 0) where unknown. As long as `points`.
    pub normals: Vec<[f32; 2]>,
    /// Distance from the laser, metres. As long as `points`.
    pub ranges_m: Vec<f32>,
    /// Points of pose i are `starts[i]..starts[i + 1]`; one longer than the number of poses.
    pub starts: Vec<u32>,
}

impl Observations {
    /// No points for `poses` poses.
    pub fn empty(poses: usize) -> Self {
        Observations { starts: vec![0; poses + 1], ..Default::default() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True if there is no point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Indices of the points of a pose.
    pub fn range(&self, pose: usize) -> Range<usize> {
        self.starts[pose] as usize..self.starts[pose + 1] as usize
    }

    /// The pose that saw a point.
    pub fn pose_of(&self, point: usize) -> usize {
        self.starts.partition_point(|&s| s as usize <= point) - 1
    }

    /// A point, robot frame.
    pub fn point(&self, index: usize) -> Vec2 {
        Vec2::new(self.points[index][0], self.points[index][1])
    }

    /// A normal, robot frame; zero where unknown.
    pub fn normal(&self, index: usize) -> Vec2 {
        Vec2::new(f64::from(self.normals[index][0]), f64::from(self.normals[index][1]))
    }

    /// Points and normals of a pose, robot frame, where the normal is known.
    pub fn oriented(&self, pose: usize) -> impl Iterator<Item = (Vec2, Vec2)> + '_ {
        let known = self.range(pose).map(|p| (self.point(p), self.normal(p)));
        known.filter(|(_, normal)| normal.norm_squared() > 0.0)
    }

    /// Appends a point of the pose that is being filled; close the pose with [`Observations::end_pose`].
    pub fn push(&mut self, point: Vec2, normal: Vec2, range_m: f64) {
        self.points.push([point.x, point.y]);
        self.normals.push([normal.x as f32, normal.y as f32]);
        self.ranges_m.push(range_m as f32);
    }

    /// Says that the points pushed since the last call are all the points of the next pose.
    pub fn end_pose(&mut self) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.starts.push(self.points.len() as u32);
    }
}
