//! Two independent solvers, one objective: after every correction both get the identical joint problem.
//!
//! One interpretation, so that both see the same points; the Rust result is carried on, so that differences do not pile
//! up. Compared are residuals and Jacobians (analytic here, automatic in C++) at the start and at the result, then
//! cost, poses and time.

mod compare;
mod report;

pub use compare::{Differences, at as compare_at};
pub use report::{Check, CrossCheck, Place, Totals};

use std::time::Instant;

use crate::error::Result;
use crate::joint::problem::JointProblem;
use crate::joint::{self, Backend, Formulation};
use crate::map::{Correction, SlamMap};
use crate::pipeline::{self, Corrector};

/// Runs every enabled correction on both back ends.
///
/// # Errors
/// [`crate::error::Error::Input`] if this build has no Ceres, or as [`Corrector::new`] and [`Corrector::prepare`].
pub fn run(map: SlamMap, corrections: &[Correction], options: &pipeline::Options) -> Result<CrossCheck> {
    run_while(map, corrections, options, &mut |_, _| true)
}

/// Like [`run`], as long as `progress(done, of)`, asked before every correction, answers true.
///
/// # Errors
/// As [`run`].
pub fn run_while(
    map: SlamMap,
    corrections: &[Correction],
    options: &pipeline::Options,
    progress: &mut dyn FnMut(usize, usize) -> bool,
) -> Result<CrossCheck> {
    Backend::Ceres.require()?;
    let mut corrector = Corrector::new(map, *options)?;
    let mut checks = Vec::new();
    let of = corrections.iter().filter(|c| c.enabled).count();
    for (done, correction) in corrections.iter().filter(|c| c.enabled).enumerate() {
        if !progress(done, of) {
            break;
        }
        let mut prepared = match corrector.prepare(correction)? {
            Ok(prepared) => prepared,
            Err(report) => {
                checks.push(Check::rejected(&correction.id, report.rejection));
                continue;
            }
        };
        let start = joint::set_up(corrector.map(), &prepared.poses, &mut prepared.factors, &options.joint);
        let (check, solved) = both(&correction.id, start, &options.joint)?;
        if let Some(solve) = &check.rust {
            joint::take_over(&solved, &mut prepared.poses, &mut prepared.factors);
            corrector.conclude(prepared, solve);
        }
        checks.push(check);
    }
    Ok(CrossCheck::new(options.joint.formulation, checks))
}

/// Solves one problem on both back ends: what differed, and the Rust result.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed problem or a build without Ceres.
pub fn both(id: &str, start: JointProblem, options: &joint::Options) -> Result<(Check, JointProblem)> {
    let mut differences = compare::at(&start)?;
    let (mut by_rust, mut by_ceres) = (start.clone(), start);
    let clock = Instant::now();
    let rust = Backend::Rust.solve(&mut by_rust, options)?;
    let rust_ms = milliseconds(clock);
    let clock = Instant::now();
    let ceres = Backend::Ceres.solve(&mut by_ceres, options)?;
    let ceres_ms = milliseconds(clock);
    differences.worsen(compare::at(&by_rust)?);
    let (max_pose_difference_m, max_angle_difference_rad) = compare::poses(&by_rust, &by_ceres);
    let totals = Totals {
        max_residual_difference: differences.residual.0,
        max_jacobian_difference: differences.jacobian.0,
        max_pose_difference_m,
        max_angle_difference_rad,
        relative_cost_difference: compare::costs(rust.final_cost, ceres.final_cost),
        rust_ms,
        ceres_ms,
        rust_iterations: rust.iterations.len(),
        ceres_iterations: ceres.iterations.len(),
    };
    let check = Check {
        id: id.into(),
        totals,
        agree: totals.agree(options.formulation),
        rejected: None,
        worst_residual: differences.residual.1,
        worst_jacobian: differences.jacobian.1,
        rust: Some(rust),
        ceres: Some(ceres),
    };
    Ok((check, by_rust))
}

impl Totals {
    /// The contract: residuals to 1e-9 and Jacobians to 1e-7; in `smooth`, which has a well-defined minimum, also the
    /// cost to 1e-8 and poses to 1e-6 m and 1e-6 rad.
    pub fn agree(&self, formulation: Formulation) -> bool {
        let terms = self.max_residual_difference <= 1e-9 && self.max_jacobian_difference <= 1e-7;
        let results = self.relative_cost_difference <= 1e-8
            && self.max_pose_difference_m <= 1e-6
            && self.max_angle_difference_rad <= 1e-6;
        terms && (results || formulation == Formulation::Paper)
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
