//! Standard streams: who goes away, who is full, who is not a terminal.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use super::Bench;
use crate::support::both_backends::ceres_or_skip;

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let bench = Bench::with_loop("pipe");
    for arguments in [
        "info run/map.npz",
        "correct run/map.npz -c run/corrections.jsonl -o o.npz --report -",
        "correct run/map.npz -c run/corrections.jsonl -o p.npz",
        "evaluate run/map.npz",
        "optimize run/map.npz -o q.npz",
        "crosscheck run/map.npz -c run/corrections.jsonl",
        "correct --help",
        "help",
    ]
    .into_iter()
    .filter(|a| !a.starts_with("crosscheck") || ceres_or_skip())
    {
        let mut child = Command::new(env!("CARGO_BIN_EXE_hitl"))
            .current_dir(bench.folder())
            .args(arguments.split_whitespace())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take()); // as `| head -0`, before anything was printed
        let mut complaint = String::new();
        child.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "hitl {arguments}: {complaint}");
        assert_eq!(complaint, "", "hitl {arguments}");
    }
    assert!(bench.exists("o.npz") && bench.exists("p.npz"), "the work is done all the same");
}

#[test]
fn the_first_line_is_enough_for_a_reader() {
    let bench = Bench::with_loop("head");
    let mut child = Command::new(env!("CARGO_BIN_EXE_hitl"))
        .current_dir(bench.folder())
        .args(["info", "run/map.npz"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("format"), "{line}");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_under_stdout_is_told_and_under_stderr_is_no_panic() {
    let bench = Bench::with_loop("full");
    let full = || File::options().write(true).open("/dev/full").unwrap();
    let hitl = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hitl"));
        command.current_dir(bench.folder()).args(arguments);
        command
    };
    let told = hitl(&["info", "run/map.npz"]).stdout(full()).output().unwrap();
    assert_eq!(told.status.code(), Some(2));
    assert_eq!(String::from_utf8(told.stderr).unwrap().lines().count(), 1);
    let silent = hitl(&["info", "nothing.npz"]).stderr(full()).output().unwrap();
    assert_eq!(silent.status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn pipes_and_links_are_written_through_and_not_replaced() {
    let bench = Bench::with_loop("devices");
    assert!(Command::new("mkfifo").arg(bench.scratch.path("pipe")).status().unwrap().success());
    let reader = Command::new("cat").arg(bench.scratch.path("pipe")).stdout(Stdio::piped()).spawn().unwrap();
    bench.good("evaluate run/map.npz --report pipe");
    let read = reader.wait_with_output().unwrap().stdout;
    assert!(serde_json::from_slice::<serde_json::Value>(&read).unwrap().is_object());
    bench.scratch.file("target.json", "old");
    std::os::unix::fs::symlink("target.json", bench.scratch.path("link.json")).unwrap();
    bench.good("evaluate run/map.npz --report link.json");
    assert!(bench.scratch.path("link.json").is_symlink());
    assert!(bench.json("target.json").is_object());
}

#[test]
fn json_on_stdout_stands_alone() {
    let bench = Bench::with_loop("json");
    for arguments in [
        "correct run/map.npz -c run/corrections.jsonl -o o.npz --report -",
        "correct run/map.npz -c run/corrections.jsonl --interpret-only --report -",
        "evaluate run/map.npz --truth run/truth.tum --report -",
    ] {
        let text = bench.good(arguments);
        assert!(serde_json::from_str::<serde_json::Value>(&text).unwrap().is_object());
        assert!(text.ends_with("}\n"), "hitl {arguments}");
    }
    assert!(!bench.exists("-"));
}

#[test]
fn the_remarks_of_readers_go_to_stderr_and_the_work_goes_on() {
    let bench = Bench::new("remarks");
    bench.scratch.file("a.g2o", "VERTEX_SE2 0 0 0 0\nSOMETHING 1\n");
    let run = bench.hitl("info a.g2o");
    assert_eq!(run.code, Some(0));
    assert_eq!(run.stderr, "hitl: note: a.g2o:2: unknown tag SOMETHING: its lines are skipped\n");
    assert!(!run.stdout.contains("note"));
}
