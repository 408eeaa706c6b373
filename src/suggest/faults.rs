//! Faults of the chain: where its scans, matched with each other, contradict it by far more than its own covariance allows.
//!
//! Every metre of the chain, the points after it are matched to the walls before it. Over every window of 1, 2, 4, … such
//! steps the matches are composed, with their covariance, and compared with the poses as they stand. The window that the chain
//! can explain least is a fault (a torn step fills the shortest, a slip of 20 m a longer one); then the rest is searched.

use nalgebra::{Matrix3, Vector3};

use crate::closures::{self, Step};
use crate::geometry::Pose2;
use crate::map::{AutomaticFactor, SlamMap};

/// A window that is further off than so many standard deviations (of chain and matches) is a fault.
const FAULT_SIGMAS: f64 = 7.0;
/// In a fault, no more of the points than this fit as the map stands, among those with a wall near.
const MOST_FITTING: f64 = 0.8;
/// … and this share at least of all points as matched, so much more than as the map stands.
const LEAST_INLIERS: (f64, f64) = (0.65, 0.3);
/// A wider window must be this much further off than a narrower one.
const WIDER: f64 = 1.15;
/// Longest window, steps.
const LONGEST: usize = 32;
/// Variances of a step that no factor holds: m², rad².
const UNKNOWN: (f64, f64) = (1.0, 1.0);

/// A stretch of the chain that its own scans contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Last pose before it.
    pub i: usize,
    /// First pose after it.
    pub j: usize,
    /// Poses from i to j, and where each lies seen from pose i, as matched.
    pub stations: Vec<(usize, Pose2)>,
    /// How far off the chain is, in standard deviations.
    pub sigmas: f64,
    /// Share of the points that fit as matched (least of its steps), and as the map stands (of the same step), 0 to 1.
    pub inliers: [f64; 2],
}

/// All faults, the worst first.
pub fn find(map: &SlamMap) -> Vec<Fault> {
    let steps = closures::compare_steps(map);
    let chain = chain_covariances(map);
    let measured: Vec<Option<Measured>> = steps.iter().map(|s| Measured::of(s, &chain)).collect();
    let mut open: Vec<(usize, usize)> = measured
        .iter()
        .enumerate()
        .collect::<Vec<_>>()
        .split(|(_, m)| m.is_none())
        .filter_map(|run| Some((run.first()?.0, run.last()?.0 + 1)))
        .collect();
    let mut faults = Vec::new();
    while let Some((from, to)) = open.pop() {
        let Some((fault, window)) = worst(map, &steps, &measured, from, to) else { continue };
        faults.push(if window.1 - window.0 == 1 { sharpened(map, fault, &chain) } else { fault });
        open.extend([(from, window.0), (window.1, to)].into_iter().filter(|(from, to)| from < to));
    }
    faults.sort_by(|a, b| b.sigmas.total_cmp(&a.sigmas).then(a.i.cmp(&b.i)));
    faults
}

/// A step as matched.
#[derive(Debug, Clone, Copy)]
struct Measured {
    matched: AutomaticFactor,
    inliers: f64,
    fitting: f64,
    /// Of match and chain together, in the frame of the later pose.
    covariance: Matrix3<f64>,
}

impl Fault {
    /// Pose j as matched from pose i.
    pub fn i_from_j(&self) -> Pose2 {
        self.stations.last().map_or(Pose2::IDENTITY, |s| s.1)
    }
}

impl Measured {
    fn of(step: &Step, chain: &[Matrix3<f64>]) -> Option<Measured> {
        let matched = step.matched?;
        let covariance = matched.factor.information.covariance();
        // Chain steps are short beside their errors' lever: summed as they are, turned nowhere.
        let chain: Matrix3<f64> = chain[step.i..step.j].iter().sum();
        Some(Measured {
            matched,
            inliers: step.inliers,
            fitting: step.fitting,
            covariance: covariance + chain,
        })
    }
}

/// The worst window of the steps `from..to`, if it is a fault.
fn worst(
    map: &SlamMap,
    steps: &[Step],
    measured: &[Option<Measured>],
    from: usize,
    to: usize,
) -> Option<(Fault, (usize, usize))> {
    let mut best: Option<(Fault, (usize, usize))> = None;
    let mut width = 1;
    while width <= LONGEST.min(to - from) {
        for start in from..=to - width {
            let window = (start, start + width);
            let Some(fault) = over(map, steps, &measured[start..start + width], start) else { continue };
            let wider = |b: &(Fault, (usize, usize))| b.1.1 - b.1.0 < width;
            let least =
                best.as_ref().map_or(FAULT_SIGMAS, |b| b.0.sigmas * if wider(b) { WIDER } else { 1.0 });
            if fault.sigmas > least {
                best = Some((fault, window));
            }
        }
        width *= 2;
    }
    best
}

/// A window as if it were a fault.
fn over(map: &SlamMap, steps: &[Step], measured: &[Option<Measured>], start: usize) -> Option<Fault> {
    let mut stations = vec![(steps[start].i, Pose2::IDENTITY)];
    let mut i_from_j = Pose2::IDENTITY;
    let mut covariance = Matrix3::zeros();
    let (mut inliers, mut fitting) = ([1.0, 1.0], 1.0);
    for m in measured {
        let m = m.as_ref()?;
        let step = m.matched.factor.i_from_j;
        i_from_j = i_from_j.compose(step);
        stations.push((m.matched.factor.j, i_from_j));
        let adjoint = adjoint(step.inverse());
        covariance = adjoint * covariance * adjoint.transpose() + m.covariance;
        if m.fitting < fitting {
            (inliers, fitting) = ([m.matched.inliers, m.inliers], m.fitting);
        }
    }
    let (i, j) = (steps[start].i, steps[start + measured.len() - 1].j);
    let sigmas = sigmas(map, (i, j), i_from_j, covariance)?;
    let is_seen = fitting <= MOST_FITTING
        && inliers[0] >= LEAST_INLIERS.0
        && inliers[0] - inliers[1] >= LEAST_INLIERS.1;
    is_seen.then_some(Fault { i, j, stations, sigmas, inliers })
}

/// The one edge of a torn step at which it is torn.
fn sharpened(map: &SlamMap, fault: Fault, chain: &[Matrix3<f64>]) -> Fault {
    let edges = (fault.i..fault.j).filter_map(|k| {
        let step = closures::compare_step(map, k, k + 1);
        let m = Measured::of(&step, chain)?;
        let i_from_j = m.matched.factor.i_from_j;
        let sigmas = sigmas(map, (k, k + 1), i_from_j, m.covariance)?;
        let stations = vec![(k, Pose2::IDENTITY), (k + 1, i_from_j)];
        Some(Fault { i: k, j: k + 1, stations, sigmas, inliers: [m.matched.inliers, m.inliers] })
    });
    let worst = edges.max_by(|a, b| a.sigmas.total_cmp(&b.sigmas).then(b.i.cmp(&a.i)));
    worst.filter(|edge| edge.sigmas > FAULT_SIGMAS).unwrap_or(fault)
}

/// How far the poses are off a match, in standard deviations.
fn sigmas(map: &SlamMap, (i, j): (usize, usize), i_from_j: Pose2, covariance: Matrix3<f64>) -> Option<f64> {
    let error = Vector3::from(i_from_j.between(map.poses[i].between(map.poses[j])).to_array());
    Some(error.dot(&(covariance.cholesky()?.solve(&error))).max(0.0).sqrt())
}

/// Ad(T): covariances of the inner frame's tangent, in the outer frame.
fn adjoint(t: Pose2) -> Matrix3<f64> {
    let (s, c) = t.theta_rad.sin_cos();
    Matrix3::new(c, -s, t.y_m, s, c, -t.x_m, 0.0, 0.0, 1.0)
}

/// Covariance of every step from pose k to k + 1 by the relative factors.
fn chain_covariances(map: &SlamMap) -> Vec<Matrix3<f64>> {
    let unknown = Matrix3::from_diagonal(&Vector3::new(UNKNOWN.0, UNKNOWN.0, UNKNOWN.1));
    let mut steps = vec![unknown; map.poses.len().saturating_sub(1)];
    for factor in map.relative_factors.iter().filter(|f| f.i.abs_diff(f.j) == 1) {
        steps[factor.i.min(factor.j)] = factor.information.covariance();
    }
    steps
}
