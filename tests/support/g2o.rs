//! A minimal g2o reader for tests: vertices and edges of 2D graphs, xz-compressed; anything else is skipped.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use hitl_slam::geometry::{Information, Pose2};
use hitl_slam::map::{Observations, RelativeFactor, SlamMap};
use nalgebra::Matrix3;

/// The folder of public 2D graphs beside the working copy, if it is there (they cannot be shipped).
pub fn folder() -> Option<PathBuf> {
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().skip(1);
    above.map(|folder| folder.join("shared/data/g2o_2d")).find(|folder| folder.is_dir())
}

/// A graph with vertices 0..n−1 in order.
pub fn read(path: &Path) -> SlamMap {
    let reader = BufReader::new(lzma_rust2::XzReader::new(BufReader::new(File::open(path).unwrap()), true));
    let mut map = SlamMap::default();
    for line in reader.lines() {
        let line = line.unwrap();
        let mut words = line.split_whitespace();
        let tag = words.next();
        let v: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
        match tag {
            Some("VERTEX_SE2") => map.poses.push(Pose2::new(v[1], v[2], v[3])),
            Some("EDGE_SE2") => map.relative_factors.push(RelativeFactor {
                i: v[0] as usize,
                j: v[1] as usize,
                i_from_j: Pose2::new(v[2], v[3], v[4]),
                information: Information::new(Matrix3::new(
                    v[5], v[6], v[7], v[6], v[8], v[9], v[7], v[9], v[10],
                ))
                .unwrap(),
            }),
            _ => {}
        }
    }
    map.observations = Observations::empty(map.poses.len());
    map
}
