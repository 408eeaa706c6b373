//! All metrics of a map in one report: what `hitl evaluate` writes.

use serde::Serialize;

use super::{
    PoseError, RelationErrors, WallErrors, associate, ate, relation_errors, rpe, wall_errors, worst_edge,
};
use crate::error::{Error, Result};
use crate::map::{Relation, SlamMap, Trajectory, Wall, WallPair};

/// What to measure against.
#[derive(Debug, Clone, Copy)]
pub struct Reference<'a> {
    /// The true trajectory.
    pub truth: Option<&'a Trajectory>,
    /// Hand-checked relations.
    pub relations: Option<&'a [Relation]>,
    /// The true walls and which of them to compare; needs a truth.
    pub walls: Option<(&'a [Wall], &'a [WallPair])>,
    /// Stamps closer than this are the same moment, seconds ([`super::DEFAULT_TOLERANCE_S`]).
    pub tolerance_s: f64,
}

/// The report. A number is absent where nothing was given to measure it by.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Evaluation {
    /// Poses of the trajectory.
    pub poses: usize,
    /// Poses that have a true pose.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matched_poses: Option<usize>,
    /// Absolute trajectory error after SE(2) alignment, root mean square, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ate_rmse_m: Option<f64>,
    /// The largest of them, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ate_max_m: Option<f64>,
    /// Heading error after the same alignment, root mean square, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading_rmse_rad: Option<f64>,
    /// Error of the motion between consecutive matched poses, translation, root mean square, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rpe_trans_rmse_m: Option<f64>,
    /// The same for the rotation, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rpe_rot_rmse_rad: Option<f64>,
    /// The largest translation error between consecutive poses, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rpe_trans_max_m: Option<f64>,
    /// The largest rotation error between consecutive poses, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rpe_rot_max_rad: Option<f64>,
    /// Largest translation residual of a relative factor, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_edge_m: Option<f64>,
    /// Index of that factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_edge_factor: Option<usize>,
    /// Largest √(eᵀΩe) of a relative factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_edge_sigma: Option<f64>,
    /// Errors against hand-checked relations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relations: Option<RelationErrors>,
    /// Angles and distances between named walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walls: Option<WallErrors>,
    /// Error of every matched pose, for plots; not in the report.
    #[serde(skip)]
    pub errors: Vec<PoseError>,
}

/// Measures a map: its trajectory against the reference, its poses against its own relative factors.
///
/// # Errors
/// [`Error::Input`] if there is a truth or a set of relations that shares no stamp with the map.
pub fn evaluate(map: &SlamMap, reference: &Reference) -> Result<Evaluation> {
    let trajectory = map.trajectory();
    let mut report = Evaluation { poses: trajectory.poses.len(), ..Evaluation::default() };
    if let Some(worst) = worst_edge(map) {
        report.worst_edge_m = Some(worst.translation_m);
        report.worst_edge_factor = Some(worst.translation_factor);
        report.worst_edge_sigma = Some(worst.sigma);
    }
    if let Some(truth) = reference.truth {
        let pairs = associate(&trajectory, truth, reference.tolerance_s);
        let Some(absolute) = ate(&trajectory, truth, &pairs) else {
            return Err(no_common_stamp("truth", &trajectory, &truth.stamps_s, reference.tolerance_s));
        };
        report.matched_poses = Some(pairs.len());
        report.ate_rmse_m = Some(absolute.rmse_m);
        report.ate_max_m = Some(absolute.max_m);
        report.heading_rmse_rad = Some(absolute.heading_rmse_rad);
        report.errors = absolute.errors;
        if let Some(relative) = rpe(&trajectory, truth, &pairs) {
            report.rpe_trans_rmse_m = Some(relative.translation_rmse_m);
            report.rpe_rot_rmse_rad = Some(relative.rotation_rmse_rad);
            report.rpe_trans_max_m = Some(relative.translation_max_m);
            report.rpe_rot_max_rad = Some(relative.rotation_max_rad);
        }
    }
    if let (Some(truth), Some((walls, pairs))) = (reference.truth, reference.walls) {
        report.walls = Some(wall_errors(map, truth, walls, pairs, reference.tolerance_s));
    }
    if let Some(relations) = reference.relations {
        let errors = relation_errors(&trajectory, relations, reference.tolerance_s);
        if errors.count == 0 {
            let stamps_s: Vec<f64> = relations.iter().flat_map(|r| [r.stamp_1_s, r.stamp_2_s]).collect();
            return Err(no_common_stamp("relations", &trajectory, &stamps_s, reference.tolerance_s));
        }
        report.relations = Some(errors);
    }
    Ok(report)
}

fn no_common_stamp(what: &str, trajectory: &Trajectory, stamps_s: &[f64], tolerance_s: f64) -> Error {
    let range = |stamps_s: &[f64]| {
        let low = stamps_s.iter().copied().fold(f64::INFINITY, f64::min);
        let high = stamps_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if low <= high { format!("stamps {low}..{high}") } else { "no stamps".to_string() }
    };
    let (found, expected) = (range(stamps_s), range(&trajectory.stamps_s));
    Error::input(
        what,
        format_args!("found {found}, expected some within {tolerance_s} s of the map's ({expected})"),
    )
}
