//! Walkers' paths made consistent: least squares over dead reckoning and over ways that were gone more than once.
//!
//! The filter decides *which* ways are the same (its map has cells as wide as a corridor); how they lie to each other within
//! a cell, and how a walk bends on the way there, it leaves to the draw of a particle. Here both are least squares:
//!
//! min Σ ‖Tᵏ⁺¹ ⊖ Tᵏ·Δₖ(ρ, s)‖²_Ωₖ + Σ ρ(w (n·(pᵏ − qᵏ))²) + priors of ρ, s
//!
//! T: the walker's pose after every few steps, Δ and Ω: its dead reckoning in between and the noise of
//! [`super::OdometryNoise`], carried along; q: the place on another pass over the same way (an earlier or later one of the
//! same walker, or somebody else's), n the normal of that pass there. Along a way nothing is tied. Which pass is tied to which
//! is found anew in every round (`ties`), so that it is an iterated closest point on paths, with the odometry as its stiffness.
//!
//! [`smooth`] folds paths that are still bent by metres. [`refine`] begins where they lie within some decimetres: each walk's heading
//! drift ρ and scale s are unknowns, and a run of ties counts as much as its two passes follow each other.

use nalgebra::{Matrix3, Vector3};

use super::chain::Chain;
use super::ties::{Passes, Tie};
use crate::geometry::{Pose2, Vec2, angle_diff, wrap_angle};
use crate::solver::{self, Block, Linearization, Loss, Problem};

/// How passes are tied in a round.
struct Round {
    /// As near as this, metres, and as parallel as this, radians modulo π. Ways that part at a small angle, as where a corner is cut, are not one.
    reach_m: f64,
    parallel_rad: f64,
    /// Standard deviation of a tie, metres; `None`: by the run it belongs to.
    sigma_m: Option<f64>,
}

const fn round(reach_m: f64, parallel_rad: f64, sigma_m: Option<f64>) -> Round {
    Round { reach_m, parallel_rad, sigma_m }
}

const SMOOTH: [Round; 6] = [
    round(1.5, 0.4, Some(0.3)),
    round(1.2, 0.4, Some(0.3)),
    round(1.0, 0.2, Some(0.3)),
    round(0.8, 0.15, Some(0.3)),
    round(0.8, 0.15, Some(0.3)),
    round(0.8, 0.15, Some(0.3)),
];
/// The first round lets go of what the ties have bent: passes that were pulled together wrongly look as if they followed each other.
const REFINE: [Round; 6] = [
    round(1.0, 0.15, Some(1.5)),
    round(1.0, 0.1, None),
    round(0.8, 0.07, None),
    round(0.6, 0.05, None),
    round(0.6, 0.05, None),
    round(0.6, 0.05, None),
];
/// From here on a tie is doubted, standard deviations (Cauchy).
const DOUBT: [f64; 2] = [1.5, 3.0];
/// Units of the blocks of a walk's steady errors: drift in radians per metre, scale.
const UNITS: [f64; 2] = [1e-3, 1e-2];

struct Joint<'a> {
    chains: &'a [&'a Chain],
    /// First block of each chain, and the block after the last.
    first: Vec<usize>,
    /// (chain, link) of each motion term.
    links: Vec<(usize, usize)>,
    ties: Vec<Tie>,
    doubt: f64,
    /// A block of steady errors for each chain, behind those of the nodes.
    with_errors: bool,
}

impl<'a> Joint<'a> {
    fn new(chains: &'a [&'a Chain], with_errors: bool) -> Joint<'a> {
        let mut first = vec![0];
        for chain in chains {
            first.push(first[first.len() - 1] + chain.steps.len());
        }
        let links =
            chains.iter().enumerate().flat_map(|(c, chain)| (0..chain.motions.len()).map(move |l| (c, l)));
        let links = links.collect();
        Joint { chains, first, links, ties: Vec::new(), doubt: DOUBT[usize::from(with_errors)], with_errors }
    }

    /// The block of a chain's steady errors.
    fn errors_of(&self, chain: usize) -> usize {
        self.first[self.chains.len()] + chain
    }

    fn link(&self, chain: usize, link: usize, x: &[Block], at: &mut Linearization) {
        let (i, j) = (self.first[chain] + link, self.first[chain] + link + 1);
        let here = self.chains[chain];
        let (motion, u) = (here.motions[link], here.sqrt_information[link]);
        let length_m = here.lengths_m[link + 1] - here.lengths_m[link];
        let [drift, scale] = match self.with_errors {
            true => [0, 1].map(|k| UNITS[k] * x[self.errors_of(chain)][k]),
            false => [0.0; 2],
        };
        // The drift turns the link by half of what it turns its end.
        let turned = Pose2::new(0.0, 0.0, -0.5 * drift * length_m).rotate(motion.translation());
        let expected = turned * (1.0 - scale);
        let (s, c) = x[i][2].sin_cos();
        let d = Vec2::new(x[j][0] - x[i][0], x[j][1] - x[i][1]);
        let local = Vec2::new(c * d.x + s * d.y, -s * d.x + c * d.y);
        let turn_rad = angle_diff(angle_diff(x[j][2], x[i][2]), motion.theta_rad - drift * length_m);
        at.residual = u * Vector3::new(local.x - expected.x, local.y - expected.y, turn_rad);
        let from = Matrix3::new(-c, -s, local.y, s, -c, -local.x, 0.0, 0.0, -1.0);
        let to = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
        at.jacobians.extend([(i, u * from), (j, u * to)]);
        if self.with_errors {
            let half = 0.5 * length_m;
            let by_drift = Vector3::new(-half * expected.y, half * expected.x, length_m) * UNITS[0];
            let by_scale = Vector3::new(turned.x, turned.y, 0.0) * UNITS[1];
            let jacobian = Matrix3::from_columns(&[by_drift, by_scale, Vector3::zeros()]);
            at.jacobians.push((self.errors_of(chain), u * jacobian));
        }
    }
}

impl Problem for Joint<'_> {
    fn terms(&self) -> usize {
        self.links.len() + self.ties.len() + if self.with_errors { self.chains.len() } else { 0 }
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        if let Some(&(chain, link)) = self.links.get(term) {
            blocks.extend([self.first[chain] + link, self.first[chain] + link + 1]);
            blocks.extend(self.with_errors.then(|| self.errors_of(chain)));
        } else if let Some(tie) = self.ties.get(term - self.links.len()) {
            blocks.extend([tie.node, tie.segment, tie.segment + 1]);
        } else {
            blocks.push(self.errors_of(term - self.links.len() - self.ties.len()));
        }
    }

    fn loss_of(&self, term: usize) -> Loss {
        let is_tie = (self.links.len()..self.links.len() + self.ties.len()).contains(&term);
        if is_tie { Loss::Cauchy(self.doubt) } else { Loss::None }
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        let mut at = Linearization::default();
        self.linearize(term, x, &mut at);
        at.residual
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        if let Some(&(chain, link)) = self.links.get(term) {
            self.link(chain, link, x, at);
        } else if let Some(tie) = self.ties.get(term - self.links.len()) {
            let p = |k: usize| Vec2::new(x[k][0], x[k][1]);
            let q = p(tie.segment) * (1.0 - tie.share) + p(tie.segment + 1) * tie.share;
            at.residual[0] = tie.weight * (tie.normal.dot(&(p(tie.node) - q)) - tie.offset_m);
            for (block, share) in
                [(tie.node, 1.0), (tie.segment, tie.share - 1.0), (tie.segment + 1, -tie.share)]
            {
                let mut jacobian = Matrix3::zeros();
                jacobian[(0, 0)] = tie.weight * share * tie.normal.x;
                jacobian[(0, 1)] = tie.weight * share * tie.normal.y;
                at.jacobians.push((block, jacobian));
            }
        } else {
            let chain = term - self.links.len() - self.ties.len();
            let block = self.errors_of(chain);
            let sigmas = self.chains[chain].steady_sigmas;
            let weights = Vector3::new(UNITS[0] / sigmas[0], UNITS[1] / sigmas[1], 0.0);
            at.residual = Vector3::from(x[block]).component_mul(&weights);
            at.jacobians.push((block, Matrix3::from_diagonal(&weights)));
        }
    }
}

/// Makes the nodes of all chains consistent, however bent they are; the first node of the first chain stays where it is.
pub fn smooth(chains: &[&Chain], nodes: &mut [Vec<Pose2>]) {
    minimise(Joint::new(chains, false), &SMOOTH, nodes);
}

/// The same of nodes that lie within some decimetres, as exactly as the walks tell.
pub fn refine(chains: &[&Chain], nodes: &mut [Vec<Pose2>]) {
    minimise(Joint::new(chains, true), &REFINE, nodes);
}

fn minimise(mut joint: Joint, rounds: &[Round], nodes: &mut [Vec<Pose2>]) {
    let options =
        solver::Options { max_iterations: 8, relative_decrease: 1e-6, step: 1e-4, ..Default::default() };
    let mut errors: Vec<Block> = vec![[0.0; 3]; if joint.with_errors { joint.chains.len() } else { 0 }];
    for round in rounds {
        let passes = Passes { chains: joint.chains, first: &joint.first };
        let mut ties = passes.ties(nodes, round.reach_m, round.parallel_rad, round.sigma_m.unwrap_or(1.0));
        if round.sigma_m.is_none() {
            passes.weigh_by_runs(&mut ties, nodes);
        }
        joint.ties = ties;
        let mut x: Vec<Block> = nodes.iter().flatten().map(|p| p.to_array()).collect();
        x.extend(&errors);
        solver::minimize(&joint, &mut x, &[0], &options);
        errors = x.split_off(x.len() - errors.len());
        for (node, block) in nodes.iter_mut().flatten().zip(x) {
            *node = Pose2::from_array(block);
            node.theta_rad = wrap_angle(node.theta_rad);
        }
    }
}
