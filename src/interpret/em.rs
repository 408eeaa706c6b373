//! EM for one stroke: which points lie on the wall it was drawn for, and where that wall is.
//!
//! E-step: γ = N(d; 0, σ²) / (N(d; 0, σ²) + floor), d the distance to the line, floor a uniform share of outliers.
//! Points count only between the ends, with a normal across the wall, and on one face of it: the one with more
//! support. M-step: weighted total least squares; the drawn ends are projected on the new line.

use super::Options;
use crate::geometry::{Segment, Vec2, principal_direction};

/// Uniform outlier density over the peak of the Gaussian: γ falls to one half at 2.4 σ.
const OUTLIER_FLOOR: f64 = 0.05;
/// A normal belongs to the wall within acos of this: 30°, what scans of one beam a degree can tell.
const NORMAL_COSINE: f64 = 0.866;
/// EM has settled when no end moves further than this, metres.
const SETTLED_M: f64 = 1e-4;
/// A point is in S within this many σ of the fitted line.
const SELECT_SIGMAS: f64 = 2.0;
/// Points further than this many σ from the drawn stroke are not looked at.
pub(super) const REACH_SIGMAS: f64 = 6.0;

/// A point that may belong to a stroke.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub index: u32,
    pub pose: usize,
    /// World frame.
    pub point: Vec2,
    /// World frame; zero where unknown.
    pub normal: Vec2,
}

/// The wall that a stroke stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// P: the drawn stroke, snapped.
    pub segment: Segment,
    /// EM rounds used.
    pub rounds: usize,
    /// False if EM was stopped before it had settled.
    pub settled: bool,
}

/// Fits the stroke; `None` if fewer than two points support it.
pub(super) fn fit(drawn: &Segment, candidates: &[Candidate], options: &Options) -> Option<Fit> {
    let mut segment = *drawn;
    for round in 1..=options.max_rounds {
        let refitted = maximize(drawn, &segment, candidates, options.drawing_sigma_m)?;
        let (before, after) = (segment.ends(), refitted.ends());
        segment = refitted;
        if before.iter().zip(&after).all(|(p, q)| (p - q).norm() < SETTLED_M) {
            return Some(Fit { segment, rounds: round, settled: true });
        }
    }
    Some(Fit { segment, rounds: options.max_rounds, settled: false })
}

/// S: the candidates that lie on the fitted wall, on its better supported face.
pub(super) fn select<'a>(
    segment: &Segment,
    candidates: &'a [Candidate],
    sigma_m: f64,
) -> impl Iterator<Item = &'a Candidate> {
    let segment = *segment;
    let face = better_face(&segment, candidates, sigma_m);
    candidates.iter().filter(move |c| {
        let (along, across) = segment.along_across(c.point);
        along.abs() <= segment.half_length_m
            && across.abs() <= SELECT_SIGMAS * sigma_m
            && faces(&segment, c.normal, face)
    })
}

/// One E-step and one M-step.
fn maximize(drawn: &Segment, segment: &Segment, candidates: &[Candidate], sigma_m: f64) -> Option<Segment> {
    let face = better_face(segment, candidates, sigma_m);
    let mut weights = Vec::new();
    for c in candidates.iter().filter(|c| faces(segment, c.normal, face)) {
        let gamma = responsibility(segment, c.point, sigma_m);
        if gamma > 0.0 {
            weights.push((gamma, c.point));
        }
    }
    if weights.len() < 2 {
        return None;
    }
    let total: f64 = weights.iter().map(|w| w.0).sum();
    let mean = weights.iter().map(|&(w, p)| p * w).sum::<Vec2>() / total;
    let mut scatter = [0.0; 3];
    for &(w, p) in &weights {
        let d = p - mean;
        scatter[0] += w * d.x * d.x;
        scatter[1] += w * d.x * d.y;
        scatter[2] += w * d.y * d.y;
    }
    let (sin, cos) = principal_direction(scatter).sin_cos();
    let axis = Vec2::new(cos, sin);
    let project = |p: Vec2| mean + axis * axis.dot(&(p - mean));
    let [start, end] = drawn.ends().map(project);
    ((end - start).norm() > sigma_m).then(|| Segment::from_ends(start, end))
}

fn responsibility(segment: &Segment, point: Vec2, sigma_m: f64) -> f64 {
    let (along, across) = segment.along_across(point);
    if along.abs() > segment.half_length_m + sigma_m {
        return 0.0;
    }
    let density = (-0.5 * (across / sigma_m).powi(2)).exp();
    density / (density + OUTLIER_FLOOR)
}

/// +1 or −1: the side of the segment whose normals have more support.
fn better_face(segment: &Segment, candidates: &[Candidate], sigma_m: f64) -> f64 {
    let normal = segment.normal();
    let vote = |c: &Candidate| {
        let cosine = c.normal.dot(&normal);
        if cosine.abs() > NORMAL_COSINE {
            responsibility(segment, c.point, sigma_m) * cosine.signum()
        } else {
            0.0
        }
    };
    if candidates.iter().map(vote).sum::<f64>() >= 0.0 { 1.0 } else { -1.0 }
}

/// True if a normal belongs to this face of the segment, or is unknown.
fn faces(segment: &Segment, normal: Vec2, face: f64) -> bool {
    normal == Vec2::zeros() || face * normal.dot(&segment.normal()) > NORMAL_COSINE
}
