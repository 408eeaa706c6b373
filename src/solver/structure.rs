//! What a block factor L looks like, found once per pattern: order, elimination tree, supernodes, where everything lies.

use super::ordering::{Graph, minimum_degree};

/// What eliminating the nodes of a graph in some order makes of it.
pub(super) struct Analysis {
    /// Node of every column: the order given, rearranged so that children directly precede their parents.
    pub order: Vec<u32>,
    /// Column of every node.
    pub column_of: Vec<u32>,
    /// Where the rows of each column start in `rows`.
    pub starts: Vec<usize>,
    /// Rows (as columns) below the diagonal, not sorted.
    pub rows: Vec<u32>,
    /// Columns of every supernode, from and to.
    pub groups: Vec<(usize, usize)>,
}

/// Eliminates in this order; nodes that are `alone` make supernodes of their own.
pub(super) fn analyse(graph: &Graph, order: &[u32], alone: impl Fn(u32) -> bool) -> Analysis {
    let n = order.len();
    let mut column_of = inverse(order);
    let parents = elimination_tree(graph, order, &column_of);
    let post = postorder(&parents);
    // In postorder a parent follows its last child, and the tree stays the same.
    let rank = inverse(&post);
    let order: Vec<u32> = post.iter().map(|&c| order[c as usize]).collect();
    for column in &mut column_of {
        *column = rank[*column as usize];
    }
    let relabel =
        |c: u32| if parents[c as usize] == NONE { NONE } else { rank[parents[c as usize] as usize] };
    let parents: Vec<u32> = post.iter().map(|&c| relabel(c)).collect();
    let (starts, rows) = column_rows(graph, &order, &column_of, &parents);
    let groups = merge(n, &parents, |c| starts[c + 1] - starts[c], |c| alone(order[c]));
    Analysis { order, column_of, starts, rows, groups }
}

/// A supernode: block columns of L with (nearly) the same rows, stored as one dense panel, column-major. Its rows are
/// the columns' own (padded to a multiple of four) and then those below (padded too); padding is zero for ever.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Supernode {
    /// First block column.
    pub first: usize,
    /// Number of block columns.
    pub columns: usize,
    /// Its block rows below: a range of [`Structure::rows`] and [`Structure::places`].
    pub rows: (usize, usize),
    /// Padded number of scalar rows of the columns themselves.
    pub own: usize,
    /// Padded number of scalar rows below; also the order of its update matrix.
    pub below: usize,
    /// Where its panel starts.
    pub panel: usize,
    /// Where its update matrix is computed, and where it is kept.
    pub update: (usize, usize),
    /// The supernode that its update matrix goes to; `NONE` at a root.
    pub parent: u32,
    /// Its children: a range of [`Structure::children`].
    pub children: (usize, usize),
}

impl Supernode {
    /// Leading dimension of the panel.
    pub fn stride(&self) -> usize {
        self.own + self.below
    }
}

pub(super) const NONE: u32 = u32::MAX;

/// Symbolic factorisation.
#[derive(Debug, Clone, Default)]
pub(super) struct Structure {
    /// Block column of every unknown.
    pub column_of: Vec<u32>,
    /// In elimination order, children before parents.
    pub supernodes: Vec<Supernode>,
    /// Block rows below every supernode, ascending.
    pub rows: Vec<u32>,
    /// Where each of those rows lies in the parent: scalar row of its panel if below `own`, else of its update matrix
    /// plus `own`.
    pub places: Vec<u32>,
    /// Children of all supernodes in turn.
    pub children: Vec<u32>,
    /// Supernode of every block column.
    pub supernode_of: Vec<u32>,
    /// Scalars in all panels.
    pub panel_len: usize,
    /// Scalars in all update matrices that live at the same time.
    pub update_len: usize,
}

/// Merging costs zeros and saves overhead: up to so many columns with at most this share of zeros. Four block columns are
/// twelve scalar ones: no row of theirs is padding.
const MERGE: [(usize, f64); 3] = [(4, 0.6), (8, 0.25), (usize::MAX, 0.08)];

impl Structure {
    /// Of the graph of the unknowns.
    pub fn new(graph: &Graph) -> Self {
        Self::with_order(graph, &minimum_degree(graph))
    }

    /// For a given elimination order (a permutation of the unknowns).
    pub fn with_order(graph: &Graph, order: &[u32]) -> Self {
        let Analysis { column_of, starts, rows, groups, .. } = analyse(graph, order, |_| false);
        let supernode_of = vec![0; order.len()];
        let mut structure = Structure { column_of, supernode_of, ..Default::default() };
        for (first, end) in groups {
            let s = structure.supernodes.len() as u32;
            structure.supernode_of[first..end].fill(s);
            let below = &rows[starts[end - 1]..starts[end]];
            let from = structure.rows.len();
            structure.rows.extend_from_slice(below);
            structure.rows[from..].sort_unstable();
            let columns = end - first;
            let own = pad(3 * columns);
            let below = pad(3 * below.len());
            structure.supernodes.push(Supernode {
                first,
                columns,
                rows: (from, structure.rows.len()),
                own,
                below,
                panel: structure.panel_len,
                parent: NONE,
                ..Default::default()
            });
            structure.panel_len += (own + below) * 3 * columns;
        }
        structure.link();
        structure.place_updates();
        structure
    }

    /// Parents, children, and where rows lie in their parents.
    fn link(&mut self) {
        let mut counts = vec![0usize; self.supernodes.len() + 1];
        for s in 0..self.supernodes.len() {
            let (from, to) = self.supernodes[s].rows;
            if from < to {
                let parent = self.supernode_of[self.rows[from] as usize];
                self.supernodes[s].parent = parent;
                counts[parent as usize + 1] += 1;
            }
        }
        for k in 1..counts.len() {
            counts[k] += counts[k - 1];
        }
        self.children = vec![0; counts[self.supernodes.len()]];
        self.places = vec![0; self.rows.len()];
        for (s, supernode) in self.supernodes.iter_mut().enumerate() {
            supernode.children = (counts[s], counts[s]);
        }
        for s in 0..self.supernodes.len() {
            let Supernode { parent, rows: (from, to), .. } = self.supernodes[s];
            if parent == NONE {
                continue;
            }
            let above = &mut self.supernodes[parent as usize];
            self.children[above.children.1] = s as u32;
            above.children.1 += 1;
            let above = *above;
            let mut at = above.rows.0;
            for k in from..to {
                let row = self.rows[k];
                self.places[k] = if (row as usize) < above.first + above.columns {
                    3 * (row - above.first as u32)
                } else {
                    while self.rows[at] < row {
                        at += 1;
                    }
                    (above.own + 3 * (at - above.rows.0)) as u32
                };
            }
        }
    }

    /// On a stack, each gone once its parent has it.
    fn place_updates(&mut self) {
        let (mut top, mut highest) = (0, 0);
        for s in 0..self.supernodes.len() {
            let Supernode { below, children, .. } = self.supernodes[s];
            let work = top;
            highest = highest.max(top + below * below);
            if children.0 < children.1 {
                top = self.supernodes[self.children[children.0] as usize].update.1;
            }
            self.supernodes[s].update = (work, top);
            top += below * below;
            highest = highest.max(top);
        }
        self.update_len = highest;
    }
}

impl Structure {
    /// Each in a place of its own, for good.
    pub fn place_updates_apart(&mut self) {
        self.update_len = 0;
        for node in &mut self.supernodes {
            node.update = (self.update_len, self.update_len);
            self.update_len += node.below * node.below;
        }
    }
}

fn pad(n: usize) -> usize {
    n.next_multiple_of(4)
}

fn inverse(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    for (k, &v) in order.iter().enumerate() {
        inverse[v as usize] = k as u32;
    }
    inverse
}

/// Parent of every column (Liu's algorithm, with path compression).
fn elimination_tree(graph: &Graph, order: &[u32], column_of: &[u32]) -> Vec<u32> {
    let mut parents = vec![NONE; order.len()];
    let mut ancestors = vec![NONE; order.len()];
    for (j, &node) in order.iter().enumerate() {
        let j = j as u32;
        for &neighbour in graph.of(node) {
            let mut i = column_of[neighbour as usize];
            while i < j {
                let next = std::mem::replace(&mut ancestors[i as usize], j);
                if next == NONE {
                    parents[i as usize] = j;
                    break;
                }
                i = next;
            }
        }
    }
    parents
}

/// Columns in postorder, the child with the largest subtree last: it can then be one supernode with its parent.
fn postorder(parents: &[u32]) -> Vec<u32> {
    let n = parents.len();
    let mut sizes = vec![1u32; n];
    for c in 0..n {
        if parents[c] != NONE {
            sizes[parents[c] as usize] += sizes[c];
        }
    }
    // Children as linked lists, pushed to the front: largest first, so that it is visited last from the stack's view.
    let (mut first, mut next) = (vec![NONE; n], vec![NONE; n]);
    let mut largest = vec![NONE; n];
    for c in (0..n).rev() {
        let p = parents[c] as usize;
        if parents[c] == NONE {
            continue;
        }
        if largest[p] == NONE || sizes[c] > sizes[largest[p] as usize] {
            largest[p] = c as u32;
        }
        next[c] = first[p];
        first[p] = c as u32;
    }
    let mut order = Vec::with_capacity(n);
    let mut stack = Vec::new();
    // A column is written when it is met, parents before children, and the whole is turned round: so its largest child
    // must be met first, directly after it.
    for root in (0..n).rev().filter(|&c| parents[c] == NONE) {
        stack.push(root as u32);
        while let Some(c) = stack.pop() {
            order.push(c);
            let heavy = largest[c as usize];
            let mut child = first[c as usize];
            while child != NONE {
                if child != heavy {
                    stack.push(child);
                }
                child = next[child as usize];
            }
            if heavy != NONE {
                stack.push(heavy);
            }
        }
    }
    order.reverse();
    order
}

/// Rows below the diagonal of every column of L, not sorted: compressed.
fn column_rows(graph: &Graph, order: &[u32], column_of: &[u32], parents: &[u32]) -> (Vec<usize>, Vec<u32>) {
    let n = order.len();
    let (mut first, mut next) = (vec![NONE; n], vec![NONE; n]);
    for c in (0..n).rev() {
        if parents[c] != NONE {
            next[c] = first[parents[c] as usize];
            first[parents[c] as usize] = c as u32;
        }
    }
    let mut marks = vec![NONE; n];
    let mut starts = Vec::with_capacity(n + 1);
    let mut rows = Vec::with_capacity(2 * graph.neighbours.len());
    starts.push(0);
    for j in 0..n as u32 {
        marks[j as usize] = j;
        for &neighbour in graph.of(order[j as usize]) {
            let row = column_of[neighbour as usize];
            if row > j {
                marks[row as usize] = j;
                rows.push(row);
            }
        }
        let mut child = first[j as usize];
        while child != NONE {
            let c = child as usize;
            for k in starts[c]..starts[c + 1] {
                let row: u32 = rows[k];
                if marks[row as usize] != j {
                    marks[row as usize] = j;
                    rows.push(row);
                }
            }
            child = next[c];
        }
        starts.push(rows.len());
    }
    (starts, rows)
}

/// A group of columns on its way to become a supernode.
struct Group {
    first: usize,
    end: usize,
    /// Block rows of the panel, its own columns included.
    height: usize,
    zeros: f64,
}

impl Group {
    fn entries(&self) -> f64 {
        entries(self.end - self.first, self.height)
    }
}

/// Blocks in the lower trapezium of a panel.
fn entries(columns: usize, height: usize) -> f64 {
    (columns * height) as f64 - (columns * (columns - 1) / 2) as f64
}

/// Fundamental supernodes, then parents merged with their last child where that is worth its zeros.
fn merge(
    n: usize,
    parents: &[u32],
    count: impl Fn(usize) -> usize,
    alone: impl Fn(usize) -> bool,
) -> Vec<(usize, usize)> {
    let mut groups: Vec<Group> = Vec::new();
    let mut j = 0;
    while j < n {
        let first = j;
        while j + 1 < n && parents[j] as usize == j + 1 && count(j) == count(j + 1) + 1 && !alone(j) {
            j += 1;
        }
        j += 1;
        let mut group = Group { first, end: j, height: j - first + count(j - 1), zeros: 0.0 };
        while let Some(last) = groups.last() {
            let parent = parents[last.end - 1] as usize;
            if !(group.first..group.end).contains(&parent) || alone(last.first) {
                break;
            }
            let columns = group.end - last.first;
            let height = last.end - last.first + group.height;
            let all = entries(columns, height);
            let zeros = last.zeros + group.zeros + all - last.entries() - group.entries();
            if !MERGE.iter().any(|&(most, share)| columns <= most && zeros <= share * all) {
                break;
            }
            group = Group { first: last.first, end: group.end, height, zeros };
            groups.pop();
        }
        groups.push(group);
    }
    groups.into_iter().map(|g| (g.first, g.end)).collect()
}
