//! Which pass of a walker goes along which other pass, its own or somebody else's: what least squares ties together.
//!
//! A node is tied to the other path as its steps have it, not to the chord between two nodes: at a corner, and where ways part at a
//! small angle, the chord lies up to half a metre off.

use std::collections::BTreeMap;

use super::chain::Chain;
use crate::geometry::{Pose2, Vec2};

/// Nearer along the walk than this, metres, it is the same pass.
const SAME_PASS_M: f64 = 8.0;
/// Ties of a node at most: with passes of the same walker, and of the others. The nearest passes are mostly one's own: they would
/// leave no room for anybody else's.
const TIES: [usize; 2] = [4, 8];
/// Side of the squares in which steps are looked up, metres: no step that is near enough lies further than in the next one.
const SIDE_M: f64 = 2.5;
type Square = (i64, i64);

/// A run of ties between two passes ends after so many nodes, about 10 m.
const RUN: usize = 5;
/// Along a run the other pass goes on by less than this from node to node, metres.
const NEXT_M: f64 = 6.0;
/// Neighbouring nodes are off together: so much of an independent measurement is a tie of a run.
const OWN_SHARE: f64 = 0.5;
/// Two passes follow each other to this, metres, before their run is looked at; that counts as one measurement.
const RUN_SIGMA_M: f64 = 0.05;
/// A node by itself is off its way by this, metres.
const NODE_SIGMA_M: f64 = 0.05;

/// One pass tied to another: weight · (n·(p − (1−t) a − t b) − offset).
#[derive(Debug, Clone, Copy)]
pub(super) struct Tie {
    /// Blocks: p, and a; b is the one after a.
    pub node: usize,
    pub segment: usize,
    pub share: f64,
    pub normal: Vec2,
    /// Where the other path itself is, off the chord from a to b, metres.
    pub offset_m: f64,
    pub weight: f64,
}

/// Paths whose passes are tied: chain by chain, with the first block of each.
pub(super) struct Passes<'a> {
    pub chains: &'a [&'a Chain],
    pub first: &'a [usize],
}

impl Passes<'_> {
    /// Chain and node of a block.
    fn place(&self, block: usize) -> (usize, usize) {
        let chain = self.first.partition_point(|f| *f <= block) - 1;
        (chain, block - self.first[chain])
    }

    /// Ties of all nodes to paths within `reach_m` whose direction differs by less than `parallel_rad` modulo π, each with the weight
    /// of `sigma_m`. In the order of nodes.
    pub fn ties(&self, nodes: &[Vec<Pose2>], reach_m: f64, parallel_rad: f64, sigma_m: f64) -> Vec<Tie> {
        let square = |p: Vec2| -> Square { ((p.x / SIDE_M).floor() as i64, (p.y / SIDE_M).floor() as i64) };
        let paths: Vec<Vec<Vec2>> = (self.chains.iter().zip(nodes))
            .map(|(chain, nodes)| chain.filled(nodes).iter().map(|p| p.translation()).collect())
            .collect();
        // (chain, link, step) by where the step's middle is.
        let mut at: BTreeMap<Square, Vec<(usize, usize, usize)>> = BTreeMap::new();
        for (c, chain) in self.chains.iter().enumerate() {
            for (link, steps) in chain.steps.windows(2).enumerate() {
                for step in steps[0]..steps[1] {
                    let middle = (paths[c][step] + paths[c][step + 1]) / 2.0;
                    at.entry(square(middle)).or_default().push((c, link, step));
                }
            }
        }
        let mut ties = Vec::new();
        for (c, chain) in self.chains.iter().enumerate() {
            for (k, &taken) in chain.steps.iter().enumerate() {
                let p = nodes[c][k].translation();
                let heading =
                    paths[c][(taken + 1).min(paths[c].len() - 1)] - paths[c][taken.saturating_sub(1)];
                if heading.norm() < 0.5 {
                    continue;
                }
                let mut found: Vec<(f64, Tie, (usize, f64))> = Vec::new();
                let (x, y) = square(p);
                for key in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
                    for &(other, link, step) in at.get(&key).into_iter().flatten() {
                        let there = self.chains[other];
                        let apart_m = (there.lengths_m[link] - chain.lengths_m[k]).abs();
                        if other == c && apart_m < SAME_PASS_M {
                            continue;
                        }
                        let (a, b) = (paths[other][step], paths[other][step + 1]);
                        let d = b - a;
                        let length = d.norm();
                        if length < 0.2 {
                            continue;
                        }
                        let along = (p - a).dot(&d) / (length * length);
                        let normal = Vec2::new(-d.y, d.x) / length;
                        let off_m = normal.dot(&(p - a)).abs();
                        let parallel = heading.perp(&d).abs() / (heading.norm() * length);
                        if !(0.0..1.0).contains(&along) || off_m > reach_m || parallel > parallel_rad.sin() {
                            continue;
                        }
                        let steps = [there.steps[link], there.steps[link + 1]];
                        let share = ((step - steps[0]) as f64 + along) / (steps[1] - steps[0]) as f64;
                        let ends = [link, link + 1].map(|l| nodes[other][l].translation());
                        let chord = ends[0] * (1.0 - share) + ends[1] * share;
                        let tie = Tie {
                            node: self.first[c] + k,
                            segment: self.first[other] + link,
                            share,
                            normal,
                            offset_m: normal.dot(&(a + d * along - chord)),
                            weight: 1.0 / sigma_m,
                        };
                        found.push((off_m, tie, (other, there.lengths_m[link])));
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

    /// Weights from how well passes follow each other, run by run: two who went the same line tell a lot, two who crossed a corridor
    /// each in its own way little, and all along. A run's own variance is unknown (Student's t, one degree of freedom).
    pub fn weigh_by_runs(&self, ties: &mut [Tie], nodes: &[Vec<Pose2>]) {
        struct Run {
            last_node: usize,
            other: usize,
            at_m: f64,
            ties: Vec<usize>,
            squares: f64,
        }
        let mut runs: Vec<Run> = Vec::new();
        let (mut open, mut chain_before): (Vec<usize>, _) = (Vec::new(), 0);
        for (index, tie) in ties.iter().enumerate() {
            let ((c, k), (other, link)) = (self.place(tie.node), self.place(tie.segment));
            if c != chain_before {
                open.clear();
                chain_before = c;
            }
            let ends = [link, link + 1].map(|l| nodes[other][l].translation());
            let chord = ends[0] * (1.0 - tie.share) + ends[1] * tie.share;
            let off_m = tie.normal.dot(&(nodes[c][k].translation() - chord)) - tie.offset_m;
            let at_m = self.chains[other].lengths_m[link];
            // One node in between may have been left out.
            open.retain(|&r| runs[r].last_node + 3 > tie.node && runs[r].ties.len() < RUN);
            let goes_on = |r: &&usize| {
                let run = &runs[**r];
                run.other == other && run.last_node < tie.node && (run.at_m - at_m).abs() < NEXT_M
            };
            let run = match open.iter().find(goes_on) {
                Some(&run) => run,
                None => {
                    open.push(runs.len());
                    runs.push(Run { last_node: 0, other, at_m, ties: Vec::new(), squares: 0.0 });
                    runs.len() - 1
                }
            };
            let run = &mut runs[run];
            (run.last_node, run.at_m) = (tie.node, at_m);
            run.ties.push(index);
            run.squares += off_m * off_m;
        }
        // A node's own deviation is one, however many passes it is tied to: they count as their mean.
        let mut of_node: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for run in &runs {
            let measured = OWN_SHARE * run.ties.len() as f64;
            let variance = (RUN_SIGMA_M.powi(2) + OWN_SHARE * run.squares) / (1.0 + measured);
            for &tie in &run.ties {
                ties[tie].weight = (OWN_SHARE / variance).sqrt();
                let (sum, count) = of_node.entry(ties[tie].node).or_default();
                (*sum, *count) = (*sum + OWN_SHARE / variance, *count + 1.0);
            }
        }
        for tie in ties {
            let (sum, count) = of_node[&tie.node];
            tie.weight /= (count + sum * NODE_SIGMA_M.powi(2)).sqrt();
        }
    }
}
