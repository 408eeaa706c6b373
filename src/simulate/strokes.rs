//! The simulated person: draws strokes along wall pieces on a scan that shows them well.
//!
//! A person knows that two bent images show one wall, but neither where it truly is nor how the map is bent: all
//! that counts is where the piece lies relative to the robot that saw it. So a stroke is anchored to a pose, its end
//! points are those of the true piece seen from the true pose, and each coordinate gets Gaussian drawing noise.

use rand_chacha::rand_core::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::world::{Hit, World};
use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2};
use crate::map::{Correction, Mode, Observations, Stroke};

/// Returns that a piece needs in one scan before a person would draw on it.
const MIN_RETURNS: usize = 12;
/// Nobody draws on something farther from the robot than this.
const MAX_DISTANCE_M: f64 = 6.0;
/// The outermost returns on the piece must be this close to its ends: both corners are to be seen.
const END_GAP_M: f64 = 0.25;
/// Of the pieces of a row, a patient person takes every so many.
const STRIDE: usize = 2;
/// … and none shorter than this.
const MIN_PIECE_M: f64 = 2.0;
/// Sightings more poses apart than this belong to different visits.
const VISIT_GAP: usize = 30;

/// One correction as a scenario plans it.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// How the two pieces relate.
    pub mode: Mode,
    /// One piece.
    pub a: Piece,
    /// The other.
    pub b: Piece,
    /// How sure the person is, against the odometry's word ([`Correction::weight`]).
    pub weight: f64,
}

impl Drawing {
    /// A drawing of the usual weight.
    pub fn new(mode: Mode, a: Piece, b: Piece) -> Self {
        Drawing { mode, a, b, weight: 1.0 }
    }
}

/// A piece of a wall on one of the robot's visits to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Name of the wall.
    pub wall: String,
    /// From where to where, metres from the wall's first end; `None`: all of it.
    pub span_m: Option<[f64; 2]>,
    /// Which of the times that it was well seen, from 0.
    pub visit: usize,
    /// Only from these poses, the last excluded; `None`: from any.
    pub poses: Option<[usize; 2]>,
}

impl Piece {
    /// All of a wall.
    pub fn whole(wall: impl Into<String>, visit: usize) -> Self {
        Piece { wall: wall.into(), span_m: None, visit, poses: None }
    }

    /// Some of a wall.
    pub fn part(wall: impl Into<String>, span_m: [f64; 2], visit: usize) -> Self {
        Piece { wall: wall.into(), span_m: Some(span_m), visit, poses: None }
    }

    /// The same piece, on its first visit within a stretch of poses.
    pub fn within(self, poses: [usize; 2]) -> Self {
        Piece { visit: 0, poses: Some(poses), ..self }
    }
}

/// What the person looks at: the world, where the robot truly was, and what it saw.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The walls.
    pub world: &'a World,
    /// `world_from_robot`, one per pose.
    pub truth: &'a [Pose2],
    /// Every return.
    pub observations: &'a Observations,
    /// What each return truly came from, so that the choice of a scan does not depend on the noise in it.
    pub seen: &'a [Hit],
}

impl Scene<'_> {
    /// Draws the corrections, named `c1`, `c2`, ….
    ///
    /// # Errors
    /// [`Error::Internal`] where a planned piece is never well seen.
    pub fn draw(
        &self,
        drawings: &[Drawing],
        drawing_noise_m: f64,
        random: &mut impl Rng,
    ) -> Result<Vec<Correction>> {
        let mut corrections = Vec::with_capacity(drawings.len());
        for (k, drawing) in drawings.iter().enumerate() {
            corrections.push(Correction {
                id: format!("c{}", k + 1),
                mode: drawing.mode,
                a: self.stroke(&drawing.a, drawing_noise_m, random)?,
                b: self.stroke(&drawing.b, drawing_noise_m, random)?,
                weight: drawing.weight,
                enabled: true,
            });
        }
        Ok(corrections)
    }

    /// What says that the pieces of a row of walls (`row/0`, `row/1`, …) lie on one line: every second piece that is long
    /// enough and well seen, on its first visit, with the one before.
    pub fn straighten(&self, row: &str) -> Vec<Drawing> {
        let piece = |k: usize| Piece::whole(format!("{row}/{k}"), 0);
        let clear = |piece: &Piece| {
            let place = self.place(piece).ok()?;
            let long = place.span_m[1] - place.span_m[0] >= MIN_PIECE_M;
            (long && self.anchor(&place, piece).is_some()).then_some(())
        };
        let pieces = (0..).map(piece).take_while(|p| self.world.wall(&p.wall).is_some());
        let chosen: Vec<Piece> = pieces.filter(|p| clear(p).is_some()).step_by(STRIDE).collect();
        let collinear = |pair: &[Piece]| Drawing::new(Mode::Collinear, pair[0].clone(), pair[1].clone());
        chosen.windows(2).map(collinear).collect()
    }

    fn stroke(&self, piece: &Piece, drawing_noise_m: f64, random: &mut impl Rng) -> Result<Stroke> {
        let place = self.place(piece)?;
        let pose = self.anchor(&place, piece).ok_or_else(|| {
            Error::Internal(format!("no visit {} at which {} is well seen", piece.visit, piece.wall))
        })?;
        let robot_from_world = self.truth[pose].inverse();
        let points = place.ends.map(|end| {
            let noise = Vec2::new(StandardNormal.sample(random), StandardNormal.sample(random));
            robot_from_world.transform_point(end) + noise * drawing_noise_m
        });
        Ok(Stroke::Pose { pose, points })
    }

    fn place(&self, piece: &Piece) -> Result<Place> {
        let found = self.world.wall(&piece.wall);
        let (index, wall) =
            found.ok_or_else(|| Error::Internal(format!("no wall is called {}", piece.wall)))?;
        let span_m = piece.span_m.unwrap_or([0.0, 2.0 * wall.segment.half_length_m]);
        let [start, _] = wall.segment.ends();
        let ends = span_m.map(|at_m| start + wall.segment.direction() * at_m);
        Ok(Place { wall: index, span_m, ends })
    }

    /// The pose of a visit that has most returns on the piece.
    fn anchor(&self, place: &Place, piece: &Piece) -> Option<usize> {
        let [first, end] = piece.poses.unwrap_or([0, self.truth.len()]);
        let good: Vec<(usize, usize)> = (first..end.min(self.truth.len()))
            .map(|pose| (pose, self.returns_on(pose, place)))
            .filter(|&(_, returns)| returns >= MIN_RETURNS)
            .collect();
        let mut visits = good.chunk_by(|a, b| b.0 - a.0 <= VISIT_GAP);
        let best = visits.nth(piece.visit)?.iter().max_by_key(|&&(pose, returns)| (returns, pose))?;
        Some(best.0)
    }

    /// Returns of a pose on the piece; 0 if it is too far away or an end of it is out of sight.
    fn returns_on(&self, pose: usize, place: &Place) -> usize {
        let robot = self.truth[pose].translation();
        if place.ends.iter().any(|end| (end - robot).norm() > MAX_DISTANCE_M) {
            return 0;
        }
        let [from_m, to_m] = place.span_m;
        let (mut count, mut low_m, mut high_m) = (0, to_m, from_m);
        for hit in self.seen[self.observations.range(pose)].iter().filter(|hit| hit.wall == place.wall) {
            if (from_m..=to_m).contains(&hit.along_m) {
                (count, low_m, high_m) = (count + 1, hit.along_m.min(low_m), hit.along_m.max(high_m));
            }
        }
        if low_m <= from_m + END_GAP_M && high_m >= to_m - END_GAP_M { count } else { 0 }
    }
}

/// Where a piece is.
struct Place {
    /// Index of its wall.
    wall: usize,
    /// From where to where on the wall, metres from its first end.
    span_m: [f64; 2],
    /// The same two places, world frame.
    ends: [Vec2; 2],
}
