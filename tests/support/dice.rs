//! Seeded random numbers, poses, maps.

use std::f64::consts::PI;

use hitl_slam::geometry::{Information, Pose2, Segment, Vec2};
use hitl_slam::map::{
    AutomaticFactor, Feature, HumanFactor, Mode, Observations, RelativeFactor, ScanRecord, Sighting, SlamMap,
};
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

    /// Headings near ±π one time in two.
    pub fn pose(&mut self) -> Pose2 {
        let theta_rad = self.heading();
        Pose2::new(self.uniform(-30.0, 30.0), self.uniform(-10.0, 10.0), theta_rad)
    }

    /// Not diagonal: U'U of a random upper triangle.
    pub fn information(&mut self) -> Information {
        let mut u = nalgebra::Matrix3::zeros();
        for (r, c) in [(0, 1), (0, 2), (1, 2)] {
            u[(r, c)] = self.uniform(-20.0, 20.0);
        }
        for d in 0..3 {
            u[(d, d)] = self.uniform(1.0, 90.0);
        }
        Information::new(u.transpose() * u).unwrap()
    }

    /// A map with everything a map can hold.
    pub fn map(&mut self, poses: usize) -> SlamMap {
        let mut observations = Observations { starts: vec![0], ..Observations::default() };
        for _ in 0..poses {
            for _ in 0..10 {
                let angle = self.uniform(-PI, PI);
                let normal = if angle > 2.0 { Vec2::zeros() } else { Vec2::new(angle.cos(), angle.sin()) };
                let range_m = self.uniform(0.1, 30.0);
                observations.push(
                    Vec2::new(self.uniform(-30.0, 30.0), self.uniform(-30.0, 30.0)),
                    normal,
                    range_m,
                );
            }
            observations.end_pose();
        }
        let chain: Vec<Pose2> = (0..poses).map(|_| self.pose()).collect();
        let mut factors: Vec<RelativeFactor> = Vec::new();
        for i in 1..poses {
            let factor = |i, j, i_from_j, information| RelativeFactor { i, j, i_from_j, information };
            factors.push(factor(i - 1, i, self.pose(), self.information()));
            if i % 3 == 0 {
                factors.push(factor(i, 0, self.pose(), self.information()));
            }
        }
        let scan = |k: usize, dice: &mut Dice| ScanRecord {
            stamp_s: 976052857.337530 + k as f64 * 0.1,
            parent: k / 2,
            parent_from_robot: dice.pose(),
        };
        SlamMap {
            stamps_s: Some((0..poses).map(|i| 976052857.1 + i as f64 * 0.2).collect()),
            vertex_ids: Some((0..poses).map(|i| i as i64 * 7 - 3).collect()),
            held: vec![0, poses / 2],
            relative_factors: factors,
            observations,
            scans: (0..2 * poses).map(|k| scan(k, self)).collect(),
            human_factors: Mode::ALL.iter().map(|&mode| self.human_factor(mode, poses)).collect(),
            automatic_factors: (0..poses / 2).map(|k| self.automatic_factor(k, poses)).collect(),
            robot_from_laser: self.pose(),
            poses: chain,
        }
    }

    fn automatic_factor(&mut self, k: usize, poses: usize) -> AutomaticFactor {
        let factor =
            RelativeFactor { i: k, j: poses - 1 - k, i_from_j: self.pose(), information: self.information() };
        AutomaticFactor {
            factor,
            inliers: self.uniform(0.5, 1.0),
            ambiguity: self.uniform(0.0, 1.0),
            weak_rad: k.is_multiple_of(2).then(|| self.uniform(-1.5, 1.5)),
            chi2: self.uniform(0.0, 30.0),
        }
    }

    fn human_factor(&mut self, mode: Mode, poses: usize) -> HumanFactor {
        let mut feature = |pose: usize| Feature {
            segment: Segment {
                centre: Vec2::new(self.uniform(-9.0, 9.0), self.uniform(-9.0, 9.0)),
                direction_rad: self.uniform(-PI, PI),
                half_length_m: self.uniform(0.1, 4.0),
            },
            points: vec![pose as u32 * 10 + 1, pose as u32 * 10 + 4, pose as u32 * 10 + 12],
            sightings: [pose, pose + 1]
                .map(|pose| Sighting {
                    tied: self.uniform(0.0, 1.0) < 0.5,
                    pose,
                    along_m: self.uniform(-3.0, 3.0),
                    bearing_rad: self.uniform(-PI, PI),
                })
                .to_vec(),
        };
        let (a, b) = (feature(0), feature(poses - 2));
        HumanFactor {
            id: format!("wall “{}”, 'c'", mode.name()), mode, weight: self.uniform(0.1, 9.0), a, b
        }
    }
}
