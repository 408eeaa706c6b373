//! Plain pose graphs: relative factors only, human factors left out.

use super::{Options, optimize};
use crate::error::Result;
use crate::map::SlamMap;
use crate::solver::Report;

/// What [`optimize_graph`] did.
#[derive(Debug, Clone, PartialEq)]
pub struct GraphReport {
    /// Σ eᵀΩe before: no ½, no loss.
    pub initial_chi2: f64,
    /// Σ eᵀΩe after.
    pub final_chi2: f64,
    /// The solve.
    pub solve: Report,
}

/// Optimises the poses of a map over its relative and automatic factors alone. Held poses stay where they are.
///
/// # Errors
/// [`crate::error::Error::Input`] for a malformed map or options out of range. Not to converge is no error.
pub fn optimize_graph(map: &mut SlamMap, options: &Options) -> Result<GraphReport> {
    options.validate()?;
    map.validate("graph")?;
    let initial_chi2 = chi2(map);
    let mut poses = map.poses.clone();
    let solve = optimize(map, &mut poses, &mut [], options)?;
    map.poses = poses;
    Ok(GraphReport { initial_chi2, final_chi2: chi2(map), solve })
}

/// Σ eᵀΩe over all relative factors: no ½, no loss.
pub(super) fn chi2(map: &SlamMap) -> f64 {
    map.every_relative_factor().map(|f| f.chi2(map.poses[f.i], map.poses[f.j])).sum()
}
