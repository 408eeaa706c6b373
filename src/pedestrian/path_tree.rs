//! Paths drawn from a posterior, as the tree that they are: what several of them share is held, and drawn, once.
//!
//! Particles that survive have few ancestors, so hundreds of paths cost little more than one.

use super::transition_map::TransitionMap;
use crate::geometry::Vec2;

/// A position that `paths` of the paths went through.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    position: Vec2,
    /// Index in the layer before.
    parent: u32,
    paths: u32,
}

/// Equally weighted paths of the same length, world frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PathTree {
    /// One layer per step, the start first; children of one parent stand side by side.
    layers: Vec<Vec<Node>>,
}

impl PathTree {
    /// No paths.
    pub fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    /// Number of paths.
    pub fn len(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.iter().map(|n| n.paths as usize).sum())
    }

    /// Builds the tree from its leaves: the ascending particles drawn at the end, then for every step from the last one
    /// backwards each particle's position and its parent's index.
    pub(super) fn grow(
        drawn: &[u32],
        layers: usize,
        look: impl Fn(usize, usize) -> (Vec2, usize),
    ) -> PathTree {
        let mut at: Vec<(u32, u32)> = Vec::new();
        for &particle in drawn {
            match at.last_mut() {
                Some((same, paths)) if *same == particle => *paths += 1,
                _ => at.push((particle, 1)),
            }
        }
        let mut tree = PathTree { layers: vec![Vec::new(); layers] };
        for layer in (0..layers).rev() {
            // Systematic resampling keeps the order, so parents ascend as their children do.
            let mut parents: Vec<(u32, u32)> = Vec::new();
            tree.layers[layer].reserve_exact(at.len());
            for &(particle, paths) in &at {
                let (position, parent) = look(layer, particle as usize);
                match parents.last_mut() {
                    Some((same, all)) if *same as usize == parent => *all += paths,
                    _ => parents.push((parent as u32, paths)),
                }
                let parent = parents.len() as u32 - 1;
                tree.layers[layer].push(Node { position, parent, paths });
            }
            at = parents;
        }
        tree
    }

    /// Every path, the start first.
    pub fn paths(&self) -> Vec<Vec<Vec2>> {
        let Some(last) = self.layers.last() else { return Vec::new() };
        let leaves = last.iter().enumerate().flat_map(|(i, n)| std::iter::repeat_n(i, n.paths as usize));
        let back = |leaf: usize| {
            let mut at = leaf;
            let mut path: Vec<Vec2> = Vec::with_capacity(self.layers.len());
            for layer in self.layers.iter().rev() {
                path.push(layer[at].position);
                at = layer[at].parent as usize;
            }
            path.reverse();
            path
        };
        leaves.map(back).collect()
    }

    /// Adds the crossings of all paths, together as much as one walk: the same as path by path.
    pub fn add_to(&self, map: &mut TransitionMap) {
        let (grid, fixed) = (map.grid, TransitionMap::fixed(1.0 / self.len().max(1) as f64));
        let shape = grid.shape();
        let enter = |n: &Node| {
            let p = grid.to_grid(n.position);
            shape.enter([p.x as f32, p.y as f32])
        };
        let Some(first) = self.layers.first() else { return };
        let mut places: Vec<_> = first.iter().map(enter).collect();
        for pair in self.layers.windows(2) {
            let go = |node: &Node| {
                let (cell, offset) = places[node.parent as usize];
                let d = grid.to_grid(node.position) - grid.to_grid(pair[0][node.parent as usize].position);
                let limit = (4.0 * d.norm() / grid.radius_m) as usize + 4;
                shape.walk(cell, offset, [d.x as f32, d.y as f32], limit, |cell, edge| {
                    map.add(cell, edge, fixed * u64::from(node.paths));
                })
            };
            places = pair[1].iter().map(go).collect();
        }
    }

    /// Puts a path before the first layer: all paths come from there.
    pub(super) fn put_before(&mut self, path: &[Vec2]) {
        let paths = self.len() as u32;
        if paths > 0 && !path.is_empty() {
            self.layers[0].iter_mut().for_each(|n| n.parent = 0);
            let stem = path.iter().map(|&position| vec![Node { position, parent: 0, paths }]);
            self.layers.splice(0..0, stem);
        }
    }
}

impl From<&[Vec2]> for PathTree {
    /// One path.
    fn from(path: &[Vec2]) -> Self {
        let layer = |&position: &Vec2| vec![Node { position, parent: 0, paths: 1 }];
        PathTree { layers: path.iter().map(layer).collect() }
    }
}
