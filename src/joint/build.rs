//! From a map to the joint problem: R1 for every relative factor, R2–R4 for every human factor.

use super::Options;
use super::options::Normalization;
use super::problem::{JointProblem, RelationTerm, RelativeTerm, SightingTerm, TieTerm};
use crate::geometry::{Pose2, Scatter};
use crate::map::{Feature, HumanFactor, Observations, RelativeFactor, SlamMap};
use crate::solver::Loss;

/// The joint problem at `poses` and at the segments of `factors`.
pub fn build(map: &SlamMap, poses: &[Pose2], factors: &[HumanFactor], options: &Options) -> JointProblem {
    let mut problem = JointProblem {
        poses: poses.iter().map(|p| p.to_array()).collect(),
        held: map.held_or_first(),
        relatives: map.relative_factors.iter().map(|f| relative_term(f, options.loss)).collect(),
        ..Default::default()
    };
    for factor in factors {
        let a = add_feature(&mut problem, &factor.a, factor.weight, &map.observations, options);
        let b = add_feature(&mut problem, &factor.b, factor.weight, &map.observations, options);
        let root = factor.weight.sqrt();
        problem.relations.push(RelationTerm {
            mode: factor.mode,
            a,
            b,
            offset_scale: root / options.offset_sigma_m,
            angle_scale: root / options.angle_sigma_rad,
            loss: options.loss,
        });
    }
    problem
}

fn relative_term(factor: &RelativeFactor, loss: Loss) -> RelativeTerm {
    let u = factor.information.sqrt();
    let closes_a_loop = factor.i.abs_diff(factor.j) != 1;
    RelativeTerm {
        i: factor.i,
        j: factor.j,
        measured: factor.i_from_j.to_array(),
        sqrt_information: std::array::from_fn(|k| u[(k / 3, k % 3)]),
        loss: if closes_a_loop { loss } else { Loss::None },
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
        problem.sightings.push(SightingTerm {
            pose,
            segment,
            mean,
            scatter_root: scatter.root,
            count,
            scale: per_point.sqrt() / options.observation_sigma_m,
        });
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
