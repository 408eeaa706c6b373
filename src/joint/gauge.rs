//! The gauge: every connected part of the graph needs a pose that does not move, or it floats freely.

use super::problem::JointProblem;
use crate::solver::Problem;

/// Parts of a graph: union–find with path halving.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    /// The parts that the terms of a problem make of its blocks.
    fn of(problem: &JointProblem) -> Self {
        let mut parts = Parts { parent: (0..problem.block_count()).collect() };
        let mut touched = Vec::new();
        for term in 0..problem.terms() {
            touched.clear();
            problem.blocks_of(term, &mut touched);
            for pair in touched.windows(2) {
                let (a, b) = (parts.root(pair[0]), parts.root(pair[1]));
                // The lowest index is the root, so that results do not depend on the order of the terms.
                parts.parent[a.max(b)] = a.min(b);
            }
        }
        parts
    }

    fn root(&mut self, mut block: usize) -> usize {
        while self.parent[block] != block {
            self.parent[block] = self.parent[self.parent[block]];
            block = self.parent[block];
        }
        block
    }

    /// Parts that hold one of these poses, by root.
    fn with_any(&mut self, poses: &[usize]) -> Vec<bool> {
        let mut found = vec![false; self.parent.len()];
        for &pose in poses {
            let root = self.root(pose);
            found[root] = true;
        }
        found
    }
}

/// `held` plus the lowest pose of every part of the graph that has no held pose; ascending.
pub(super) fn complete(problem: &JointProblem, held: &[usize]) -> Vec<usize> {
    let mut parts = Parts::of(problem);
    let mut anchored = parts.with_any(held);
    let mut all = held.to_vec();
    for pose in 0..problem.poses.len() {
        let root = parts.root(pose);
        if !anchored[root] {
            anchored[root] = true;
            all.push(pose);
        }
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// The lowest pose that no term chain leads to a held pose from.
pub(super) fn first_loose(problem: &JointProblem) -> Option<usize> {
    let mut parts = Parts::of(problem);
    let anchored = parts.with_any(&problem.held);
    (0..problem.poses.len()).find(|&pose| !anchored[parts.root(pose)])
}

/// Says which poses were held although nobody asked for it.
pub(super) fn warning(asked: &[usize], held: &[usize]) -> Option<String> {
    let added: Vec<usize> = held.iter().copied().filter(|h| asked.binary_search(h).is_err()).collect();
    let list: Vec<String> = added.iter().take(8).map(usize::to_string).collect();
    let more = if added.len() > list.len() { ", …" } else { "" };
    (!added.is_empty()).then(|| {
        format!(
            "the graph falls into separate parts: held in addition, one pose for each of {} parts: {}{more}",
            added.len(),
            list.join(", ")
        )
    })
}
