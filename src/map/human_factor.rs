//! What a correction leaves in the map for ever: h = ⟨P_a, P_b, S_a, S_b, X_a, X_b, m⟩ (Definition 1 of the paper).

use super::Mode;
use crate::geometry::{Segment, wrap_angle};

/// A human correction factor.
#[derive(Debug, Clone, PartialEq)]
pub struct HumanFactor {
    /// The correction's name.
    pub id: String,
    /// How the features relate.
    pub mode: Mode,
    /// Multiplies the factor's cost; > 0.
    pub weight: f64,
    /// The feature seen earlier along the chain.
    pub a: Feature,
    /// The feature seen later.
    pub b: Feature,
}

/// One side of a human factor: a segment P, the observations S that lie on it and the poses X they were made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// P: world frame, as last optimised.
    pub segment: Segment,
    /// S: indices into [`super::Observations`], ascending. Never changes once made.
    pub points: Vec<u32>,
    /// X: one entry per pose that S was seen from, ascending by pose.
    pub sightings: Vec<Sighting>,
}

/// How one pose of X saw the feature when the correction was made. Both references are measured once and
/// never again: measuring them anew at every solve lets old corrections slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Index of the pose.
    pub pose: usize,
    /// Coordinate of the pose's selected points' mean along the segment, from its centre, metres.
    pub along_m: f64,
    /// True if this pose ties the segment along its wall: it is on the feature's own side of the chain. A pose that
    /// saw both features (their walls coincide across, say, but are displaced along) cannot tell where either ends.
    pub tied: bool,
    /// Direction of the segment seen from the robot: `direction − heading`, radians in (−π, π].
    pub bearing_rad: f64,
}

impl HumanFactor {
    /// Distance that the mode wants to be zero, metres; `None` if it wants none.
    pub fn offset_m(&self) -> Option<f64> {
        let d = self.b.segment.centre - self.a.segment.centre;
        match self.mode {
            Mode::Colocation => Some(d.norm()),
            Mode::Collinear => Some(self.a.segment.normal().dot(&d).abs()),
            Mode::Parallel | Mode::Perpendicular => None,
        }
    }

    /// Angle that the mode wants to be zero, radians, ≥ 0.
    pub fn angle_rad(&self) -> f64 {
        let wanted = if self.mode == Mode::Perpendicular { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        let turn = self.b.segment.direction_rad - self.a.segment.direction_rad;
        (wrap_angle(2.0 * (turn - wanted)) / 2.0).abs()
    }
}

impl Feature {
    /// The sightings with each one's own slice of `points`.
    pub fn points_by_sighting<'a>(
        &'a self,
        observations: &'a super::Observations,
    ) -> impl Iterator<Item = (&'a Sighting, &'a [u32])> {
        let mut rest = &self.points[..];
        self.sightings.iter().map(move |sighting| {
            let end = observations.range(sighting.pose).end as u32;
            let (mine, others) = rest.split_at(rest.partition_point(|&p| p < end));
            rest = others;
            (sighting, mine)
        })
    }
}
