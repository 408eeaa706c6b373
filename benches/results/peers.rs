//! Other people's solvers on a g2o file, each in a process of its own: Ceres by `benches/peers/ceres_peer.cc`, which is compiled
//! here, GTSAM and g2o by `benches/peers/peer.py` where `benches/peers/setup.sh` has put their wheels.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use hitl_slam::geometry::Pose2;

use crate::page::{Result, project};

/// How to start a solver; graph, repeats and the file for its poses follow.
pub struct Peer {
    pub name: &'static str,
    command: PathBuf,
    arguments: Vec<String>,
}

/// One run of a peer.
pub struct Run {
    /// Fastest solve.
    pub cpu_ms: f64,
    pub iterations: usize,
    /// Reading and building the problem.
    pub load_ms: f64,
    pub poses: Vec<Pose2>,
}

/// Those that are there, and a line about those that are not.
pub fn find() -> (Vec<Peer>, String) {
    let (mut peers, mut absent) = (Vec::new(), Vec::new());
    match ceres() {
        Ok(command) => {
            for (name, mode) in [("Ceres, as its example", "sample"), ("Ceres, best tuned", "tuned")] {
                peers.push(Peer { name, command: command.clone(), arguments: vec![mode.into()] });
            }
        }
        Err(reason) => absent.push(format!("Ceres ({reason})")),
    }
    let python = project("target/peers/venv/bin/python");
    let script = project("benches/peers/peer.py").display().to_string();
    if python.exists() {
        for (name, mode) in
            [("GTSAM, Gauss–Newton", "gtsam-gn"), ("GTSAM, LM", "gtsam-lm"), ("g2o, Gauss–Newton", "g2o-gn")]
        {
            let arguments = vec![script.clone(), mode.into()];
            peers.push(Peer { name, command: python.clone(), arguments });
        }
    } else {
        absent.push("GTSAM and g2o (run benches/peers/setup.sh)".into());
    }
    let absent =
        if absent.is_empty() { String::new() } else { format!("Not there: {}. ", absent.join(", ")) };
    (peers, absent)
}

/// Compiles the Ceres peer.
fn ceres() -> Result<PathBuf> {
    let program = project("target/peers/ceres_peer");
    fs::create_dir_all(project("target/peers"))?;
    let compiled = Command::new(std::env::var("CXX").unwrap_or_else(|_| "c++".into()))
        .args(["-O2", "-std=c++17", "-DGLOG_USE_GLOG_EXPORT", "-isystem", "/usr/include/eigen3"])
        .arg(project("benches/peers/ceres_peer.cc"))
        .arg("-o")
        .arg(&program)
        .args(["-lceres", "-lglog"])
        .output()?;
    if compiled.status.success() { Ok(program) } else { Err("its peer does not compile".into()) }
}

impl Peer {
    /// Solves a plain g2o file on one core.
    pub fn run(&self, graph: &Path, repeats: usize, poses_file: &Path) -> Result<Run> {
        let output = Command::new("taskset")
            .args(["-c", "0"])
            .arg(&self.command)
            .args(&self.arguments)
            .arg(graph)
            .arg(repeats.to_string())
            .arg(poses_file)
            .output()?;
        let failed =
            |what: &str| format!("{}: {what}: {}", self.name, String::from_utf8_lossy(&output.stderr));
        if !output.status.success() {
            return Err(failed("failed").into());
        }
        let printed = String::from_utf8_lossy(&output.stdout);
        let numbers: Vec<f64> = printed.split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let [cpu_ms, iterations, load_ms] = numbers[..] else { return Err(failed("says nothing").into()) };
        let mut poses = Vec::new();
        for line in fs::read_to_string(poses_file)?.lines() {
            let pose: Vec<f64> = line.split(' ').map(str::parse).collect::<std::result::Result<_, _>>()?;
            poses.push(Pose2::new(pose[0], pose[1], pose[2]));
        }
        Ok(Run { cpu_ms, iterations: iterations as usize, load_ms, poses })
    }
}
