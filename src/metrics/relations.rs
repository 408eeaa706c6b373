//! Error against hand-checked relations: Kümmerle et al., "On measuring the accuracy of SLAM algorithms",
//! Autonomous Robots 2009, eq. 3 with the translation and the rotation kept apart.
//!
//! For a relation δ* between the poses x₁, x₂ at its two stamps the error is δ*⁻¹ · (x₁⁻¹ · x₂): its translation's
//! length and its rotation's size. The authors' data give one relation a line; nothing is aligned.

use serde::Serialize;

use crate::map::{Relation, Trajectory};

/// Relations are also summed up by the time between their stamps, split here, seconds.
pub const SPAN_LIMITS_S: [f64; 3] = [10.0, 30.0, 120.0];

/// Errors over all relations that have a pose at both stamps. Without any: zero counts and no numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RelationErrors {
    /// Relations that were measured.
    pub count: usize,
    /// Relations left out because no pose of the trajectory has one of their stamps.
    pub unmatched: usize,
    /// Mean translation error, metres.
    pub translation_mean_m: Option<f64>,
    /// Its standard deviation over the relations (of the population: divided by n), metres.
    pub translation_std_m: Option<f64>,
    /// Mean rotation error, degrees.
    pub rotation_mean_deg: Option<f64>,
    /// Its standard deviation over the relations, degrees.
    pub rotation_std_deg: Option<f64>,
    /// Median translation error, metres.
    pub translation_median_m: Option<f64>,
    /// Largest translation error, metres.
    pub translation_worst_m: Option<f64>,
    /// The same by the time between the two stamps.
    pub by_span: Vec<SpanErrors>,
    /// Error of every measured relation, in the order given, for pictures; not in the report.
    #[serde(skip)]
    pub errors: Vec<RelationError>,
}

/// Errors of the relations whose stamps lie `from_s..to_s` apart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpanErrors {
    /// Shortest time of this span, included, seconds.
    pub from_s: f64,
    /// Longest time of this span, excluded, seconds; `None`: no limit.
    pub to_s: Option<f64>,
    /// Relations in this span.
    pub count: usize,
    /// Mean translation error, metres.
    pub translation_mean_m: Option<f64>,
    /// Mean rotation error, degrees.
    pub rotation_mean_deg: Option<f64>,
}

/// Error of one relation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelationError {
    /// Its two poses, indices into the trajectory.
    pub poses: [usize; 2],
    /// Time between its stamps, seconds.
    pub span_s: f64,
    /// Metres.
    pub translation_m: f64,
    /// Degrees.
    pub rotation_deg: f64,
}

/// Measures a trajectory against relations. A stamp belongs to the pose nearest in time within `tolerance_s`; of
/// several poses with that very stamp, to the first.
pub fn relation_errors(trajectory: &Trajectory, relations: &[Relation], tolerance_s: f64) -> RelationErrors {
    let order = trajectory.order_by_stamp();
    let pose_at = |stamp_s: f64| {
        let after = order.partition_point(|&i| trajectory.stamps_s[i] < stamp_s);
        let gap = |k: usize| (trajectory.stamps_s[order[k]] - stamp_s).abs();
        let candidates = after.saturating_sub(1)..(after + 1).min(order.len());
        // On equal gaps the later one: an exact stamp then gives the first pose that has it.
        let nearest = candidates.rev().min_by(|&k, &l| gap(k).total_cmp(&gap(l)))?;
        (gap(nearest) <= tolerance_s).then(|| order[nearest])
    };
    let measure = |relation: &Relation| {
        let poses = [pose_at(relation.stamp_1_s)?, pose_at(relation.stamp_2_s)?];
        let [first, second] = poses.map(|i| trajectory.poses[i]);
        let error = relation.first_from_second.between(first.between(second));
        Some(RelationError {
            poses,
            span_s: (relation.stamp_2_s - relation.stamp_1_s).abs(),
            translation_m: error.translation().norm(),
            rotation_deg: error.theta_rad.abs().to_degrees(),
        })
    };
    let errors: Vec<RelationError> = relations.iter().filter_map(measure).collect();
    let mut translations: Vec<f64> = errors.iter().map(|e| e.translation_m).collect();
    translations.sort_unstable_by(f64::total_cmp);
    let rotations: Vec<f64> = errors.iter().map(|e| e.rotation_deg).collect();
    RelationErrors {
        count: errors.len(),
        unmatched: relations.len() - errors.len(),
        translation_mean_m: mean(&translations),
        translation_std_m: standard_deviation(&translations),
        rotation_mean_deg: mean(&rotations),
        rotation_std_deg: standard_deviation(&rotations),
        translation_median_m: median_of_sorted(&translations),
        translation_worst_m: translations.last().copied(),
        by_span: by_span(&errors),
        errors,
    }
}

fn by_span(errors: &[RelationError]) -> Vec<SpanErrors> {
    let starts = std::iter::once(0.0).chain(SPAN_LIMITS_S);
    let ends = SPAN_LIMITS_S.into_iter().map(Some).chain([None]);
    let span = |(from_s, to_s): (f64, Option<f64>)| {
        let inside = |e: &&RelationError| e.span_s >= from_s && to_s.is_none_or(|to| e.span_s < to);
        let (translations, rotations): (Vec<f64>, Vec<f64>) =
            errors.iter().filter(inside).map(|e| (e.translation_m, e.rotation_deg)).unzip();
        SpanErrors {
            from_s,
            to_s,
            count: translations.len(),
            translation_mean_m: mean(&translations),
            rotation_mean_deg: mean(&rotations),
        }
    };
    starts.zip(ends).map(span).collect()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values)?;
    Some((values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
}

fn median_of_sorted(values: &[f64]) -> Option<f64> {
    let upper = *values.get(values.len() / 2)?;
    let lower = values[(values.len() - 1) / 2];
    Some((lower + upper) / 2.0)
}
