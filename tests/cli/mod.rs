mod batch;
mod commands;
mod crosscheck;
mod damage;
mod feetslam;
mod live;
mod mutations;
mod odd_maps;
mod optimize;
mod paper;
mod pdr;
mod refusals;
mod report;
mod streams;
mod suggest;
mod usage;
mod walks;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use hitl_slam::simulate::{self, Scenario, Settings};
use hitl_slam::{io, map::SlamMap};

use crate::support::Scratch;

/// What a run of the command left.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Runs the real binary in `folder`; arguments are separated by spaces.
pub fn hitl_in(folder: &Path, arguments: &str) -> Run {
    hitl_with(folder, arguments.split_whitespace())
}

pub fn hitl_with(folder: &Path, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Run {
    let output =
        Command::new(env!("CARGO_BIN_EXE_hitl")).current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// A scratch folder to run the command in.
pub struct Bench {
    pub scratch: Scratch,
}

impl Bench {
    pub fn new(test: &str) -> Self {
        Bench { scratch: Scratch::new(&format!("cli-{test}")) }
    }

    /// With `run/`, what `simulate loop` makes.
    pub fn with_loop(test: &str) -> Self {
        let bench = Bench::new(test);
        bench.good("simulate loop --seed 7 -o run");
        bench
    }

    pub fn folder(&self) -> PathBuf {
        self.scratch.path("")
    }

    pub fn hitl(&self, arguments: &str) -> Run {
        hitl_in(&self.folder(), arguments)
    }

    /// A run on clean data: exit code 0, nothing on stderr. Returns stdout.
    pub fn good(&self, arguments: &str) -> String {
        let run = self.hitl(arguments);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "hitl {arguments}");
        run.stdout
    }

    /// A refused run: exit code 2, nothing on stdout, one line on stderr that holds all of `parts`, and not a file or
    /// folder more, fewer or other than before.
    pub fn refused(&self, arguments: &str, parts: &[&str]) {
        let before = listing(&self.folder());
        let run = self.hitl(arguments);
        assert_eq!(run.code, Some(2), "hitl {arguments}: {}", run.stderr);
        assert_eq!(run.stdout, "", "hitl {arguments}");
        let lines: Vec<&str> = run.stderr.lines().collect();
        assert_eq!(lines.len(), 1, "hitl {arguments}: {}", run.stderr);
        for part in parts.iter().chain(&["hitl: ", "expected "]) {
            assert!(lines[0].contains(part), "hitl {arguments}: '{part}' is not in: {}", lines[0]);
        }
        assert!(listing(&self.folder()) == before, "hitl {arguments}: changed a file");
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.scratch.path(name)).unwrap()
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    pub fn exists(&self, name: &str) -> bool {
        self.scratch.path(name).exists()
    }

    pub fn map(&self, name: &str) -> SlamMap {
        io::native::read(&self.scratch.path(name)).unwrap().value
    }

    /// Writes a changed copy of `run/map.npz`.
    pub fn changed_map(&self, name: &str, change: impl FnOnce(&mut SlamMap)) {
        let mut map = self.map("run/map.npz");
        change(&mut map);
        io::native::write(&self.scratch.path(name), &map).unwrap();
    }
}

/// Every file below a folder with its content, every folder with nothing.
fn listing(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path.clone());
            }
            let content = if path.is_file() { std::fs::read(&path).ok() } else { None };
            found.push((path, content));
        }
    }
    found.sort();
    found
}

/// The first 40 poses of the simulated loop: small enough to damage byte by byte.
pub fn small_map() -> SlamMap {
    let mut map = simulate::run(Scenario::ALL[0], &Settings::default()).unwrap().map;
    let n = 40;
    map.poses.truncate(n);
    map.stamps_s.iter_mut().for_each(|s| s.truncate(n));
    map.relative_factors.retain(|f| f.i < n && f.j < n);
    map.scans.retain(|s| s.parent < n);
    map.observations.starts.truncate(n + 1);
    let points = map.observations.starts[n] as usize;
    map.observations.points.truncate(points);
    map.observations.normals.truncate(points);
    map.observations.ranges_m.truncate(points);
    map.validate("small map").unwrap();
    map
}

/// Corrections that name poses of the small map.
pub const SMALL_CORRECTIONS: &str = concat!(
    r#"{"mode": "collinear", "id": "one", "a": {"pose": 2, "points": [[0.5, -1.2], [2.5, -1.2]]}, "#,
    r#""b": {"pose": 35, "points": [[0.5, -1.2], [2.5, -1.2]]}}"#,
    "\n"
);
