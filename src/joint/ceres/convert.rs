//! From the joint problem to the bridge's plain structs.

use super::bridge::ffi;
use super::{LinearSolver, Options, TrustRegion};
use crate::joint::factors::PAPER_EPSILON_M;
use crate::joint::problem::{JointProblem, RelationTerm};
use crate::map::Mode;
use crate::solver::{self, Loss};

/// The problem, copied.
pub(super) fn problem(problem: &JointProblem) -> ffi::Problem {
    let mut fit_sightings = Vec::new();
    let mut fit_points = Vec::new();
    let mut fits = Vec::with_capacity(problem.fits.len());
    for fit in &problem.fits {
        let (segment, scale) = (fit.segment, fit.scale);
        fits.push(ffi::Fit { segment, first: fit_sightings.len(), count: fit.sightings.len(), scale });
        for s in &fit.sightings {
            let (first, count) = (fit_points.len() / 2, s.points.len());
            fit_sightings.push(ffi::FitSighting { pose: s.pose, first, count });
            fit_points.extend(s.points.iter().flatten());
        }
    }
    let relative = |t: &crate::joint::problem::RelativeTerm| ffi::Relative {
        i: t.i,
        j: t.j,
        measured: t.measured,
        sqrt_information: t.sqrt_information,
        loss: loss(t.loss),
    };
    let sighting = |t: &crate::joint::problem::SightingTerm| ffi::Sighting {
        pose: t.pose,
        segment: t.segment,
        mean: t.mean,
        scatter_root: t.scatter_root,
        count: t.count,
        scale: t.scale,
    };
    let point = |t: &crate::joint::problem::PointTerm| ffi::Point {
        pose: t.pose,
        segment: t.segment,
        point: t.point,
        scale: t.scale,
    };
    let tie = |t: &crate::joint::problem::TieTerm| ffi::Tie {
        pose: t.pose,
        segment: t.segment,
        mean: t.mean,
        along: t.along,
        scale: t.scale,
    };
    ffi::Problem {
        poses: problem.poses.concat(),
        segments: problem.segments.concat(),
        ends: problem.ends.concat().concat(),
        held: problem.held.clone(),
        relatives: problem.relatives.iter().map(relative).collect(),
        sightings: problem.sightings.iter().map(sighting).collect(),
        points: problem.points.iter().map(point).collect(),
        ties: problem.ties.iter().map(tie).collect(),
        relations: problem.relations.iter().map(relation).collect(),
        fits,
        fit_sightings,
        fit_points,
        paper_relations: problem.paper_relations.iter().map(relation).collect(),
        epsilon_m: PAPER_EPSILON_M,
    }
}

/// The options, translated.
///
/// Ceres stops when a step has changed the cost by too little, ours when one promises to: its tolerance of the cost is
/// below ours, so that the two can be compared. Its tolerance of the step is a share of ‖x‖, `size`.
pub(super) fn options(stopping: &solver::Options, options: &Options, size: f64) -> ffi::Options {
    ffi::Options {
        trust_region: match options.trust_region {
            TrustRegion::LevenbergMarquardt => 0,
            TrustRegion::Dogleg => 1,
            TrustRegion::SubspaceDogleg => 2,
        },
        linear_solver: match options.linear_solver {
            LinearSolver::SparseNormalCholesky => 0,
            LinearSolver::SparseNormalCholeskyEigen => 1,
            LinearSolver::DenseNormalCholesky => 2,
            LinearSolver::DenseQr => 3,
        },
        max_accepted_steps: stopping.max_iterations,
        function_tolerance: stopping.relative_decrease * 1e-2,
        gradient_tolerance: 1e-12,
        parameter_tolerance: stopping.step / size.max(1.0),
        initial_radius: 1.0 / stopping.initial_damping,
        polish_step: stopping.step,
        polish_rise: stopping.relative_decrease,
    }
}

fn loss(loss: Loss) -> ffi::Loss {
    let kind = match loss {
        Loss::None => 0,
        Loss::Huber(_) => 1,
        Loss::Cauchy(_) => 2,
        Loss::GemanMcClure(_) => 3,
    };
    ffi::Loss { kind, scale: loss.scale().unwrap_or(0.0) }
}

fn relation(t: &RelationTerm) -> ffi::Relation {
    let mode = match t.mode {
        Mode::Colocation => 0,
        Mode::Collinear => 1,
        Mode::Perpendicular => 2,
        Mode::Parallel => 3,
    };
    let (offset_scale, angle_scale) = (t.offset_scale, t.angle_scale);
    ffi::Relation { mode, a: t.a, b: t.b, offset_scale, angle_scale, loss: loss(t.loss) }
}
