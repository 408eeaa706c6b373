//! What the laser saw around a place: the points of the poses along a piece of path, in the frame of one of them.

use std::ops::Range;

use crate::geometry::Pose2;
use crate::map::Observations;
use crate::scan_match::{Cloud, Surfel, SurfelMap};

/// Poses along so much path before and after take part in a query, metres …
const QUERY_HALF_M: f64 = 0.9;
/// … and in the map that it is matched to.
const MAP_HALF_M: f64 = 2.5;
/// Points of a query, about.
const QUERY_POINTS: usize = 400;
/// … before it: of a robot that turns on the spot so many poses at most.
const MOST_POSES: usize = 20;
/// Points further than this from the place are left out, metres.
const RADIUS_M: f64 = 25.0;

/// A map as the search sees it.
pub(super) struct Places<'a> {
    pub poses: &'a [Pose2],
    pub observations: &'a Observations,
    /// Path length from the first pose to each, metres.
    pub path_m: &'a [f64],
}

impl Places<'_> {
    /// The points around pose j, in its frame.
    pub fn query(&self, j: usize) -> Cloud {
        self.thinned(self.around(j, QUERY_HALF_M).flat_map(|k| self.seen(k, j)).collect())
    }

    /// The walls around pose i, in its frame.
    pub fn map(&self, i: usize) -> SurfelMap {
        let seen = self.around(i, MAP_HALF_M).flat_map(|k| self.seen(k, i));
        SurfelMap::new(seen.filter(|s| s.mean.norm_squared() < RADIUS_M * RADIUS_M).collect())
    }

    /// The walls that pose i and those before it saw, in its frame.
    pub fn map_before(&self, i: usize) -> SurfelMap {
        let from = self.path_m.partition_point(|&s| s < self.path_m[i] - MAP_HALF_M).min(i);
        let from = from.max(i.saturating_sub(MOST_POSES));
        let seen = (from..i + 1).flat_map(|k| self.seen(k, i));
        SurfelMap::new(seen.filter(|s| s.mean.norm_squared() < RADIUS_M * RADIUS_M).collect())
    }

    /// The points of pose j alone, in its frame: those beside it may already lie behind what is wrong.
    pub fn query_alone(&self, j: usize) -> Cloud {
        self.thinned(self.seen(j, j).collect())
    }

    fn thinned(&self, all: Vec<Surfel>) -> Cloud {
        let some = all.iter().step_by((all.len() / QUERY_POINTS).max(1));
        let (points, normals) = some.map(|s| (s.mean, s.normal)).unzip();
        Cloud { points, normals }
    }

    fn around(&self, pose: usize, half_m: f64) -> Range<usize> {
        let from = self.path_m.partition_point(|&s| s < self.path_m[pose] - half_m);
        let to = self.path_m.partition_point(|&s| s <= self.path_m[pose] + half_m);
        from.min(pose)..to.max(pose + 1)
    }

    /// The oriented points of pose k in the frame of pose `base`.
    fn seen(&self, k: usize, base: usize) -> impl Iterator<Item = Surfel> {
        let base_from_k = self.poses[base].between(self.poses[k]);
        self.observations.oriented(k).map(move |(point, normal)| Surfel {
            mean: base_from_k.transform_point(point),
            normal: base_from_k.rotate(normal),
        })
    }
}
