//! Scratch folders, the shared data where they are, and seeded random maps.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

use hitl_slam::geometry::{Information, Pose2, Segment, Vec2};
use hitl_slam::map::{
    Feature, HumanFactor, Mode, Observations, RelativeFactor, ScanRecord, Sighting, SlamMap,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// An empty folder that is removed at the end of the test.
pub struct Scratch(PathBuf);

impl Scratch {
    pub fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("hitl-slam-test-{}-{test}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Scratch(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// A file with this content.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A file of the shared data, which stand beside the project and not in it.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if !path.exists() {
        println!("skipped: ../shared is absent");
        return None;
    }
    Some(path)
}

/// The message of a failed read, with the folder taken out: `file:line: …`.
pub fn message<T>(result: hitl_slam::error::Result<T>) -> String {
    match result {
        Ok(_) => panic!("read without an error"),
        Err(error) => {
            let text = error.to_string();
            assert!(matches!(error, hitl_slam::error::Error::Input { .. }), "not an input error: {text}");
            assert!(!text.contains('\n'), "more than one line: {text}");
            text.rsplit_once('/').map_or(text.clone(), |(_, rest)| rest.to_string())
        }
    }
}

/// Seeded random numbers.
pub struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Dice(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal with mean 0.
    pub fn normal(&mut self, sigma: f64) -> f64 {
        let (u, v) = (self.between(f64::MIN_POSITIVE, 1.0), self.between(0.0, 1.0));
        sigma * (-2.0 * u.ln()).sqrt() * (2.0 * PI * v).cos()
    }

    /// Headings near ±π one time in two.
    pub fn pose(&mut self) -> Pose2 {
        let theta_rad = match self.0.next_u64() % 4 {
            0 => PI - self.between(0.0, 1e-9),
            1 => -PI + self.between(1e-12, 1e-9),
            _ => self.between(-PI, PI),
        };
        Pose2::new(self.between(-30.0, 30.0), self.between(-10.0, 10.0), theta_rad)
    }

    /// Not diagonal: U'U of a random upper triangle.
    pub fn information(&mut self) -> Information {
        let mut u = nalgebra::Matrix3::zeros();
        for (r, c) in [(0, 1), (0, 2), (1, 2)] {
            u[(r, c)] = self.between(-20.0, 20.0);
        }
        for d in 0..3 {
            u[(d, d)] = self.between(1.0, 90.0);
        }
        Information::new(u.transpose() * u).unwrap()
    }

    /// A map with everything a map can hold.
    pub fn map(&mut self, poses: usize) -> SlamMap {
        let mut observations = Observations { starts: vec![0], ..Observations::default() };
        for _ in 0..poses {
            for _ in 0..10 {
                let angle = self.between(-PI, PI);
                let normal = if angle > 2.0 { Vec2::zeros() } else { Vec2::new(angle.cos(), angle.sin()) };
                let range_m = self.between(0.1, 30.0);
                observations.push(
                    Vec2::new(self.between(-30.0, 30.0), self.between(-30.0, 30.0)),
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
            robot_from_laser: self.pose(),
            poses: chain,
        }
    }

    fn human_factor(&mut self, mode: Mode, poses: usize) -> HumanFactor {
        let mut feature = |pose: usize| Feature {
            segment: Segment {
                centre: Vec2::new(self.between(-9.0, 9.0), self.between(-9.0, 9.0)),
                direction_rad: self.between(-PI, PI),
                half_length_m: self.between(0.1, 4.0),
            },
            points: vec![pose as u32 * 10 + 1, pose as u32 * 10 + 4, pose as u32 * 10 + 12],
            sightings: [pose, pose + 1]
                .map(|pose| Sighting {
                    tied: self.between(0.0, 1.0) < 0.5,
                    pose,
                    along_m: self.between(-3.0, 3.0),
                    bearing_rad: self.between(-PI, PI),
                })
                .to_vec(),
        };
        let (a, b) = (feature(0), feature(poses - 2));
        HumanFactor {
            id: format!("wall “{}”, 'c'", mode.name()), mode, weight: self.between(0.1, 9.0), a, b
        }
    }
}

/// A small FLASER log in which the robot drives straight ahead, 0.1 m and 0.1 s a scan.
pub fn small_log(scans: usize) -> String {
    let mut text = String::from("# a comment\nPARAM robot_frontlaser_offset 0.2 nohost 0\n");
    for k in 0..scans {
        let ranges: String = (0..181).map(|b| format!(" {:.2}", 2.0 + 0.01 * f64::from(b))).collect();
        let (x, t) = (k as f64 / 10.0, 100.0 + k as f64 / 10.0);
        text += &format!("ODOM {x} 0 0 0 0 0 {t} nohost {t}\n");
        text += &format!("FLASER 181{ranges} {} 0 0 {x} 0 0 {t} nohost {t}\n", x + 0.2);
    }
    text
}
