//! One pair of places compared: search, refinement, and what must hold for a match to count.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::candidates::Candidate;
use crate::geometry::{Information, Pose2, principal_direction};
use crate::map::{AutomaticFactor, RelativeFactor};
use crate::scan_match::{Cloud, Match, Prior, Schedule, Search, SurfelMap, Window, align};

/// Steps of the search. Coarse is enough: the refinement reaches half a metre.
const POSITION_STEP_M: f64 = 0.2;
const HEADING_STEP_RAD: f64 = 2.0 * PI / 180.0;
/// Radii of the refinement.
const REFINEMENT: Schedule = Schedule { coarse_m: 0.5, fine_m: 0.15, rounds: 15 };
/// How far the refinement may leave its start: σ, metres and radians. Weak: it only keeps what nothing else holds.
const START_SIGMA: (f64, f64) = (3.0, 1.0);
/// If the search moves further than this, the estimate itself is tried too, metres, …
const MOVED_M: f64 = 0.1;
/// … and wins if its inliers come so near.
const TIE: f64 = 0.01;
/// Least share of the points that must fit.
pub(super) const FEWEST_INLIERS: f64 = 0.55;
/// A match whose runner-up scores this share of it says nothing along the direction that it says least about.
const AMBIGUOUS: f64 = 0.92;
/// … and so does one whose curvature there is this share of what points facing all one way would give.
const WEAK_SHARE: f64 = 0.03;
/// σ of a point in the curvature of a match, metres.
const POINT_SIGMA_M: f64 = 0.03;
/// Points of one wall are not independent: what the curvature says is believed so much less (a variance).
const CORRELATION: f64 = 30.0;
/// What a match cannot know of itself (things that moved, the map's own bend): metres, radians.
const MODEL_SIGMA: (f64, f64) = (0.02, 0.006);

/// What came of a candidate.
#[derive(Debug, Clone, Copy)]
pub(super) enum Outcome {
    /// A factor.
    Accepted(AutomaticFactor),
    /// The share of points that fit was too small.
    TooFewInliers(f64),
}

impl Outcome {
    /// The factor, if there is one.
    pub fn accepted(&self) -> Option<AutomaticFactor> {
        match self {
            Outcome::Accepted(factor) => Some(*factor),
            Outcome::TooFewInliers(_) => None,
        }
    }
}

/// Matches what was seen around j (in the frame of j) to the walls around i (in the frame of i), starting from the estimate
/// alone: for two places next to each other on the path.
pub(super) fn compare_near(
    map: &SurfelMap,
    query: &Cloud,
    estimate: Pose2,
    (i, j): (usize, usize),
) -> Outcome {
    judged(refine(map, query, estimate), query, 0.0, (i, j))
}

/// The shares of a query's points that fit the walls where the estimate puts them, and that have any wall near there.
pub(super) fn standing(map: &SurfelMap, query: &Cloud, estimate: Pose2) -> (f64, f64) {
    let as_it_is = align(map, query, estimate, None, Schedule { rounds: 0, ..REFINEMENT });
    (as_it_is.inliers, as_it_is.covered)
}

/// Matches what was seen around j (in the frame of j) to the walls around i (in the frame of i).
pub(super) fn compare(
    map: &SurfelMap,
    search: &Search,
    query: &Cloud,
    estimate: Pose2,
    candidate: &Candidate,
) -> Outcome {
    let window = Window {
        position_m: candidate.position_m,
        heading_rad: candidate.heading_rad,
        position_step_m: POSITION_STEP_M,
        heading_step_rad: HEADING_STEP_RAD,
    };
    let found = search.best(&query.points, estimate, window);
    let mut matched = refine(map, query, found.pose);
    if (found.pose.translation() - estimate.translation()).norm() > MOVED_M {
        let from_estimate = refine(map, query, estimate);
        if from_estimate.inliers >= matched.inliers - TIE {
            matched = from_estimate;
        }
    }
    judged(matched, query, found.ambiguity, (candidate.i, candidate.j))
}

/// What a match counts for.
fn judged(matched: Match, query: &Cloud, ambiguity: f64, (i, j): (usize, usize)) -> Outcome {
    if matched.inliers < FEWEST_INLIERS {
        return Outcome::TooFewInliers(matched.inliers);
    }
    let (hessian, weak_rad) = without_weak(matched.hessian, query.points.len(), ambiguity);
    let Some(information) = information(hessian, matched.pose) else {
        return Outcome::TooFewInliers(0.0);
    };
    Outcome::Accepted(AutomaticFactor {
        factor: RelativeFactor { i, j, i_from_j: matched.pose, information },
        inliers: matched.inliers,
        ambiguity,
        weak_rad,
        chi2: 0.0,
    })
}

fn refine(map: &SurfelMap, query: &Cloud, start: Pose2) -> Match {
    let information = Information::from_sigmas(START_SIGMA.0, START_SIGMA.0, START_SIGMA.1).matrix();
    align(map, query, start, Some(&Prior { pose: start, information }), REFINEMENT)
}

/// The curvature without its weak direction v, if it has one: H − H v vᵀH / vᵀH v, as if v were unknown.
fn without_weak(hessian: Matrix3<f64>, points: usize, ambiguity: f64) -> (Matrix3<f64>, Option<f64>) {
    let [xx, xy, yy] = [hessian[(0, 0)], hessian[(0, 1)], hessian[(1, 1)]];
    let smallest = (xx + yy) / 2.0 - ((xx - yy) / 2.0).hypot(xy);
    let full = points as f64 / (POINT_SIGMA_M * POINT_SIGMA_M);
    if ambiguity <= AMBIGUOUS && smallest >= WEAK_SHARE * full {
        return (hessian, None);
    }
    let strong_rad = principal_direction([xx, xy, yy]);
    let weak_rad = if strong_rad > 0.0 { strong_rad - PI / 2.0 } else { strong_rad + PI / 2.0 };
    let v = Vector3::new(weak_rad.cos(), weak_rad.sin(), 0.0);
    let along = hessian * v;
    let curvature = v.dot(&along);
    let left = if curvature > 1e-9 { hessian - along * along.transpose() / curvature } else { hessian };
    (left, Some(weak_rad))
}

/// Ω in the axes of the residual, those of pose j as matched.
fn information(hessian: Matrix3<f64>, i_from_j: Pose2) -> Option<Information> {
    let said = (hessian + Matrix3::identity() * 1e-3).cholesky()?.inverse();
    let (m, rad) = MODEL_SIGMA;
    let floor = Matrix3::from_diagonal(&Vector3::new(m * m, m * m, rad * rad));
    let information = Information::from_covariance(said * CORRELATION + floor).ok()?;
    Some(information.rotated(-i_from_j.theta_rad))
}
