//! Stage 5: poses and segments optimised together over the original relative factors and all human factors.
//!
//! [`build`] turns a map into a [`problem::JointProblem`], plain data that any back end can solve; [`rust_backend`]
//! is ours. Section "HitL-SLAM Optimization" of the paper, in the well-posed form of docs/MATH.md.

mod build;
pub mod factors;
mod options;
pub mod problem;
mod refit;
pub mod rust_backend;

pub use build::build;
pub use options::{Normalization, Options};
pub use refit::refit;

use crate::error::Result;
use crate::geometry::{Pose2, wrap_angle};
use crate::map::{HumanFactor, SlamMap};
use crate::solver::Report;

/// Optimises `poses` and the segments of `factors` in place, from where they stand.
/// `map` gives the relative factors, the held poses and the observations; its own poses are not looked at.
///
/// # Errors
/// [`crate::error::Error`] if the problem is malformed: a fault of the caller.
pub fn optimize(
    map: &SlamMap,
    poses: &mut [Pose2],
    factors: &mut [HumanFactor],
    options: &Options,
) -> Result<Report> {
    for factor in factors.iter_mut() {
        for feature in [&mut factor.a, &mut factor.b] {
            feature.segment = refit(feature, &map.observations, poses);
        }
    }
    let mut problem = build(map, poses, factors, options);
    let report = rust_backend::solve(&mut problem, &options.solver)?;
    for (pose, &[x, y, theta]) in poses.iter_mut().zip(&problem.poses) {
        *pose = Pose2::new(x, y, theta);
    }
    let mut blocks = problem.segments.iter();
    for feature in factors.iter_mut().flat_map(|f| [&mut f.a, &mut f.b]) {
        if let Some(&[x, y, direction]) = blocks.next() {
            feature.segment.centre = crate::geometry::Vec2::new(x, y);
            feature.segment.direction_rad = wrap_angle(direction);
        }
    }
    Ok(report)
}
