//! Two visits of one place as matched, and how far the map is from that.

use crate::geometry::{Pose2, Vec2};
use crate::map::{AutomaticFactor, Mode};
use crate::sights::{Pieces, Sight, line_angle};

/// What a radian counts for, metres.
const METRES_PER_RADIAN: f64 = 0.5;
/// A misfit counts for so much at most, metres: a wrong match must not outvote many right ones.
const MOST_M: f64 = 1.0;
/// A match that is blind along a corridor says something if it is no farther than this from where the map has it, metres.
const FARTHEST_BLIND_M: f64 = 0.5;
/// A wall whose normal is nearer than this to the direction in which a match is blind is not to be drawn on, radians.
const BLIND_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Where pose j was found, seen from pose i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pub i: usize,
    pub j: usize,
    pub i_from_j: Pose2,
    /// Share of the later visit's points that fit.
    pub inliers: f64,
    /// Direction that the match says nothing about, frame of pose i.
    pub weak_rad: Option<f64>,
}

impl Place {
    pub fn of(matched: &AutomaticFactor) -> Place {
        let AutomaticFactor { factor, inliers, weak_rad, .. } = *matched;
        Place { i: factor.i, j: factor.j, i_from_j: factor.i_from_j, inliers, weak_rad }
    }

    /// False for a match that is blind along a corridor and far from where the map has it: any corridor looks like any other.
    pub fn is_telling(&self, poses: &[Pose2]) -> bool {
        self.weak_rad.is_none() || self.misfit_m(poses) < FARTHEST_BLIND_M
    }

    /// How far the poses are from the match, metres (a radian counts as half of one), 0..=1.
    pub fn misfit_m(&self, poses: &[Pose2]) -> f64 {
        let error = self.i_from_j.between(poses[self.i].between(poses[self.j]));
        let mut off = self.i_from_j.rotate(error.translation());
        if let Some(weak_rad) = self.weak_rad {
            let weak = Vec2::new(weak_rad.cos(), weak_rad.sin());
            off -= weak * weak.dot(&off);
        }
        (off.norm() + METRES_PER_RADIAN * error.theta_rad.abs()).min(MOST_M)
    }

    /// What can be drawn there, as far as the match knows it.
    pub fn sights(&self, pieces: &mut Pieces) -> Vec<Sight> {
        let mut sights = pieces.sights((self.i, self.j), self.i_from_j);
        if let Some(weak_rad) = self.weak_rad {
            let along = |s: &Sight| {
                let d = s.a.ends[1] - s.a.ends[0];
                line_angle(d.y.atan2(d.x) - weak_rad).abs()
            };
            sights.retain(|s| along(s) < BLIND_RAD);
            for sight in sights.iter_mut().filter(|s| s.mode == Mode::Colocation) {
                sight.mode = Mode::Collinear;
            }
        }
        sights
    }
}

/// Mean misfit of many places, metres.
pub fn mean_misfit_m(places: &[Place], poses: &[Pose2]) -> f64 {
    places.iter().map(|p| p.misfit_m(poses)).sum::<f64>() / places.len().max(1) as f64
}
