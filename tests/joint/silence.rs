//! Neither Ceres nor its logger writes anything: not to stdout, not to stderr, not to files.

use std::process::Command;

use hitl_slam::joint::problem::{JointProblem, RelativeTerm};
use hitl_slam::joint::{Backend, Options};
use hitl_slam::solver::Loss;

use crate::support::both_backends::ceres_or_skip;
use crate::support::problems;

const CHILD: &str = "joint::silence::child";

/// Run by the test below in a process of its own: solves that go well and solves that make Ceres complain.
#[test]
#[ignore = "run by ceres_writes_nothing_anywhere"]
fn child() {
    let options = Options { backend: Backend::Ceres, ..Options::default() };
    for seed in 0..3 {
        Backend::Ceres.solve(&mut problems::solvable(seed, Loss::Huber(1.0), true), &options).unwrap();
    }
    // A residual of zero with a Jacobian beyond the largest number: Ceres cannot evaluate it, and says so.
    let mut problem = JointProblem {
        poses: vec![[0.0; 3], [3.0, 3.0, 0.0]],
        held: vec![1],
        relatives: vec![RelativeTerm {
            i: 0,
            j: 1,
            measured: [3.0, 3.0, 0.0],
            sqrt_information: [1e308, 0.0, 0.0, 0.0, 1e308, 0.0, 0.0, 0.0, 1.0],
            loss: Loss::None,
        }],
        ..Default::default()
    };
    let report = Backend::Ceres.solve(&mut problem, &options).unwrap();
    assert!(!report.termination.converged());
    assert!(!report.warnings.is_empty(), "no line was captured");
}

#[test]
fn ceres_writes_nothing_anywhere() {
    if !ceres_or_skip() {
        return;
    }
    let folder = std::env::temp_dir().join(format!("hitl-silence-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", CHILD, "--include-ignored", "--nocapture", "--test-threads=1"]);
    command.current_dir(&folder).env_remove("RUST_BACKTRACE");
    for name in ["TMPDIR", "TEST_TMPDIR", "TMP", "GLOG_log_dir"] {
        command.env(name, &folder);
    }
    command.env("GLOG_logtostderr", "1").env("GLOG_v", "5");
    let output = command.output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let left: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|f| f.unwrap().file_name()).collect();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(output.status.success(), "{out}{err}");
    assert_eq!(err, "");
    // The test harness's own words, and nothing between them.
    let words: Vec<&str> = out.lines().filter(|l| !l.is_empty()).collect();
    assert!(
        words.len() == 3 && words[0] == "running 1 test" && words[2].starts_with("test result: ok"),
        "{out}"
    );
    assert_eq!(words[1].trim_end(), format!("test {CHILD} ... ok"));
    assert!(left.is_empty(), "{left:?}");
}
