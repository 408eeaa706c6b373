//! Fill-reducing ordering: approximate minimum degree on the quotient graph (Amestoy, Davis & Duff, SIAM J. Matrix Anal.
//! Appl. 17(4), 1996), with element absorption, mass elimination and indistinguishable nodes. On the graph of blocks,
//! not of numbers: the same fill for a ninth of the work.

/// A symmetric graph without loops or duplicate edges, compressed.
#[derive(Debug, Clone, Default)]
pub(super) struct Graph {
    /// Where the neighbours of each node start; one more at the end.
    pub starts: Vec<u32>,
    /// The neighbours of all nodes in turn.
    pub neighbours: Vec<u32>,
}

impl Graph {
    /// From edges in any order, duplicates allowed, loops not.
    pub fn new(nodes: usize, edges: &[(u32, u32)]) -> Self {
        let mut starts = vec![0u32; nodes + 2];
        for &(a, b) in edges {
            starts[a as usize + 2] += 1;
            starts[b as usize + 2] += 1;
        }
        for k in 2..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut neighbours = vec![0u32; 2 * edges.len()];
        for &(a, b) in edges {
            for (from, to) in [(a, b), (b, a)] {
                let at = &mut starts[from as usize + 1];
                neighbours[*at as usize] = to;
                *at += 1;
            }
        }
        starts.pop();
        // Sort and drop duplicates, in place.
        let mut end = 0;
        for node in 0..nodes {
            let range = starts[node] as usize..starts[node + 1] as usize;
            neighbours[range.clone()].sort_unstable();
            starts[node] = end as u32;
            for k in range {
                let fresh = end == starts[node] as usize || neighbours[end - 1] != neighbours[k];
                if fresh {
                    neighbours[end] = neighbours[k];
                    end += 1;
                }
            }
        }
        starts[nodes] = end as u32;
        neighbours.truncate(end);
        Graph { starts, neighbours }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Neighbours of a node, ascending.
    pub fn of(&self, node: u32) -> &[u32] {
        &self.neighbours[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }
}

const NONE: u32 = u32::MAX;

/// Nodes in the order in which to eliminate them.
pub(super) fn minimum_degree(graph: &Graph) -> Vec<u32> {
    minimum_degree_between(graph, 0, |_| false)
}

/// The same where the first `eliminated` nodes, no two of them neighbours, come first in any case, and those that are
/// `last` last.
pub(super) fn minimum_degree_between(
    graph: &Graph,
    eliminated: usize,
    last: impl Fn(u32) -> bool,
) -> Vec<u32> {
    let mut quotient = Quotient::new(graph, eliminated, last);
    let mut pivots: Vec<u32> = (0..eliminated as u32).collect();
    while let Some(pivot) = quotient.next_pivot() {
        quotient.eliminate(pivot);
        pivots.push(pivot);
    }
    let mut order = Vec::with_capacity(graph.nodes());
    for node in pivots.into_iter().chain(quotient.dense) {
        let mut member = node;
        while member != NONE {
            order.push(member);
            member = quotient.next_member[member as usize];
        }
    }
    order
}

/// What is left of the graph: variables (not yet eliminated) and elements (cliques that eliminations left behind).
struct Quotient {
    /// Of a variable: its elements, then its variables. Of an element: its variables.
    lists: Vec<u32>,
    start: Vec<u32>,
    /// Length of the part with elements.
    elements: Vec<u32>,
    length: Vec<u32>,
    /// Nodes that a variable stands for; 0: merged into another or eliminated; negative: in the current pivot's clique.
    weight: Vec<i32>,
    /// Of a variable: upper bound of its degree. Of an element: its size.
    degree: Vec<u32>,
    /// Of an element: 0 if absorbed, else `flag` + its nodes outside of the current clique, if at least `flag`.
    mark: Vec<u64>,
    flag: u64,
    buckets: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    lowest: usize,
    eliminated: usize,
    next_member: Vec<u32>,
    last_member: Vec<u32>,
    /// Variables with so many neighbours that they go last.
    dense: Vec<u32>,
    clique: Vec<u32>,
    hashes: Vec<(u64, u32)>,
}

impl Quotient {
    fn new(graph: &Graph, eliminated: usize, last: impl Fn(u32) -> bool) -> Self {
        let n = graph.nodes();
        let length: Vec<u32> = (0..n as u32).map(|v| graph.of(v).len() as u32).collect();
        let mut quotient = Quotient {
            lists: graph.neighbours.clone(),
            start: graph.starts[..n].to_vec(),
            elements: vec![0; n],
            degree: length.clone(),
            length,
            weight: vec![1; n],
            mark: vec![1; n],
            flag: 2,
            buckets: vec![NONE; n + 1],
            next: vec![NONE; n],
            previous: vec![NONE; n],
            lowest: 0,
            eliminated,
            next_member: vec![NONE; n],
            last_member: (0..n as u32).collect(),
            dense: Vec::new(),
            clique: Vec::new(),
            hashes: Vec::new(),
        };
        let many = (10.0 * (n as f64).sqrt()).max(16.0) as u32;
        quotient.weight[..eliminated].fill(0);
        for v in eliminated as u32..n as u32 {
            // Neighbours are ascending: elements come first, as they must.
            let elements = graph.of(v).partition_point(|&e| (e as usize) < eliminated);
            quotient.elements[v as usize] = elements as u32;
            let around: u32 = graph.of(v)[..elements].iter().map(|&e| quotient.degree[e as usize] - 1).sum();
            let left = (n - eliminated - 1) as u32;
            quotient.degree[v as usize] = (quotient.degree[v as usize] - elements as u32 + around).min(left);
            if last(v) || quotient.degree[v as usize] > many {
                quotient.dense.push(v);
                quotient.weight[v as usize] = 0;
                quotient.eliminated += 1;
            } else {
                quotient.insert(v);
            }
        }
        quotient
    }

    fn insert(&mut self, v: u32) {
        let d = self.degree[v as usize] as usize;
        let head = self.buckets[d];
        self.next[v as usize] = head;
        self.previous[v as usize] = NONE;
        if head != NONE {
            self.previous[head as usize] = v;
        }
        self.buckets[d] = v;
        self.lowest = self.lowest.min(d);
    }

    fn remove(&mut self, v: u32) {
        let (before, after) = (self.previous[v as usize], self.next[v as usize]);
        if after != NONE {
            self.previous[after as usize] = before;
        }
        if before != NONE {
            self.next[before as usize] = after;
        } else {
            self.buckets[self.degree[v as usize] as usize] = after;
        }
    }

    fn next_pivot(&mut self) -> Option<u32> {
        while self.lowest < self.buckets.len() {
            let pivot = self.buckets[self.lowest];
            if pivot != NONE {
                self.remove(pivot);
                return Some(pivot);
            }
            self.lowest += 1;
        }
        None
    }

    /// Turns a variable into an element and updates the degrees around it.
    fn eliminate(&mut self, pivot: u32) {
        let p = pivot as usize;
        self.eliminated += self.weight[p] as usize;
        let size = self.gather_clique(pivot);
        self.count_outside();
        let mut size = self.update_members(pivot, size);
        self.flag += self.start.len() as u64 + 1;
        self.merge_indistinguishable();
        // Restore the weights, drop what was merged, put the others back by degree.
        let start = self.lists.len();
        let mut clique = std::mem::take(&mut self.clique);
        for &i in &clique {
            let v = i as usize;
            let weight = -self.weight[v];
            if weight <= 0 {
                continue;
            }
            self.weight[v] = weight;
            let weight = weight as u32;
            let left = (self.start.len() - self.eliminated) as u32 - weight;
            self.degree[v] = (self.degree[v] + size - weight).min(left);
            self.insert(i);
            self.lists.push(i);
        }
        clique.clear();
        self.clique = clique;
        self.weight[p] = 0;
        self.start[p] = start as u32;
        self.length[p] = (self.lists.len() - start) as u32;
        if self.length[p] == 0 {
            size = 0;
            self.mark[p] = 0;
        } else {
            self.mark[p] = 1;
        }
        self.degree[p] = size;
    }

    /// The pivot's clique: its variables and those of its elements, which it absorbs. Returns its weight.
    fn gather_clique(&mut self, pivot: u32) -> u32 {
        let p = pivot as usize;
        let mut size = 0;
        self.weight[p] = -self.weight[p];
        let (start, elements, length) =
            (self.start[p] as usize, self.elements[p] as usize, self.length[p] as usize);
        for k in 0..=elements {
            let (from, to) = if k < elements {
                let e = self.lists[start + k] as usize;
                self.mark[e] = 0;
                (self.start[e] as usize, (self.start[e] + self.length[e]) as usize)
            } else {
                (start + elements, start + length)
            };
            for at in from..to {
                let i = self.lists[at];
                let weight = self.weight[i as usize];
                if weight > 0 {
                    size += weight as u32;
                    self.weight[i as usize] = -weight;
                    self.clique.push(i);
                    self.remove(i);
                }
            }
        }
        size
    }

    /// For every element that meets the clique: how much of it lies outside.
    fn count_outside(&mut self) {
        for &i in &self.clique {
            let v = i as usize;
            let weight = (-self.weight[v]) as u64;
            let start = self.start[v] as usize;
            for at in start..start + self.elements[v] as usize {
                let e = self.lists[at] as usize;
                if self.mark[e] >= self.flag {
                    self.mark[e] -= weight;
                } else if self.mark[e] != 0 {
                    self.mark[e] = u64::from(self.degree[e]) + self.flag - weight;
                }
            }
        }
    }

    /// Prunes the lists of the clique's variables, bounds their degrees, and eliminates those that have nothing left
    /// but the clique together with the pivot. Returns the weight that is left.
    fn update_members(&mut self, pivot: u32, mut size: u32) -> u32 {
        let p = pivot as usize;
        self.hashes.clear();
        for k in 0..self.clique.len() {
            let i = self.clique[k];
            let v = i as usize;
            let start = self.start[v] as usize;
            let (elements_end, end) = (start + self.elements[v] as usize, start + self.length[v] as usize);
            let (mut out, mut degree, mut hash) = (start, 0u64, 0u64);
            for at in start..elements_end {
                let e = self.lists[at];
                let mark = self.mark[e as usize];
                // An element wholly within the clique adds nothing (aggressive absorption).
                if mark > self.flag {
                    degree += mark - self.flag;
                    self.lists[out] = e;
                    hash += u64::from(e);
                    out += 1;
                } else {
                    self.mark[e as usize] = 0;
                }
            }
            let variables = out;
            for at in elements_end..end {
                let j = self.lists[at];
                let weight = self.weight[j as usize];
                if weight > 0 {
                    degree += weight as u64;
                    self.lists[out] = j;
                    hash += u64::from(j);
                    out += 1;
                }
            }
            if degree == 0 {
                let weight = -self.weight[v];
                size -= weight as u32;
                self.eliminated += weight as usize;
                self.weight[v] = 0;
                self.join(pivot, i);
                continue;
            }
            self.degree[v] = self.degree[v].min(degree.min(u64::from(u32::MAX)) as u32);
            // At least one entry went (the pivot, or an element that it absorbed): there is room for the new element.
            self.lists[out] = self.lists[variables];
            self.lists[variables] = self.lists[start];
            self.lists[start] = pivot;
            self.elements[v] = (variables - start + 1) as u32;
            self.length[v] = (out - start + 1) as u32;
            self.hashes.push((hash, i));
        }
        debug_assert!(self.weight[p] < 0);
        size
    }

    /// Variables of the clique with the same neighbours become one.
    fn merge_indistinguishable(&mut self) {
        let mut hashes = std::mem::take(&mut self.hashes);
        hashes.sort_unstable();
        for group in hashes.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() > 1) {
            for (k, &(_, i)) in group.iter().enumerate() {
                if self.weight[i as usize] == 0 || k + 1 == group.len() {
                    continue;
                }
                self.flag += 1;
                for at in self.list_of(i) {
                    self.stamp(at);
                }
                for &(_, j) in &group[k + 1..] {
                    if self.weight[j as usize] != 0 && self.same_list(i, j) {
                        self.weight[i as usize] += self.weight[j as usize];
                        self.weight[j as usize] = 0;
                        self.join(i, j);
                    }
                }
            }
        }
        self.flag += 1;
        self.hashes = hashes;
    }

    fn list_of(&self, v: u32) -> std::ops::Range<usize> {
        let start = self.start[v as usize] as usize;
        // The first entry is the pivot for all.
        start + 1..start + self.length[v as usize] as usize
    }

    fn stamp(&mut self, at: usize) {
        let node = self.lists[at] as usize;
        self.mark[node] = self.flag;
    }

    fn same_list(&self, i: u32, j: u32) -> bool {
        self.length[i as usize] == self.length[j as usize]
            && self.elements[i as usize] == self.elements[j as usize]
            && self.list_of(j).all(|at| self.mark[self.lists[at] as usize] == self.flag)
    }

    /// `other` is eliminated together with `node`.
    fn join(&mut self, node: u32, other: u32) {
        self.next_member[self.last_member[node as usize] as usize] = other;
        self.last_member[node as usize] = self.last_member[other as usize];
    }
}
