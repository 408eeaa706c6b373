//! What the person knows: where two scans really lie to each other.

use crate::error::{Error, Result};
use crate::geometry::{Pose2, angle_diff};
use crate::map::{Relation, SlamMap, Trajectory};

/// Along a true trajectory a look is taken after so much way or turning: metres, radians.
const EVERY: (f64, f64) = (1.0, 0.5);
/// Looks from farther apart than this are not compared, metres.
const NEAR_M: f64 = 5.0;
/// Stamps closer than this are the same moment, seconds.
const TOLERANCE_S: f64 = 0.02;

/// What the person knows.
#[derive(Debug, Clone, Copy)]
pub enum Reference<'a> {
    /// Where the robot truly was.
    Truth(&'a Trajectory),
    /// How some scans truly lie to each other.
    Relations(&'a [Relation]),
}

/// Two poses of the map, the earlier first, and the second truly seen from the first.
type Pair = ((usize, usize), Pose2);

impl Reference<'_> {
    /// Standard deviations of what it says, with those of a wall as one scan shows it: metres, radians.
    pub(super) fn sigmas(self) -> (f64, f64) {
        match self {
            Reference::Truth(_) => (0.03, 0.01),
            // Triangles of the published relations close to 3 cm, their tails to some 10.
            Reference::Relations(_) => (0.06, 0.02),
        }
    }

    /// All pairs of poses that can be compared.
    pub(super) fn pairs(self, map: &SlamMap) -> Result<Vec<Pair>> {
        let pairs = match self {
            Reference::Truth(truth) => by_truth(map, truth),
            Reference::Relations(relations) => by_relations(map, relations),
        };
        if pairs.is_empty() {
            let message = "found no two scans of the map in it, expected stamps of the map's own log";
            return Err(Error::input("reference", message));
        }
        Ok(pairs)
    }
}

fn by_truth(map: &SlamMap, truth: &Trajectory) -> Vec<Pair> {
    let index: Vec<f64> = (0..map.poses.len()).map(|i| i as f64).collect();
    let clock = Clock::new(&truth.stamps_s);
    let stamps_s = map.stamps_s.as_ref().unwrap_or(&index);
    let mut looks: Vec<(usize, Pose2)> = Vec::new();
    for (pose, &stamp_s) in stamps_s.iter().enumerate() {
        let Some(at) = clock.nearest(stamp_s) else { continue };
        let place = truth.poses[at];
        let is_new = looks.last().is_none_or(|(_, last)| {
            (place.translation() - last.translation()).norm() >= EVERY.0
                || angle_diff(place.theta_rad, last.theta_rad).abs() >= EVERY.1
        });
        if is_new {
            looks.push((pose, place));
        }
    }
    let mut pairs = Vec::new();
    for (k, (i, from)) in looks.iter().enumerate() {
        for (j, to) in &looks[k + 1..] {
            if (to.translation() - from.translation()).norm() <= NEAR_M {
                pairs.push(((*i, *j), from.between(*to)));
            }
        }
    }
    pairs
}

fn by_relations(map: &SlamMap, relations: &[Relation]) -> Vec<Pair> {
    let trajectory = map.trajectory();
    let clock = Clock::new(&trajectory.stamps_s);
    // The pose that a scan hangs on, and the scan seen from it.
    let hung = |stamp_s: f64| {
        let k = clock.nearest(stamp_s)?;
        Some(map.scans.get(k).map_or((k, Pose2::IDENTITY), |s| (s.parent, s.parent_from_robot)))
    };
    let pair = |relation: &Relation| {
        let ((i, from_first), (j, from_second)) = (hung(relation.stamp_1_s)?, hung(relation.stamp_2_s)?);
        let i_from_j = from_first.compose(relation.first_from_second).compose(from_second.inverse());
        match i.cmp(&j) {
            std::cmp::Ordering::Less => Some(((i, j), i_from_j)),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(((j, i), i_from_j.inverse())),
        }
    };
    relations.iter().filter_map(pair).collect()
}

/// Stamps in order, for looking up the nearest.
struct Clock<'a> {
    stamps_s: &'a [f64],
    order: Vec<usize>,
}

impl<'a> Clock<'a> {
    fn new(stamps_s: &'a [f64]) -> Self {
        let mut order: Vec<usize> = (0..stamps_s.len()).collect();
        order.sort_by(|&i, &j| stamps_s[i].total_cmp(&stamps_s[j]));
        Clock { stamps_s, order }
    }

    /// Index of the stamp nearest to this one, if it is the same moment; of equal ones the first.
    fn nearest(&self, stamp_s: f64) -> Option<usize> {
        let after = self.order.partition_point(|&i| self.stamps_s[i] < stamp_s);
        let gap = |k: &usize| (self.stamps_s[self.order[*k]] - stamp_s).abs();
        let candidates = after.saturating_sub(1)..(after + 1).min(self.order.len());
        let nearest = candidates.rev().min_by(|k, l| gap(k).total_cmp(&gap(l)))?;
        (gap(&nearest) <= TOLERANCE_S).then(|| self.order[nearest])
    }
}
