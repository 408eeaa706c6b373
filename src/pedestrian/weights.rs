//! Sums over weighted particles in a fixed order, and systematic resampling.

/// Particles are handled in blocks of this many; sums are taken per block, then over the blocks in order. So
/// results do not depend on the number of threads.
pub const BLOCK: usize = 1024;
const LANES: usize = 8;

/// Weighted sums over particles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums {
    /// Σ w
    pub weight: f64,
    /// Σ w²
    pub weight_squared: f64,
    /// Σ w x, Σ w y; grid frame, metres.
    pub position: [f64; 2],
    /// Σ w (x² + y²)
    pub distance_squared: f64,
    /// Σ w sin φ, Σ w cos φ
    pub direction: [f64; 2],
}

impl Sums {
    /// The sums of one block.
    pub fn of_block(weights: &[f32], positions: &[[f32; 2]], directions: &[[f32; 2]]) -> Sums {
        let mut lanes = [[0.0_f64; LANES]; 7];
        for ((w, p), d) in weights.chunks(LANES).zip(positions.chunks(LANES)).zip(directions.chunks(LANES)) {
            for (k, ((&w, p), d)) in w.iter().zip(p).zip(d).enumerate() {
                let (w, x, y) = (f64::from(w), f64::from(p[0]), f64::from(p[1]));
                lanes[0][k] += w;
                lanes[1][k] += w * w;
                lanes[2][k] += w * x;
                lanes[3][k] += w * y;
                lanes[4][k] += w * (x * x + y * y);
                lanes[5][k] += w * f64::from(d[0]);
                lanes[6][k] += w * f64::from(d[1]);
            }
        }
        let [weight, weight_squared, x, y, distance_squared, sin, cos] =
            lanes.map(|lane| lane.iter().sum::<f64>());
        Sums { weight, weight_squared, position: [x, y], distance_squared, direction: [sin, cos] }
    }

    /// Adds the sums of the next block.
    pub fn add(&mut self, other: &Sums) {
        self.weight += other.weight;
        self.weight_squared += other.weight_squared;
        self.distance_squared += other.distance_squared;
        for k in 0..2 {
            self.position[k] += other.position[k];
            self.direction[k] += other.direction[k];
        }
    }

    /// Effective number of particles, (Σw)² / Σw².
    pub fn effective(&self) -> f64 {
        self.weight * self.weight / self.weight_squared
    }

    /// Weighted mean position, grid frame.
    pub fn mean(&self) -> [f64; 2] {
        self.position.map(|p| p / self.weight)
    }

    /// Standard deviation of the position per axis, metres.
    pub fn sigma(&self) -> f64 {
        let [x, y] = self.mean();
        ((self.distance_squared / self.weight - x * x - y * y) / 2.0).max(0.0).sqrt()
    }

    /// Weighted circular mean of the heading offset.
    pub fn heading_offset_rad(&self) -> f64 {
        self.direction[0].atan2(self.direction[1])
    }
}

/// Systematic resampling: the parents of `count` equally weighted children; `offset` in [0, 1) is the only chance in it.
/// A particle of weight w gets ⌊count·w/Σw⌋ children or one more.
pub fn systematic(weights: impl Iterator<Item = f32>, sum: f64, count: usize, offset: f64) -> Vec<u32> {
    let mut parents = Vec::with_capacity(count);
    let (mut reached, mut last) = (0.0, 0);
    for (i, weight) in weights.enumerate() {
        reached += f64::from(weight) * (count as f64 / sum);
        if weight > 0.0 {
            last = i as u32;
        }
        while parents.len() < count && (parents.len() as f64 + offset) < reached {
            parents.push(i as u32);
        }
    }
    // Rounding may leave the last child without a parent.
    parents.resize(count, last);
    parents
}
