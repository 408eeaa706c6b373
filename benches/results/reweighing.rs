//! One human factor reweighted or taken out: solved again on the last factorisation, against solved as a whole.

use hitl_slam::joint::problem::{JointProblem, RelationTerm, SightingTerm, TieTerm};
use hitl_slam::joint::{Backend, Options, Reweighing};

use crate::cpu;
use crate::page::{Claim, Result, Section};
use crate::solver_scale::chain;
use crate::stats::Sample;

const SIZES: [usize; 3] = [3_000, 10_000, 100_000];
/// What is done, and the factor's weight then; the factor is then put back.
const CHANGES: [(&str, f64); 3] = [("weight × 1.2", 1.2), ("weight × 5", 5.0), ("taken out", 0.0)];

/// The problem with these weights in its terms.
fn weighted(problem: &JointProblem, weights: &[f64]) -> JointProblem {
    let root = |segment: usize| weights[segment / 2].sqrt();
    let mut all = problem.clone();
    all.sightings = problem.sightings.iter().filter(|t| root(t.segment) > 0.0).copied().collect();
    all.ties = problem.ties.iter().filter(|t| root(t.segment) > 0.0).copied().collect();
    all.relations = problem.relations.iter().filter(|t| root(t.a) > 0.0).copied().collect();
    all.sightings.iter_mut().for_each(|t: &mut SightingTerm| t.scale *= root(t.segment));
    all.ties.iter_mut().for_each(|t: &mut TieTerm| t.scale *= root(t.segment));
    all.relations.iter_mut().for_each(|t: &mut RelationTerm| {
        t.offset_scale *= root(t.a);
        t.angle_scale *= root(t.a);
    });
    all
}

fn apart(a: &JointProblem, b: &JointProblem) -> f64 {
    let pairs = a.poses.iter().flatten().zip(b.poses.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

pub fn section() -> Result<Section> {
    let mut body = String::from(
        "`joint::Reweighing`: one of a chain's human factors (one per thousand poses: the first, the middle and the last) gets another weight, is taken out, and put back. \
         Solved again from the last solution, only the changed part of the last factorisation made anew, against the batch solver from the same solution; CPU \
         time, ms: median (smallest–largest). `anew`: supernodes factored, share of all (above 100 %: more than once). Apart: largest difference of any pose's number to batch (solved twice: \
         where the cost shows nothing any more it may end some µm early on the longest chain).\n\n\
         | poses | change | again | batch | batch ÷ again | anew | apart |\n|---|---|---|---|---|---|---|\n",
    );
    let options = Options::default();
    let mut claims = Vec::new();
    for poses in SIZES {
        let corrections = (poses / 1000).max(3);
        let (mut all, _) = Reweighing::new(chain(poses, corrections)?, &options.solver)?;
        let mut shares = Vec::new();
        let mut worst: f64 = 0.0;
        for (name, weight) in CHANGES {
            let (mut again_ms, mut batch_ms, mut anew) = (vec![], vec![], vec![]);
            let mut largest: f64 = 0.0;
            for factor in [0, corrections / 2, corrections - 1] {
                for weight in [weight, 1.0] {
                    let mut weights = all.weights().to_vec();
                    weights[factor] = weight;
                    let mut batch = weighted(all.problem(), &weights);
                    let (solved, ms) = cpu::timed(|| Backend::Rust.solve(&mut batch, &options));
                    solved?;
                    batch_ms.push(ms);
                    // Once more from there: on a very long chain the first search ends a little early.
                    Backend::Rust.solve(&mut batch, &options)?;
                    let (solved, ms) = cpu::timed(|| all.reweigh(&[(factor, weight)]));
                    solved?;
                    again_ms.push(ms);
                    let (new, there) = all.refactored();
                    anew.push(100.0 * new as f64 / there as f64);
                    largest = largest.max(apart(all.problem(), &batch));
                }
            }
            shares.extend(again_ms.iter().zip(&batch_ms).map(|(again, batch)| again / batch));
            let (again, batch) = (Sample(again_ms), Sample(batch_ms));
            body += &format!(
                "| {poses} | {name} | {} | {} | {:.1} | {} % | {largest:.0e} |\n",
                again.with_range(1),
                batch.with_range(1),
                batch.median() / again.median(),
                Sample(anew).with_range(0),
            );
            worst = worst.max(largest);
        }
        let claim = |what: &str, measured, bound, decimals, why| Claim {
            what: format!("{poses} poses, one factor reweighted: {what}"),
            measured,
            bound,
            unit: "",
            decimals,
            why,
        };
        claims.push(claim(
            "time, share of batch (median)",
            Sample(shares).median(),
            1.0,
            2,
            "else it is of no use",
        ));
        claims.push(claim(
            "differs from batch by at most (m, rad)",
            worst,
            1e-6,
            0,
            "the contract of crosscheck; 1e-9 in the tests, with tighter stopping",
        ));
    }
    Ok(Section { title: "Corrections reweighted", name: "reweighing", body, claims })
}
