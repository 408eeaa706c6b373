//! Stage 5: poses and segments optimised together over the original relative factors and all human factors.
//!
//! [`set_up`] turns a map into a [`problem::JointProblem`], plain data that any [`Backend`] can solve: ours
//! ([`rust_backend`]) or Ceres ([`ceres`]). Section "HitL-SLAM Optimization" of the paper, in the well-posed form of
//! docs/MATH.md or to the letter ([`Formulation`]).

mod backend;
mod build;
pub mod ceres;
mod compiled;
pub mod factors;
mod gauge;
mod graph;
mod growing;
mod initialise;
mod memory;
mod options;
mod outliers;
pub mod problem;
mod profile;
mod refit;
mod reweighing;
pub mod rust_backend;
mod terms;
mod uncertainty;
mod validate;
mod visits;

pub use backend::{BACK_ENDS, Backend};
pub use build::{build, factor_chi2};
pub use graph::{GraphReport, optimize_graph};
pub use growing::GrowingGraph;
pub use initialise::Initialisation;
pub use memory::Memory;
pub use options::{Formulation, Normalization, ObservationForm, Options};
pub use outliers::{Outlier, doubted, optimize_graph_without_outliers, outliers};
pub use profile::{GraphProfile, profile_graph};
pub use refit::refit;
pub use reweighing::Reweighing;
pub use uncertainty::{map_covariances, marginal_covariances, position_sigma_m};

use crate::error::Result;
use crate::geometry::{Pose2, Segment, Vec2, wrap_angle};
use crate::map::{HumanFactor, SlamMap};
use crate::solver::Report;
use problem::JointProblem;

/// The ends of a segment are kept at least this far from its centre, metres: `paper` may shrink one to nothing.
const SHORTEST_HALF_LENGTH_M: f64 = 1e-3;

/// Optimises `poses` and the segments of `factors` in place, from where they stand.
/// `map` gives the relative factors, the held poses and the observations; its own poses are not looked at.
///
/// # Errors
/// [`crate::error::Error`] if the problem is malformed, a fault of the caller, or the back end is not there.
pub fn optimize(
    map: &SlamMap,
    poses: &mut [Pose2],
    factors: &mut [HumanFactor],
    options: &Options,
) -> Result<Report> {
    optimize_in(&Memory::default(), map, poses, factors, options)
}

/// The same in memory that is there already: for one correction after the other.
///
/// # Errors
/// As [`optimize`].
pub fn optimize_in(
    memory: &Memory,
    map: &SlamMap,
    poses: &mut [Pose2],
    factors: &mut [HumanFactor],
    options: &Options,
) -> Result<Report> {
    let mut problem = set_up(map, poses, factors, options);
    let mut report = options.backend.solve_in(memory, &mut problem, options)?;
    report.warnings.extend(gauge::warning(&map.held_or_first(), &problem.held));
    take_over(&problem, poses, factors);
    Ok(report)
}

/// The joint problem at `poses`, every segment first put where its observations now lie.
pub fn set_up(
    map: &SlamMap,
    poses: &[Pose2],
    factors: &mut [HumanFactor],
    options: &Options,
) -> JointProblem {
    for feature in factors.iter_mut().flat_map(|f| [&mut f.a, &mut f.b]) {
        feature.segment = refit(feature, &map.observations, poses);
    }
    build(map, poses, factors, options)
}

/// Writes a solved problem back to the poses and segments that it was set up from.
pub fn take_over(problem: &JointProblem, poses: &mut [Pose2], factors: &mut [HumanFactor]) {
    for (pose, &solved) in poses.iter_mut().zip(&problem.poses) {
        *pose = Pose2::from_array(solved);
    }
    let mut features = factors.iter_mut().flat_map(|f| [&mut f.a, &mut f.b]);
    for (&[x, y, direction], feature) in problem.segments.iter().zip(&mut features) {
        feature.segment.centre = Vec2::new(x, y);
        feature.segment.direction_rad = wrap_angle(direction);
    }
    for (ends, feature) in problem.ends.iter().zip(&mut features) {
        let [start, end] = ends.map(|[x, y]| Vec2::new(x, y));
        feature.segment = Segment::from_ends(start, end);
        feature.segment.half_length_m = feature.segment.half_length_m.max(SHORTEST_HALF_LENGTH_M);
    }
}
