//! From a map to the joint problem: R1 for every relative factor, R2–R4 (in `paper` R5, R6) for every human factor.

use super::gauge;
use super::options::{Formulation, Normalization, ObservationForm, Options};
use super::outliers::is_doubted;
use super::problem::{
    FitSighting, FitTerm, JointProblem, PointTerm, RelationTerm, RelativeTerm, SightingTerm, TieTerm,
};
use crate::geometry::{Pose2, Scatter};
use crate::map::{Feature, HumanFactor, Observations, RelativeFactor, SlamMap};
use crate::solver::Loss;

/// The joint problem at `poses` and at the segments of `factors`. Held: the map's held poses (or the first), and the
/// first pose of every part of the graph that has none.
pub fn build(map: &SlamMap, poses: &[Pose2], factors: &[HumanFactor], options: &Options) -> JointProblem {
    let mut problem = JointProblem {
        poses: poses.iter().map(|p| p.to_array()).collect(),
        relatives: relative_terms(map, options),
        ..Default::default()
    };
    for factor in factors {
        match options.formulation {
            Formulation::Smooth => {
                let [a, b] = [&factor.a, &factor.b]
                    .map(|f| add_feature(&mut problem, f, factor.weight, &map.observations, options));
                problem.relations.push(relation_term(factor, a, b, options));
            }
            Formulation::Paper => {
                let [a, b] = [&factor.a, &factor.b]
                    .map(|f| add_paper_feature(&mut problem, f, factor.weight, &map.observations, options));
                problem.paper_relations.push(relation_term(factor, a, b, options));
            }
        }
    }
    problem.held = gauge::complete(&problem, &map.held_or_first());
    problem
}

/// R1 of what the map came with, then of what was found without a person: those under a bounded loss of their own.
fn relative_terms(map: &SlamMap, options: &Options) -> Vec<RelativeTerm> {
    let automatic = Loss::GemanMcClure(options.automatic_loss_scale);
    let found = map.automatic_factors.iter().map(|a| relative_term(&a.factor, automatic));
    let known =
        |f: &RelativeFactor| relative_term(f, if is_doubted(f, options) { options.loss } else { Loss::None });
    map.relative_factors.iter().map(known).chain(found).collect()
}

fn relation_term(factor: &HumanFactor, a: usize, b: usize, options: &Options) -> RelationTerm {
    let root = factor.weight.sqrt();
    RelationTerm {
        mode: factor.mode,
        a,
        b,
        offset_scale: root / options.offset_sigma_m,
        angle_scale: root / options.angle_sigma_rad,
        loss: options.loss,
    }
}

pub(super) fn relative_term(factor: &RelativeFactor, loss: Loss) -> RelativeTerm {
    let u = factor.information.sqrt();
    RelativeTerm {
        i: factor.i,
        j: factor.j,
        measured: factor.i_from_j.to_array(),
        sqrt_information: std::array::from_fn(|k| u[(k / 3, k % 3)]),
        loss,
    }
}

/// Adds a feature's segment, R2 and R3; returns the segment's index.
fn add_feature(
    problem: &mut JointProblem,
    feature: &Feature,
    weight: f64,
    observations: &Observations,
    options: &Options,
) -> usize {
    let segment = problem.segments.len();
    let s = &feature.segment;
    problem.segments.push([s.centre.x, s.centre.y, s.direction_rad]);
    let total = feature.points.len() as f64;
    let tied: usize =
        feature.points_by_sighting(observations).filter(|(s, _)| s.tied).map(|(_, p)| p.len()).sum();
    let tied = tied as f64;
    let per_point = match options.normalization {
        Normalization::Sum => weight,
        Normalization::Mean => weight / total,
    };
    for (sighting, points) in feature.points_by_sighting(observations) {
        let scatter = Scatter::of(points.iter().map(|&p| observations.point(p as usize)));
        let (pose, mean, count) = (sighting.pose, scatter.mean.into(), scatter.count as f64);
        let scale = per_point.sqrt() / options.observation_sigma_m;
        match options.observation_form {
            ObservationForm::Moments => problem.sightings.push(SightingTerm {
                pose,
                segment,
                mean,
                scatter_root: scatter.root,
                count,
                scale,
            }),
            ObservationForm::Points => {
                let term =
                    |&p: &u32| PointTerm { pose, segment, point: observations.points[p as usize], scale };
                problem.points.extend(points.iter().map(term));
            }
        }
        if !sighting.tied {
            continue;
        }
        problem.ties.push(TieTerm {
            pose,
            segment,
            mean,
            along: sighting.along_m,
            scale: (weight * count / tied).sqrt() / options.tie_sigma_m,
        });
    }
    segment
}

/// Adds a feature's end points and R5; returns the segment's index among the ends.
fn add_paper_feature(
    problem: &mut JointProblem,
    feature: &Feature,
    weight: f64,
    observations: &Observations,
    options: &Options,
) -> usize {
    let segment = problem.ends.len();
    problem.ends.push(feature.segment.ends().map(|e| [e.x, e.y]));
    let sightings = feature
        .points_by_sighting(observations)
        .map(|(sighting, points)| FitSighting {
            pose: sighting.pose,
            points: points.iter().map(|&p| observations.points[p as usize]).collect(),
        })
        .collect();
    problem.fits.push(FitTerm { segment, sightings, scale: weight.sqrt() / options.observation_sigma_m });
    segment
}

/// Σ‖r‖² of one human factor's terms R2–R4, its segments best for the given poses where the formulation lets
/// them go: no ½, no loss.
pub fn factor_chi2(map: &SlamMap, poses: &[Pose2], factor: &HumanFactor, options: &Options) -> f64 {
    let mut alone = build(map, poses, std::slice::from_ref(factor), options);
    alone.relatives.clear();
    alone.chi2()
}
