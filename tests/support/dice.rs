//! Seeded random numbers.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};

/// A generator of numbers.
pub struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Dice(ChaCha8Rng::seed_from_u64(seed))
    }

    /// In low..high.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).unwrap().sample(&mut self.0)
    }

    /// Standard normal times sigma.
    pub fn normal(&mut self, sigma: f64) -> f64 {
        let z: f64 = StandardNormal.sample(&mut self.0);
        sigma * z
    }

    /// In 0..n.
    pub fn index(&mut self, n: usize) -> usize {
        Uniform::new(0, n).unwrap().sample(&mut self.0)
    }

    /// A heading: every second one within 1e-6 rad of ±π.
    pub fn heading(&mut self) -> f64 {
        match self.index(4) {
            0 => PI - self.uniform(0.0, 1e-6),
            1 => -PI + self.uniform(1e-12, 1e-6),
            _ => self.uniform(-PI, PI),
        }
    }

    pub fn point(&mut self, reach: f64) -> [f64; 2] {
        [self.uniform(-reach, reach), self.uniform(-reach, reach)]
    }
}
