//! Scratch folders and the shared data where they are.

use std::fs;
use std::path::{Path, PathBuf};

use hitl_slam::map::SlamMap;

use super::both_backends::skipped;

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
        skipped("../shared is absent");
        return None;
    }
    Some(path)
}

/// A public pose graph, if the shared data are there (they cannot be shipped).
pub fn public_graph(name: &str) -> Option<SlamMap> {
    let path = shared(&format!("g2o_2d/{name}.g2o.xz"))?;
    Some(hitl_slam::io::g2o::read(&path).expect("a graph").value)
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
