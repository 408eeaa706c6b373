//! Seeded random test input.

use std::f64::consts::PI;

use hitl_slam::geometry::{Information, Pose2};
use nalgebra::Matrix3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A seeded source of random input.
pub struct Random(ChaCha8Rng);

impl Random {
    /// The same numbers for the same seed.
    pub fn new(seed: u64) -> Self {
        Random(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in low..high.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Normal with mean 0.
    pub fn normal(&mut self, sigma: f64) -> f64 {
        let (u, v) = (self.uniform(f64::MIN_POSITIVE, 1.0), self.uniform(0.0, 1.0));
        sigma * (-2.0 * u.ln()).sqrt() * (2.0 * PI * v).cos()
    }

    /// Within ±20 m; one heading in three lies within 1e-6 of ±π.
    pub fn pose(&mut self) -> Pose2 {
        let theta = match self.uniform(0.0, 3.0) as u32 {
            0 => PI + self.uniform(-1e-6, 1e-6),
            _ => self.uniform(-PI, PI),
        };
        Pose2::new(self.uniform(-20.0, 20.0), self.uniform(-20.0, 20.0), theta)
    }

    /// Never diagonal.
    pub fn information(&mut self) -> Information {
        let a = Matrix3::from_fn(|_, _| self.uniform(-1.0, 1.0));
        let scale = Matrix3::from_diagonal(&nalgebra::Vector3::new(20.0, 30.0, 80.0));
        let matrix = scale * (a * a.transpose() + Matrix3::identity() * 0.3) * scale;
        Information::new(matrix).expect("positive definite by construction")
    }
}
