//! The part of an elimination order that needs no search: runs of nodes with at most two neighbours. A maximal run goes
//! first, node by node along it, and leaves one edge between the nodes at its ends: no order of its nodes has less fill. A
//! trajectory is little else than such runs.

use super::ordering::Graph;

/// A graph without its runs.
#[derive(Debug, Default)]
pub(super) struct Unchained {
    /// The nodes of all runs, in the order in which to eliminate them.
    pub runs: Vec<u32>,
    /// What is left then.
    pub rest: Graph,
    /// Node of every node of `rest`.
    pub nodes: Vec<u32>,
}

const NONE: u32 = u32::MAX;
/// In `name`: in a run.
const TAKEN: u32 = u32::MAX - 1;

/// Takes the runs out of a graph.
pub(super) fn unchain(graph: &Graph) -> Unchained {
    let n = graph.nodes() as u32;
    let degree = |v: u32| graph.of(v).len();
    let nodes: Vec<u32> = (0..n).filter(|&v| degree(v) > 2).collect();
    let mut walk = Walk { graph, name: vec![NONE; n as usize], edges: Vec::new(), runs: Vec::new(), nodes };
    for (k, &v) in walk.nodes.iter().enumerate() {
        walk.name[v as usize] = k as u32;
    }
    for k in 0..walk.nodes.len() {
        walk.take_runs_at(k as u32);
    }
    // Parts without a branch: paths from one of their ends, then rings, of which one node stays.
    for v in 0..n {
        if degree(v) <= 1 && walk.name[v as usize] == NONE {
            walk.along(NONE, v);
        }
    }
    for v in 0..n {
        if walk.name[v as usize] == NONE {
            walk.name[v as usize] = walk.nodes.len() as u32;
            walk.nodes.push(v);
            walk.take_runs_at(walk.nodes.len() as u32 - 1);
        }
    }
    let Walk { edges, runs, nodes, .. } = walk;
    Unchained { runs, rest: Graph::new(nodes.len(), &edges), nodes }
}

struct Walk<'a> {
    graph: &'a Graph,
    /// In `rest`, of a node that stays; else [`NONE`] or [`TAKEN`].
    name: Vec<u32>,
    edges: Vec<(u32, u32)>,
    runs: Vec<u32>,
    nodes: Vec<u32>,
}

impl Walk<'_> {
    /// All that starts at a node that stays.
    fn take_runs_at(&mut self, name: u32) {
        let v = self.nodes[name as usize];
        let graph = self.graph;
        for &to in graph.of(v) {
            match self.name[to as usize] {
                TAKEN => {}
                NONE => {
                    let begun = self.runs.len();
                    match self.along(v, to) {
                        Some(end) if end != name => self.edges.push((name, end)),
                        Some(_) => {}
                        // It leads nowhere: from its far end there is no fill at all.
                        None => self.runs[begun..].reverse(),
                    }
                }
                other if name < other => self.edges.push((name, other)),
                _ => {}
            }
        }
    }

    /// Takes a run, coming from one neighbour of its first node; the node that stays at its other end.
    fn along(&mut self, mut from: u32, mut at: u32) -> Option<u32> {
        loop {
            self.name[at as usize] = TAKEN;
            self.runs.push(at);
            let next = self.graph.of(at).iter().copied().find(|&v| v != from)?;
            if self.name[next as usize] != NONE {
                return Some(self.name[next as usize]);
            }
            (from, at) = (at, next);
        }
    }
}
