//! A walker's dead reckoning, thinned out to nodes: what least squares over paths is made of, and what a path tells of its errors.

use nalgebra::{Matrix3, Vector3};

use super::options::OdometryNoise;
use super::walk::Walk;
use crate::geometry::{Pose2, Vec2, angle_diff, wrap_angle};

/// Steps from one node to the next.
const STRIDE: usize = 3;

/// Over so much of the way the noise of the heading is measured, metres.
pub const WINDOW_M: f64 = 30.0;

/// A walker's dead reckoning, thinned out.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Steps taken before each node; the first is 0, the last all of them.
    pub steps: Vec<usize>,
    /// Path length at each node.
    pub(super) lengths_m: Vec<f64>,
    /// Node k+1 from node k as the dead reckoning has it.
    pub(super) motions: Vec<Pose2>,
    /// U with UᵀU = Ω, in the frame of node k.
    pub(super) sqrt_information: Vec<Matrix3<f64>>,
    /// The pose after every step, from the node before it.
    within: Vec<Pose2>,
    /// Standard deviations of what is wrong with the whole walk: heading drift, radians per metre, and scale.
    pub(super) steady_sigmas: [f64; 2],
}

impl Chain {
    /// Of a walk with that noise.
    pub fn new(walk: &Walk, noise: &OdometryNoise) -> Chain {
        let drift_rad_per_m = noise.drift_start_rad / OdometryNoise::STEP_M;
        let mut chain = Chain {
            steps: vec![0],
            lengths_m: vec![0.0],
            motions: vec![],
            sqrt_information: vec![],
            within: vec![],
            steady_sigmas: [drift_rad_per_m.max(1e-7), noise.scale.max(1e-6)],
        };
        let mut length_m = 0.0;
        for (number, part) in walk.steps.chunks(STRIDE).enumerate() {
            let (mut motion, mut covariance) = (Pose2::IDENTITY, Matrix3::zeros());
            for step in part {
                let share = (step.length_m() / OdometryNoise::STEP_M).max(0.05);
                length_m += step.length_m();
                // p ← p + R(θ) d: a heading error turns the rest of the way.
                let d = motion.rotate(Vec2::new(step.forward_m, step.left_m));
                let f = Matrix3::new(1.0, 0.0, -d.y, 0.0, 1.0, d.x, 0.0, 0.0, 1.0);
                let [heading, position] =
                    [noise.heading_rad.max(1e-5), noise.position_m.max(1e-4)].map(|s| share * s * s);
                covariance = f
                    * (covariance + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, heading)))
                    * f.transpose()
                    + Matrix3::from_diagonal(&Vector3::new(position, position, 0.0));
                motion = motion.compose(Pose2::new(step.forward_m, step.left_m, step.turn_rad));
                chain.within.push(motion);
            }
            let information = covariance.try_inverse().unwrap_or_else(Matrix3::identity);
            let sqrt = information.cholesky().map_or_else(Matrix3::identity, |c| c.l().transpose());
            chain.steps.push((number * STRIDE + part.len()).min(walk.steps.len()));
            chain.lengths_m.push(length_m);
            chain.motions.push(motion);
            chain.sqrt_information.push(sqrt);
        }
        chain
    }

    /// How far the dead reckoning has turned away from the path at each node, radians, not wrapped.
    fn turned_rad(&self, walk: &Walk, nodes: &[Pose2]) -> Vec<f64> {
        let track = walk.track(Pose2::IDENTITY);
        let mut turned = Vec::with_capacity(nodes.len());
        let mut last_rad = 0.0;
        for (&k, node) in self.steps.iter().zip(nodes) {
            last_rad += angle_diff(angle_diff(track[k].theta_rad, node.theta_rad), last_rad);
            turned.push(last_rad);
        }
        turned
    }

    /// The steady part of the heading drift along these nodes, radians per metre: the median slope from each node to the one half
    /// the walk later (after Theil and Sen), so that a part that is still folded wrongly does not count.
    pub fn drift_rad_per_m(&self, walk: &Walk, nodes: &[Pose2]) -> f64 {
        let half_m = self.lengths_m.last().map_or(0.0, |l| l / 2.0);
        let slopes = self.turns_over(walk, nodes, half_m).map(|(metres, rad)| rad / metres);
        median(slopes.collect()).unwrap_or(0.0)
    }

    /// What the walk itself shows of the heading noise, radians per [`OdometryNoise::STEP_M`]: how far the dead reckoning turned
    /// away from these nodes over [`WINDOW_M`], as a random walk of the heading would; from the median square, which a part that is
    /// still folded wrongly does not change. `None` for walks that are too short.
    pub fn heading_noise_rad(&self, walk: &Walk, nodes: &[Pose2]) -> Option<f64> {
        let squares = self.turns_over(walk, nodes, WINDOW_M).map(|(metres, rad)| rad * rad / metres);
        // The median of χ² with one degree of freedom is 0.4549.
        median(squares.collect()).map(|square| f64::sqrt(square * OdometryNoise::STEP_M / 0.4549))
    }

    /// From every node on for `over_m` metres: the metres, and how far the dead reckoning turned away from the path, radians.
    fn turns_over<'a>(
        &'a self,
        walk: &Walk,
        nodes: &[Pose2],
        over_m: f64,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let turned = self.turned_rad(walk, nodes);
        self.lengths_m.iter().enumerate().map_while(move |(k, &from_m)| {
            let last = self.lengths_m.partition_point(|l| *l < from_m + over_m);
            Some((self.lengths_m.get(last)? - from_m, turned[last] - turned[k])).filter(|(m, _)| *m > 0.0)
        })
    }

    /// How much longer the way along these nodes is than the dead reckoning has it, link by link: Σ Δ·Δ′ / Σ Δ·Δ.
    pub fn stretch(&self, nodes: &[Pose2]) -> f64 {
        let (mut both, mut own) = (0.0, 0.0);
        for (motion, pair) in self.motions.iter().zip(nodes.windows(2)) {
            let motion = motion.translation();
            both += pair[0].between(pair[1]).translation().dot(&motion);
            own += motion.norm_squared();
        }
        if own > 0.0 { both / own } else { 1.0 }
    }

    /// Node poses along a path of the filter (one point more than steps): headings are the dead reckoning's, turned by what the
    /// path is turned against it around there.
    pub fn along(&self, walk: &Walk, path: &[Vec2]) -> Vec<Pose2> {
        const AROUND: usize = 8;
        let track = walk.track(Pose2::IDENTITY);
        let mut nodes = Vec::with_capacity(self.steps.len());
        for &k in &self.steps {
            let (first, last) = (k.saturating_sub(AROUND), (k + AROUND).min(walk.steps.len()));
            // Step by step, so that a walker who turns round does not lose the direction.
            let (mut dot, mut cross) = (0.0, 0.0);
            for i in first..last {
                let (a, b) = (track[i + 1].translation() - track[i].translation(), path[i + 1] - path[i]);
                dot += a.dot(&b);
                cross += a.perp(&b);
            }
            nodes.push(Pose2::new(path[k].x, path[k].y, wrap_angle(track[k].theta_rad + cross.atan2(dot))));
        }
        nodes
    }

    /// The pose after every step: the dead reckoning between two nodes, its misfit spread evenly.
    pub fn filled(&self, nodes: &[Pose2]) -> Vec<Pose2> {
        let mut poses = vec![nodes[0]];
        for ((pair, steps), motion) in nodes.windows(2).zip(self.steps.windows(2)).zip(&self.motions) {
            let reached = pair[0].compose(*motion);
            let miss = pair[1].translation() - reached.translation();
            let turn_rad = angle_diff(pair[1].theta_rad, reached.theta_rad);
            let count = (steps[1] - steps[0]) as f64;
            for (i, within) in self.within[steps[0]..steps[1]].iter().enumerate() {
                let (pose, share) = (pair[0].compose(*within), (i + 1) as f64 / count);
                let t = pose.translation() + miss * share;
                poses.push(Pose2::new(t.x, t.y, wrap_angle(pose.theta_rad + turn_rad * share)));
            }
        }
        poses
    }
}

/// The middle of some numbers.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
