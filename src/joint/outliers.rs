//! Pose graphs with edges that are wrong: graduated non-convexity finds out which, and does without them.

use std::time::Instant;

use super::graph::{GraphReport, chi2};
use super::problem::{JointProblem, RelativeTerm};
use super::{Options, build, gauge, take_over};
use crate::error::Result;
use crate::map::{RelativeFactor, SlamMap};
use crate::solver::{Gnc, Loss, Problem, Report, Termination};

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

/// Number of edges that may turn out to be wrong.
pub fn doubted(map: &SlamMap, options: &Options) -> usize {
    map.relative_factors.iter().filter(|f| is_doubted(f, options)).count()
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
    let options = Options { loss: Loss::None, ..*options };
    let mut quick = options;
    (quick.solver.relative_decrease, quick.solver.step) = ROUND_TOLERANCES;
    let mut rounds = Rounds::new(map, &options);
    let first = Gnc::start(threshold, rounds.largest());
    let mut gnc = first;
    while let Some((first, surrogate)) = first.zip(gnc) {
        progress(surrogate.progress(first));
        let changed = rounds.weigh(|s| surrogate.weight(s));
        if !changed && rounds.are_sorted() {
            break;
        }
        rounds.solve(&quick)?;
        gnc = surrogate.next();
    }
    for sorting in 0..MOST_SORTINGS {
        let changed = rounds.weigh(|s| f64::from(u8::from(s <= threshold)));
        if sorting > 0 && !changed {
            break;
        }
        rounds.solve(&options)?;
    }
    let Rounds { problem, report, .. } = rounds;
    let mut solve = report.unwrap_or_else(|| Report::new(0.0, Termination::NothingToOptimize));
    take_over(&problem, &mut map.poses, &mut []);
    solve.timings.total_ms = clock.elapsed().as_secs_f64() * 1e3;
    Ok(GraphReport { initial_chi2, final_chi2: chi2(map), solve })
}

/// The problem with all its edges, and what has been done so far.
struct Rounds<'a> {
    map: &'a SlamMap,
    problem: JointProblem,
    /// Relative terms that may be wrong.
    doubted: Vec<usize>,
    /// Of every relative term; one where it is not doubted.
    weights: Vec<f64>,
    report: Option<Report>,
}

impl<'a> Rounds<'a> {
    fn new(map: &'a SlamMap, options: &Options) -> Self {
        let problem = build(map, &map.poses, &[], options);
        let factors = map.relative_factors.iter().enumerate();
        let doubted = factors.filter(|(_, f)| is_doubted(f, options)).map(|(k, _)| k).collect();
        Rounds { map, weights: vec![1.0; problem.relatives.len()], problem, doubted, report: None }
    }

    /// Squared norms of the doubted terms where the poses stand.
    fn squared_norms(&self) -> impl Iterator<Item = (usize, f64)> {
        let x = self.problem.blocks();
        self.doubted.iter().map(move |&k| (k, self.problem.residual(k, &x).norm_squared()))
    }

    fn largest(&self) -> f64 {
        self.squared_norms().map(|(_, s)| s).fold(0.0, f64::max)
    }

    /// New weights from the squared norms; true if any differs.
    fn weigh(&mut self, weight: impl Fn(f64) -> f64) -> bool {
        let weights: Vec<(usize, f64)> = self.squared_norms().map(|(k, s)| (k, weight(s))).collect();
        let mut changed = false;
        for (term, weight) in weights {
            changed |= self.weights[term] != weight;
            self.weights[term] = weight;
        }
        changed
    }

    /// True if every edge is either taken whole or left out.
    fn are_sorted(&self) -> bool {
        self.weights.iter().all(|&w| w == 0.0 || w == 1.0)
    }

    /// Solves for the weights as they are, from where the poses stand.
    fn solve(&mut self, options: &Options) -> Result<()> {
        let weighted = |(term, &weight): (&RelativeTerm, &f64)| {
            let root = weight.sqrt();
            (weight > SMALLEST_WEIGHT)
                .then(|| RelativeTerm { sqrt_information: term.sqrt_information.map(|u| u * root), ..*term })
        };
        let mut problem = JointProblem {
            poses: self.problem.poses.clone(),
            relatives: self.problem.relatives.iter().zip(&self.weights).filter_map(weighted).collect(),
            ..JointProblem::default()
        };
        let asked = self.map.held_or_first();
        problem.held = gauge::complete(&problem, &asked);
        let mut report = options.backend.solve(&mut problem, options)?;
        report.warnings.extend(gauge::warning(&asked, &problem.held));
        self.problem.poses = problem.poses;
        if let Some(before) = self.report.take() {
            report.iterations.splice(0..0, before.iterations);
            report.timings.order_ms += before.timings.order_ms;
            report.timings.iterate_ms += before.timings.iterate_ms;
        }
        self.report = Some(report);
        Ok(())
    }
}
