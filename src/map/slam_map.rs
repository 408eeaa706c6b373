//! The map: poses, relative factors, what was seen from each pose, and the human factors so far.

use super::{AutomaticFactor, HumanFactor, Observations, Trajectory};
use crate::error::{Error, Result};
use crate::geometry::{Information, Pose2};

/// A 2D lidar map as a factor graph G = {X, R ∪ H} with the observations S.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlamMap {
    /// X: `world_from_robot`, in the order in which the robot drove.
    pub poses: Vec<Pose2>,
    /// Seconds, one per pose; `None` where the source has no stamps.
    pub stamps_s: Option<Vec<f64>>,
    /// The source's own vertex ids, one per pose (g2o); `None`: the indices.
    pub vertex_ids: Option<Vec<i64>>,
    /// Poses that optimisation must not move, ascending; empty: the first pose is held.
    pub held: Vec<usize>,
    /// R: the relative factors that the map came with, for ever.
    pub relative_factors: Vec<RelativeFactor>,
    /// S: every laser return.
    pub observations: Observations,
    /// Every scan of the source log, also those that are not poses of the graph; empty where there was no log.
    pub scans: Vec<ScanRecord>,
    /// H: the human factors, in the order in which they were accepted.
    pub human_factors: Vec<HumanFactor>,
    /// Loop closures that were found without a person, by the last re-association; ascending by (j, i).
    pub automatic_factors: Vec<AutomaticFactor>,
    /// Where the laser sits on the robot: origin of the rays.
    pub robot_from_laser: Pose2,
}

/// The measured motion between two poses: odometry, a scan match or a loop closure.
/// Residual e = [Rzᵀ(Riᵀ(tj − ti) − tz); wrap(θj − θi − θz)] (docs/MATH.md R1, the g2o convention).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeFactor {
    /// Index of the first pose.
    pub i: usize,
    /// Index of the second pose.
    pub j: usize,
    /// z: pose j as measured from pose i.
    pub i_from_j: Pose2,
    /// Ω in the frame of e: 3×3, order (x, y, θ).
    pub information: Information,
}

impl RelativeFactor {
    /// e at the given poses: (x, y) in metres in the frame of pose j as measured, θ in radians.
    pub fn residual(&self, world_from_i: Pose2, world_from_j: Pose2) -> [f64; 3] {
        self.i_from_j.between(world_from_i.between(world_from_j)).to_array()
    }

    /// eᵀΩe at the given poses.
    pub fn chi2(&self, world_from_i: Pose2, world_from_j: Pose2) -> f64 {
        let [x, y, theta] = self.residual(world_from_i, world_from_j);
        self.information.chi2(crate::geometry::Vec2::new(x, y), theta)
    }
}

/// One scan of the source log and where it hangs in the graph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanRecord {
    /// Seconds, the log's clock.
    pub stamp_s: f64,
    /// Index of the pose it moves with.
    pub parent: usize,
    /// The robot at the scan, seen from that pose.
    pub parent_from_robot: Pose2,
}

impl SlamMap {
    /// One pose per scan of the log; where there was no log, one per pose of the graph.
    pub fn trajectory(&self) -> Trajectory {
        if self.scans.is_empty() {
            let stamps_s = match &self.stamps_s {
                Some(stamps) => stamps.clone(),
                None => (0..self.poses.len()).map(|i| i as f64).collect(),
            };
            return Trajectory { stamps_s, poses: self.poses.clone() };
        }
        Trajectory {
            stamps_s: self.scans.iter().map(|s| s.stamp_s).collect(),
            poses: self.scans.iter().map(|s| self.poses[s.parent].compose(s.parent_from_robot)).collect(),
        }
    }

    /// The relative factors that the map came with, then those that were found without a person.
    pub fn every_relative_factor(&self) -> impl Iterator<Item = &RelativeFactor> {
        self.relative_factors.iter().chain(self.automatic_factors.iter().map(|a| &a.factor))
    }

    /// True for a map of walks: every point is where its walker trod, so there is one for every scan, in the scan's place. A laser
    /// sees no wall where the robot itself is.
    pub fn points_are_footprints(&self) -> bool {
        let is_footprint = |(k, scan): (usize, &ScanRecord)| {
            let place = scan.parent_from_robot.translation();
            self.observations.range(scan.parent).contains(&k)
                && (self.observations.point(k) - place).norm() < 1e-9
        };
        !self.scans.is_empty()
            && self.scans.len() == self.observations.len()
            && self.scans.iter().enumerate().all(is_footprint)
    }

    /// Length of the chain's path from the first pose to each, metres.
    pub fn path_lengths_m(&self) -> Vec<f64> {
        let mut length_m = 0.0;
        let mut lengths = Vec::with_capacity(self.poses.len());
        for (k, pose) in self.poses.iter().enumerate() {
            let before = self.poses[k.saturating_sub(1)];
            length_m += (pose.translation() - before.translation()).norm();
            lengths.push(length_m);
        }
        lengths
    }

    /// The poses that optimisation must not move: `held`, or the first.
    pub fn held_or_first(&self) -> Vec<usize> {
        if self.held.is_empty() && !self.poses.is_empty() { vec![0] } else { self.held.clone() }
    }

    /// Checks every index, length and number. Readers call it before they hand a map on.
    ///
    /// # Errors
    /// [`Error::Input`] at `place: field`.
    pub fn validate(&self, place: &str) -> Result<()> {
        let n = self.poses.len();
        let fail =
            |field: &str, message: String| Err(Error::input(format_args!("{place}: {field}"), message));
        if n == 0 {
            return fail("poses", "found none, expected at least one".into());
        }
        if let Some(i) = self.poses.iter().position(|p| !p.is_finite()) {
            return fail(
                "poses",
                format!("pose {i}: found a value that is not finite, expected finite numbers"),
            );
        }
        for (name, len) in [
            ("stamps", self.stamps_s.as_ref().map(Vec::len)),
            ("vertex ids", self.vertex_ids.as_ref().map(Vec::len)),
        ] {
            if let Some(len) = len.filter(|&len| len != n) {
                return fail(name, format!("found {len}, expected one for each of the {n} poses"));
            }
        }
        if self.stamps_s.iter().flatten().any(|s| !s.is_finite()) {
            return fail("stamps", "found a value that is not finite, expected finite numbers".into());
        }
        if let Some(&h) = self.held.iter().find(|&&h| h >= n) {
            return fail("held poses", format!("found pose {h}, expected one below {n}"));
        }
        let automatic = self.automatic_factors.iter().map(|a| &a.factor).enumerate();
        let factors = self.relative_factors.iter().enumerate().map(|f| ("relative factors", f));
        for (name, (k, f)) in factors.chain(automatic.map(|f| ("automatic factors", f))) {
            if f.i >= n || f.j >= n || f.i == f.j {
                let message = format!(
                    "factor {k}: found poses {} and {}, expected two different ones below {n}",
                    f.i, f.j
                );
                return fail(name, message);
            }
            if !f.i_from_j.is_finite() {
                return fail(name, format!("factor {k}: found a measurement that is not finite"));
            }
        }
        for a in &self.automatic_factors {
            let numbers = [a.inliers, a.ambiguity, a.chi2, a.weak_rad.unwrap_or(0.0)];
            if !numbers.iter().all(|v| v.is_finite()) {
                return fail("automatic factors", format!("{}: found a value that is not finite", a.name()));
            }
        }
        self.validate_observations().or_else(|m| fail("points", m))?;
        if let Some(k) = self
            .scans
            .iter()
            .position(|s| s.parent >= n || !s.stamp_s.is_finite() || !s.parent_from_robot.is_finite())
        {
            return fail(
                "scans",
                format!(
                    "scan {k}: found a parent, stamp or offset out of range, expected a pose below {n} and finite numbers"
                ),
            );
        }
        for factor in &self.human_factors {
            self.validate_human_factor(factor)
                .or_else(|m| fail("human factors", format!("{}: {m}", factor.id)))?;
        }
        Ok(())
    }

    fn validate_observations(&self) -> std::result::Result<(), String> {
        let o = &self.observations;
        let (n, points) = (self.poses.len(), o.points.len());
        if o.starts.len() != n + 1 || o.starts[0] != 0 || o.starts[n] as usize != points {
            return Err(format!(
                "found groups for {} poses, expected {n} that cover all {points} points",
                o.starts.len().max(1) - 1
            ));
        }
        if o.normals.len() != points || o.ranges_m.len() != points {
            return Err(format!(
                "found {} normals and {} ranges for {points} points",
                o.normals.len(),
                o.ranges_m.len()
            ));
        }
        if o.starts.windows(2).any(|w| w[0] > w[1]) {
            return Err("found groups that run backwards, expected ascending ones".into());
        }
        let finite = |i: usize| {
            o.point(i).iter().chain(o.normal(i).iter()).all(|v| v.is_finite()) && o.ranges_m[i].is_finite()
        };
        match (0..points).find(|&i| !finite(i)) {
            Some(i) => Err(format!("point {i}: found a value that is not finite, expected finite numbers")),
            None => Ok(()),
        }
    }

    fn validate_human_factor(&self, factor: &HumanFactor) -> std::result::Result<(), String> {
        if !(factor.weight.is_finite() && factor.weight > 0.0) {
            return Err(format!("found weight {}, expected a number > 0", factor.weight));
        }
        for feature in [&factor.a, &factor.b] {
            let s = &feature.segment;
            if ![s.centre.x, s.centre.y, s.direction_rad, s.half_length_m].iter().all(|v| v.is_finite())
                || s.half_length_m <= 0.0
            {
                return Err("found a segment that is not finite or has no length".into());
            }
            if feature.points.is_empty() || !feature.points.windows(2).all(|w| w[0] < w[1]) {
                return Err("found no points or points out of order, expected ascending indices".into());
            }
            if feature.points.iter().any(|&p| p as usize >= self.observations.len()) {
                return Err(format!(
                    "found a point index beyond the map's {} points",
                    self.observations.len()
                ));
            }
            let mut poses: Vec<usize> =
                feature.points.iter().map(|&p| self.observations.pose_of(p as usize)).collect();
            poses.dedup();
            let sighted = feature.sightings.iter().map(|s| s.pose);
            if !sighted.eq(poses.iter().copied()) {
                return Err("found sightings that are not those of its points' poses".into());
            }
            if feature.sightings.iter().any(|s| !s.along_m.is_finite() || !s.bearing_rad.is_finite()) {
                return Err("found a sighting that is not finite".into());
            }
        }
        Ok(())
    }
}
