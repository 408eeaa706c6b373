//! Who descends from whom: positions of all particles after each step, and the way back from the last ones.
//!
//! One layer per step. Lines that died out are pruned now and then, so that long walks with revisits need little
//! more than the surviving lines (Jacob, Murray & Rubenthaler 2015).

/// Prune when this many positions are held, and again whenever their number has doubled since: often and a little, for whoever
/// waits for the step in which it happens.
const PRUNE_AT: usize = 1 << 19;

#[derive(Debug, Clone, Default)]
struct Layer {
    positions: Vec<[f32; 2]>,
    /// Index of each particle's parent in the layer before; empty: the same index.
    parents: Vec<u32>,
}

/// The positions of all ancestors.
#[derive(Debug, Clone, Default)]
pub struct Genealogy {
    layers: Vec<Layer>,
    held: usize,
    prune_at: usize,
}

impl Genealogy {
    /// Adds the positions after a step; `parents` are indices into the positions added before, empty where particle i
    /// comes from particle i.
    pub fn push(&mut self, positions: Vec<[f32; 2]>, parents: Vec<u32>) {
        self.held += positions.len();
        self.layers.push(Layer { positions, parents });
        if self.held > self.prune_at.max(PRUNE_AT) {
            self.prune();
            self.prune_at = 2 * self.held;
        }
    }

    /// The positions of the ancestors of particle `last`, from the start on.
    pub fn path(&self, last: usize) -> Vec<[f32; 2]> {
        let mut path = Vec::with_capacity(self.layers.len());
        let mut at = last;
        for layer in self.layers.iter().rev() {
            path.push(layer.positions[at]);
            at = layer.parents.get(at).map_or(at, |&p| p as usize);
        }
        path.reverse();
        path
    }

    /// Number of layers: the start and one per step.
    pub fn len(&self) -> usize {
        self.layers.len()
    }

    /// Where a particle was after a step, and its parent's index in the layer before.
    pub fn look(&self, layer: usize, particle: usize) -> ([f32; 2], usize) {
        let layer = &self.layers[layer];
        (layer.positions[particle], layer.parents.get(particle).map_or(particle, |&p| p as usize))
    }

    /// From the last layer back: who has no child is forgotten. Parents ascend as their children do (systematic resampling
    /// keeps the order), so one pass over the children finds them, however many there were.
    fn prune(&mut self) {
        for k in (1..self.layers.len()).rev() {
            let (before, rest) = self.layers.split_at_mut(k);
            let (parent_layer, layer) = (&mut before[k - 1], &mut rest[0]);
            let (count, whole) = (layer.positions.len(), parent_layer.positions.len());
            if layer.parents.is_empty() && count == whole {
                continue;
            }
            if layer.parents.is_empty() {
                layer.parents = (0..count as u32).collect();
            }
            let (mut kept, mut last) = (0, None);
            // A layer whose parents were "the same index" keeps that meaning only while it is whole.
            let was_same = parent_layer.parents.is_empty();
            for parent in &mut layer.parents {
                let old = *parent as usize;
                if last != Some(old) {
                    last = Some(old);
                    parent_layer.positions[kept] = parent_layer.positions[old];
                    if was_same {
                        parent_layer.parents.push(old as u32);
                    } else {
                        parent_layer.parents[kept] = parent_layer.parents[old];
                    }
                    kept += 1;
                }
                *parent = kept as u32 - 1;
            }
            parent_layer.positions.truncate(kept);
            parent_layer.positions.shrink_to_fit();
            parent_layer.parents.truncate(if was_same && kept == whole { 0 } else { kept });
            parent_layer.parents.shrink_to_fit();
        }
        self.held = self.layers.iter().map(|l| l.positions.len()).sum();
    }
}
