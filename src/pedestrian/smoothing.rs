//! Walkers' paths made consistent: least squares over dead reckoning and over ways that were gone more than once.
//!
//! The filter decides *which* ways are the same (its map has cells as wide as a corridor); how they lie to each other within
//! a cell, and how a walk bends on the way there, it leaves to the draw of a particle. Here both are least squares:
//!
//! min Σ ‖Tᵏ⁺¹ ⊖ Tᵏ·Δₖ‖²_Ωₖ + Σ ρ((n·(pᵏ − qᵏ)/σ)²)
//!
//! T: the walker's pose after every few steps, Δ and Ω: its dead reckoning in between and the noise of
//! [`OdometryNoise`], carried along; q: the place on another pass over the same way (an earlier or later one of the
//! same walker, or somebody else's), n the normal of that pass there. Along a way nothing is tied. Which pass is tied to which
//! is found anew in every round, so that it is an iterated closest point on paths, with the odometry as its stiffness.

use nalgebra::{Matrix3, Vector3};

use super::options::OdometryNoise;
use super::walk::Walk;
use crate::geometry::{Pose2, Vec2, angle_diff, wrap_angle};
use crate::solver::{self, Block, Linearization, Loss, Problem};

/// Steps from one node to the next.
const STRIDE: usize = 3;
/// Two passes over one way differ by so much, metres: one standard deviation of a node.
const WAY_SIGMA_M: f64 = 0.3;
/// From here on a tie is doubted, standard deviations (Cauchy).
const DOUBT: f64 = 1.5;
/// Passes are tied if they are this near, metres, and their directions differ by less, radians, modulo π; per round. Ways that part
/// at a small angle, as where a corner is cut, are not one.
const REACH: [(f64, f64); 6] = [(1.5, 0.4), (1.2, 0.4), (1.0, 0.2), (0.8, 0.15), (0.8, 0.15), (0.8, 0.15)];
/// Nearer along the walk than this, metres, it is the same pass.
const SAME_PASS_M: f64 = 8.0;
/// Ties of a node at most: with passes of the same walker, and of the others. The nearest passes are mostly one's own: they would
/// leave no room for anybody else's.
const TIES: [usize; 2] = [4, 8];

/// Over so much of the way the noise of the heading is measured, metres.
pub const WINDOW_M: f64 = 30.0;

/// A walker's dead reckoning, thinned out.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Steps taken before each node; the first is 0, the last all of them.
    pub steps: Vec<usize>,
    /// Path length at each node.
    lengths_m: Vec<f64>,
    /// Node k+1 from node k as the dead reckoning has it.
    motions: Vec<Pose2>,
    /// U with UᵀU = Ω, in the frame of node k.
    sqrt_information: Vec<Matrix3<f64>>,
}

impl Chain {
    /// Of a walk with that noise.
    pub fn new(walk: &Walk, noise: &OdometryNoise) -> Chain {
        let mut chain =
            Chain { steps: vec![0], lengths_m: vec![0.0], motions: vec![], sqrt_information: vec![] };
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
    pub fn filled(&self, walk: &Walk, nodes: &[Pose2]) -> Vec<Pose2> {
        let mut poses = vec![nodes[0]];
        for (k, part) in walk.steps.chunks(STRIDE).enumerate() {
            let mut pose = nodes[k];
            let mut within = Vec::new();
            for step in part {
                pose = pose.compose(Pose2::new(step.forward_m, step.left_m, step.turn_rad));
                within.push(pose);
            }
            let miss = nodes[k + 1].translation() - pose.translation();
            let turn = angle_diff(nodes[k + 1].theta_rad, pose.theta_rad);
            for (i, p) in within.iter().enumerate() {
                let share = (i + 1) as f64 / part.len() as f64;
                let t = p.translation() + miss * share;
                poses.push(Pose2::new(t.x, t.y, wrap_angle(p.theta_rad + turn * share)));
            }
        }
        poses
    }
}

/// One pass tied to another: n·(p − (1−t) a − t b)/σ.
#[derive(Debug, Clone, Copy)]
struct Tie {
    node: usize,
    segment: usize,
    share: f64,
    normal: Vec2,
}

struct Joint<'a> {
    chains: &'a [&'a Chain],
    /// First block of each chain.
    first: Vec<usize>,
    /// (chain, link) of each motion term.
    links: Vec<(usize, usize)>,
    ties: Vec<Tie>,
    weight: f64,
}

impl Problem for Joint<'_> {
    fn terms(&self) -> usize {
        self.links.len() + self.ties.len()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        match self.links.get(term) {
            Some(&(chain, link)) => blocks.extend([self.first[chain] + link, self.first[chain] + link + 1]),
            None => {
                let tie = &self.ties[term - self.links.len()];
                blocks.extend([tie.node, tie.segment, tie.segment + 1]);
            }
        }
    }

    fn loss_of(&self, term: usize) -> Loss {
        if term < self.links.len() { Loss::None } else { Loss::Cauchy(DOUBT) }
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        let mut at = Linearization::default();
        self.linearize(term, x, &mut at);
        at.residual
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        match self.links.get(term) {
            Some(&(chain, link)) => {
                let (i, j) = (self.first[chain] + link, self.first[chain] + link + 1);
                let (a, b) = (Pose2::from_array(x[i]), Pose2::from_array(x[j]));
                let motion = self.chains[chain].motions[link];
                let u = self.chains[chain].sqrt_information[link];
                let (s, c) = x[i][2].sin_cos();
                let d = b.translation() - a.translation();
                let local = Vec2::new(c * d.x + s * d.y, -s * d.x + c * d.y);
                let r = Vector3::new(
                    local.x - motion.x_m,
                    local.y - motion.y_m,
                    angle_diff(angle_diff(x[j][2], x[i][2]), motion.theta_rad),
                );
                at.residual = u * r;
                let from = Matrix3::new(-c, -s, local.y, s, -c, -local.x, 0.0, 0.0, -1.0);
                let to = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
                at.jacobians.extend([(i, u * from), (j, u * to)]);
            }
            None => {
                let tie = &self.ties[term - self.links.len()];
                let p = |k: usize| Vec2::new(x[k][0], x[k][1]);
                let q = p(tie.segment) * (1.0 - tie.share) + p(tie.segment + 1) * tie.share;
                at.residual[0] = self.weight * tie.normal.dot(&(p(tie.node) - q));
                for (block, share) in
                    [(tie.node, 1.0), (tie.segment, tie.share - 1.0), (tie.segment + 1, -tie.share)]
                {
                    let mut jacobian = Matrix3::zeros();
                    jacobian[(0, 0)] = self.weight * share * tie.normal.x;
                    jacobian[(0, 1)] = self.weight * share * tie.normal.y;
                    at.jacobians.push((block, jacobian));
                }
            }
        }
    }
}

/// Makes the nodes of all chains consistent; the first node of the first chain stays where it is.
pub fn smooth(chains: &[&Chain], nodes: &mut [Vec<Pose2>]) {
    let mut first = vec![0];
    for chain in chains {
        first.push(first[first.len() - 1] + chain.steps.len());
    }
    let links =
        chains.iter().enumerate().flat_map(|(c, chain)| (0..chain.motions.len()).map(move |l| (c, l)));
    let mut joint =
        Joint { chains, first, links: links.collect(), ties: Vec::new(), weight: 1.0 / WAY_SIGMA_M };
    let options =
        solver::Options { max_iterations: 8, relative_decrease: 1e-6, step: 1e-4, ..Default::default() };
    for reach in REACH {
        joint.ties = ties(&joint, nodes, reach);
        let mut x: Vec<Block> = nodes.iter().flatten().map(|p| p.to_array()).collect();
        solver::minimize(&joint, &mut x, &[0], &options);
        let mut blocks = x.into_iter();
        for node in nodes.iter_mut().flatten() {
            if let Some(block) = blocks.next() {
                *node = Pose2::from_array(block);
                node.theta_rad = wrap_angle(node.theta_rad);
            }
        }
    }
}

/// Which node goes along which pass.
fn ties(joint: &Joint, nodes: &[Vec<Pose2>], (reach_m, parallel_rad): (f64, f64)) -> Vec<Tie> {
    use std::collections::BTreeMap;
    const SIDE_M: f64 = 3.0;
    let square = |p: Vec2| ((p.x / SIDE_M).floor() as i64, (p.y / SIDE_M).floor() as i64);
    // Links by where their middle is; they are about 2 m long.
    let mut at: BTreeMap<(i64, i64), Vec<(usize, usize)>> = BTreeMap::new();
    for &(c, l) in &joint.links {
        let middle = (nodes[c][l].translation() + nodes[c][l + 1].translation()) / 2.0;
        at.entry(square(middle)).or_default().push((c, l));
    }
    let mut ties = Vec::new();
    for (c, chain) in joint.chains.iter().enumerate() {
        for k in 0..chain.steps.len() {
            let p = nodes[c][k].translation();
            let (before, after) =
                (nodes[c][k.saturating_sub(1)], nodes[c][(k + 1).min(chain.steps.len() - 1)]);
            let heading = after.translation() - before.translation();
            if heading.norm() < 1.0 {
                continue;
            }
            let mut found: Vec<(f64, Tie, (usize, f64))> = Vec::new();
            let (x, y) = square(p);
            for key in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
                for &(other, link) in at.get(&key).into_iter().flatten() {
                    let apart_m = (joint.chains[other].lengths_m[link] - chain.lengths_m[k]).abs();
                    if other == c && apart_m < SAME_PASS_M {
                        continue;
                    }
                    let (a, b) = (nodes[other][link].translation(), nodes[other][link + 1].translation());
                    let d = b - a;
                    let length = d.norm();
                    if length < 0.7 {
                        continue;
                    }
                    let share = (p - a).dot(&d) / (length * length);
                    let normal = Vec2::new(-d.y, d.x) / length;
                    let off_m = normal.dot(&(p - a)).abs();
                    let parallel = heading.perp(&d).abs() / (heading.norm() * length);
                    if !(0.0..1.0).contains(&share) || off_m > reach_m || parallel > parallel_rad.sin() {
                        continue;
                    }
                    let tie =
                        Tie { node: joint.first[c] + k, segment: joint.first[other] + link, share, normal };
                    found.push((off_m, tie, (other, joint.chains[other].lengths_m[link])));
                }
            }
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut passes: Vec<(usize, f64)> = Vec::new();
            let mut room = TIES;
            for (_, tie, pass) in found {
                let seen = passes.iter().any(|p| p.0 == pass.0 && (p.1 - pass.1).abs() < SAME_PASS_M);
                let room = &mut room[usize::from(pass.0 != c)];
                if !seen && *room > 0 {
                    *room -= 1;
                    passes.push(pass);
                    ties.push(tie);
                }
            }
        }
    }
    ties
}

/// The middle of some numbers.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
