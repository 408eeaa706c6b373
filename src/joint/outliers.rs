//! Pose graphs with edges that are wrong: graduated non-convexity finds out which, and does without them.

use std::time::Instant;

use super::graph::{GraphReport, chi2};
use super::problem::{JointProblem, RelativeTerm};
use super::{Options, build, gauge};
use crate::error::Result;
use crate::map::{RelativeFactor, SlamMap};
use crate::solver::{self, Gnc, Problem, Report};

/// Weights below take a term out of a round: what is left of it would only cost digits.
const SMALLEST_WEIGHT: f64 = 1e-12;

/// Times that the edges are sorted anew once the weights have settled; each time the poses are solved to the last digit.
const MOST_SORTINGS: usize = 10;

/// A round need not be solved better than the next one needs it: share of the cost, and metres or radians.
const ROUND_TOLERANCES: (f64, f64) = (1e-6, 1e-4);

/// An edge that the others contradict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    /// Index into [`SlamMap::relative_factors`].
    pub factor: usize,
    /// eᵀΩe where the map stands.
    pub chi2: f64,
}

/// True if an edge may turn out to be wrong: it closes a loop, or odometry is doubted too.
pub(super) fn is_doubted(factor: &RelativeFactor, options: &Options) -> bool {
    options.doubt_odometry || factor.i.abs_diff(factor.j) != 1
}

/// Doubted edges whose eᵀΩe is above `threshold` where the map stands, in the order of the map.
pub fn outliers(map: &SlamMap, options: &Options, threshold: f64) -> Vec<Outlier> {
    let factors = map.relative_factors.iter().enumerate().filter(|(_, f)| is_doubted(f, options));
    factors
        .map(|(factor, f)| Outlier { factor, chi2: f.chi2(map.poses[f.i], map.poses[f.j]) })
        .filter(|o| o.chi2 > threshold)
        .collect()
}

/// As [`super::optimize_graph`], over those edges alone that agree with each other: an edge is left out if its eᵀΩe is above
/// `threshold` at the result (truncated least squares). From the poses where they stand, the doubted edges weigh in
/// little by little, the ones that disagree least first. [`Options::loss`] plays no part.
/// `progress` is told the share done, 0 to 1.
///
/// # Errors
/// As [`super::optimize_graph`].
pub fn optimize_graph_without_outliers(
    map: &mut SlamMap,
    options: &Options,
    threshold: f64,
    progress: &dyn Fn(f64),
) -> Result<GraphReport> {
    options.validate()?;
    map.validate("graph")?;
    let clock = Instant::now();
    let initial_chi2 = chi2(map);
    let options = Options { loss: solver::Loss::None, ..*options };
    let mut rounds = Rounds::new(map, &options);
    if let Some(first) = Gnc::start(threshold, rounds.largest()) {
        let mut gnc = Some(first);
        let mut quick = options;
        (quick.solver.relative_decrease, quick.solver.step) = ROUND_TOLERANCES;
        while let Some(surrogate) = gnc {
            progress(surrogate.progress(first));
            if rounds.weigh(|s| surrogate.weight(s)) || rounds.solves == 0 {
                rounds.solve(&quick)?;
            } else if rounds.are_sorted() {
                break;
            }
            gnc = surrogate.next();
        }
    }
    for _ in 0..MOST_SORTINGS {
        let changed = rounds.weigh(|s| if s > threshold { 0.0 } else { 1.0 });
        if !changed && rounds.is_final {
            break;
        }
        rounds.solve(&options)?;
        rounds.is_final = true;
    }
    let Rounds { problem, mut report, .. } = rounds;
    super::take_over(&problem, &mut map.poses, &mut []);
    report.timings.total_ms = clock.elapsed().as_secs_f64() * 1e3;
    Ok(GraphReport { initial_chi2, final_chi2: chi2(map), solve: report })
}

/// The problem with all its edges, their weights, and what has been done so far.
struct Rounds<'a> {
    map: &'a SlamMap,
    problem: JointProblem,
    /// Per relative term; those of edges that are not doubted stay one.
    weights: Vec<f64>,
    doubted: Vec<usize>,
    report: Report,
    solves: usize,
    /// True once the last digits have been solved for.
    is_final: bool,
}
