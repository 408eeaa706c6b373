//! `hitl feetslam live` as a program: killed and started again, fed with nonsense, asked for maps.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use hitl_slam::pedestrian::random::Key;
use hitl_slam::simulate::walkers::{Scenario, Settings};

use super::Bench;

const FLAGS: [&str; 6] = ["--particles", "300", "--start", "0,0,-90", "--refresh-steps", "7"];

/// Steps of six walkers by time, with requests among them and one walker who starts elsewhere.
fn lines() -> Vec<String> {
    let simulation = Scenario::Six.run(&Settings { seed: 5, ..Settings::default() }, &[]).unwrap();
    let mut steps: Vec<_> =
        simulation.walks.iter().flat_map(|w| w.steps.iter().map(move |s| (w.name.clone(), s))).collect();
    steps.sort_by(|a, b| a.1.time_s.total_cmp(&b.1.time_s));
    let mut lines: Vec<String> = steps
        .iter()
        .map(|(name, s)| {
            serde_json::json!({"walker": name, "time_s": s.time_s, "forward_m": s.forward_m, "left_m": s.left_m,
                               "turn_rad": s.turn_rad, "height_m": 0.0})
            .to_string()
        })
        .collect();
    lines.insert(250, "{\"request\": \"round\"}".into());
    lines.insert(200, "{\"request\": \"map\"}".into());
    let start = r#"{"walker": "w2", "start_x_m": 0.1, "start_y_m": 0, "start_heading_rad": -1.5}"#;
    lines.insert(0, start.into());
    lines
}

fn start(folder: &Path, out: &str, more: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_hitl"))
        .current_dir(folder)
        .args(["feetslam", "live", "-o", out])
        .args(FLAGS)
        .args(more)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Feeds text and waits: exit code, stdout, stderr.
fn feed(folder: &Path, out: &str, more: &[&str], text: &str) -> (Option<i32>, String, String) {
    let mut child = start(folder, out, more);
    let mut stdin = child.stdin.take().unwrap();
    let text = text.to_owned();
    let feeder = std::thread::spawn(move || drop(stdin.write_all(text.as_bytes())));
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_run_that_is_killed_at_any_moment_and_started_again_answers_as_one_that_was_not() {
    let bench = Bench::new("live-kill");
    let folder = bench.folder();
    let text = lines().join("\n") + "\n";
    let (code, answers, stderr) = feed(&folder, "whole", &[], &text);
    assert_eq!(code, Some(0), "{stderr}");
    assert_eq!(answers, fs::read_to_string(folder.join("whole/answers.jsonl")).unwrap());

    let (mut heard, mut cut_short) = (Vec::new(), 0);
    for attempt in 0..9 {
        // The whole stream again, from the start; killed after a while, whatever it is doing.
        let mut child = start(&folder, "killed", &["--from-start", "--threads", ["1", "2"][attempt % 2]]);
        let (mut stdin, stdout) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let all = text.clone();
        let feeder = std::thread::spawn(move || drop(stdin.write_all(all.as_bytes())));
        let listener = std::thread::spawn(move || {
            BufReader::new(stdout).lines().map_while(Result::ok).collect::<Vec<String>>()
        });
        std::thread::sleep(Duration::from_millis(5 + (25.0 * Key::new(3).uniform(attempt as u64)) as u64));
        child.kill().unwrap();
        cut_short += usize::from(child.wait().unwrap().code().is_none());
        feeder.join().unwrap();
        heard.extend(listener.join().unwrap());
    }
    assert!(cut_short >= 3, "{cut_short} of 9 were killed on their way");
    let (code, last, stderr) = feed(&folder, "killed", &["--from-start"], &text);
    assert_eq!(code, Some(0), "{stderr}");
    heard.extend(last.lines().map(str::to_owned));

    for file in
        ["lines.jsonl", "answers.jsonl", "paths.csv", "map.json", "map.npz", "walks/w2.csv", "walks/w5.csv"]
    {
        let [whole, killed] = ["whole", "killed"].map(|run| fs::read(folder.join(run).join(file)).unwrap());
        assert!(whole == killed, "{file} differs");
    }
    // Nothing that was answered was kept from whoever listened; a line may have been said twice, never two things.
    heard.dedup();
    assert_eq!(heard.join("\n") + "\n", answers);
}

#[test]
fn a_run_goes_on_with_the_rest_of_the_lines() {
    let bench = Bench::new("live-rest");
    let folder = bench.folder();
    let lines = lines();
    let (_, whole, _) = feed(&folder, "whole", &[], &lines[..120].join("\n"));
    let (_, first, _) = feed(&folder, "parts", &[], &lines[..50].join("\n"));
    let (code, second, stderr) = feed(&folder, "parts", &[], &lines[50..120].join("\n"));
    assert_eq!(code, Some(0));
    assert!(stderr.contains("goes on after 50 lines"), "{stderr}");
    assert_eq!(first + &second, whole);
}

#[test]
fn the_walks_that_came_in_are_walks_for_feetslam_run() {
    let bench = Bench::new("live-walks");
    let (code, ..) = feed(&bench.folder(), "out", &["--map-every-steps", "60"], &lines().join("\n"));
    assert_eq!(code, Some(0));
    bench.good("feetslam run out/walks/w1.csv out/walks/w2.csv --mode footslam --particles 100 -o run");
    let map: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(bench.folder().join("out/map.json")).unwrap()).unwrap();
    assert!(map["crossings"].as_f64().unwrap() > 100.0);
}

#[test]
fn a_map_on_request_holds_what_was_walked_so_far() {
    let bench = Bench::new("live-map");
    let (_, answers, _) = feed(&bench.folder(), "out", &[], &lines().join("\n"));
    let answers: Vec<serde_json::Value> = answers.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let event = |name: &str| answers.iter().find(|a| a["event"] == name).unwrap();
    assert!(event("map")["crossings"].as_f64().unwrap() > 50.0);
    assert_eq!(event("map")["line"], 202);
    assert_eq!(event("round")["walkers"].as_array().unwrap().len(), 6);
    // One answer to a step, at the step's own line; w2 began where it was told.
    let first = answers.iter().find(|a| a["walker"] == "w2").unwrap();
    assert!(first["pdr_x_m"].as_f64().unwrap() > 0.05, "{first}");
    let lines: Vec<u64> =
        answers.iter().filter(|a| a["walker"].is_string()).map(|a| a["line"].as_u64().unwrap()).collect();
    assert_eq!(lines.len(), answers.iter().filter(|a| a["event"].is_null()).count());
    assert!(lines.windows(2).all(|w| w[0] < w[1]));
}

#[test]
fn a_bad_line_stops_the_run_with_its_number_and_loses_nothing() {
    let good = lines();
    for (bad, words) in [
        ("nonsense", "found no JSON object"),
        ("[1, 2]", "expected a JSON object"),
        (r#"{"walker": "w1", "time_s": 99, "forward_m": 0.7, "left_m": 0}"#, "turn_rad: found none"),
        (
            r#"{"walker": "w1", "time_s": 99, "forward_m": "x", "left_m": 0, "turn_rad": 0}"#,
            "forward_m: found \"x\"",
        ),
        (r#"{"walker": "w1", "time_s": 99, "forward_m": 1e999, "left_m": 0, "turn_rad": 0}"#, "out of range"),
        (
            r#"{"walker": "../x", "time_s": 99, "forward_m": 0.7, "left_m": 0, "turn_rad": 0}"#,
            "expected a name",
        ),
        (
            r#"{"walker": "w1", "time_s": 0, "forward_m": 0.7, "left_m": 0, "turn_rad": 0}"#,
            "expected a later time",
        ),
        (
            r#"{"walker": "w1", "time_s": 99, "forward_m": 70, "left_m": 0, "turn_rad": 0}"#,
            "are steps missing",
        ),
        (
            r#"{"walker": "w1", "time_s": 99, "forward_m": 1, "left_m": 0, "turn_rad": 0, "height": 1}"#,
            "field 'height'",
        ),
        (r#"{"walker": "w1", "start_x_m": 0, "start_y_m": 0, "start_heading_rad": 0}"#, "already known"),
        (r#"{"request": "tea"}"#, "expected \"map\" or \"round\""),
    ] {
        let bench = Bench::new("live-bad");
        let folder = bench.folder();
        let text = [&good[..30], &[bad.to_owned()], &good[30..40]].concat().join("\n");
        let (code, answers, stderr) = feed(&folder, "out", &[], &text);
        assert_eq!(code, Some(2), "{bad}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
        assert!(stderr.contains("standard input:31: ") && stderr.contains(words), "{bad}: {stderr}");
        assert!(!folder.join("out/paths.csv").exists(), "no result of half a run");
        // Mended, it goes on; and whoever prefers to lose the line gets the same.
        let (code, rest, _) = feed(&folder, "out", &[], &good[30..40].join("\n"));
        assert_eq!(code, Some(0));
        let (code, skipping, stderr) = feed(&folder, "skip", &["--skip-bad-lines"], &text);
        assert_eq!(code, Some(0));
        assert!(stderr.contains("standard input:31: ") && stderr.contains("skipped"), "{stderr}");
        assert_eq!(answers + &rest, skipping, "{bad}");
    }
}

#[test]
fn live_refuses_what_would_mix_up_runs() {
    let bench = Bench::new("live-refuse");
    let folder = bench.folder();
    let good = lines();
    for nothing in ["", "\n\n"] {
        let (code, _, stderr) = feed(&folder, "none", &[], nothing);
        assert_eq!(code, Some(2));
        assert!(stderr.contains("found no step"), "{stderr}");
    }
    assert!(!folder.join("none").exists(), "nothing came, nothing is written");
    let first = good[..20].join("\n");
    assert_eq!(feed(&folder, "out", &[], &first).0, Some(0));
    let (code, _, stderr) = feed(&folder, "out", &["--seed", "9"], &first);
    assert!(code == Some(2) && stderr.contains("give the same options"), "{stderr}");
    let (code, _, stderr) = feed(&folder, "out", &["--from-start"], &good[1..20].join("\n"));
    assert!(code == Some(2) && stderr.contains("expected the same again"), "{stderr}");
    let (code, _, stderr) = feed(&folder, "out", &["--grid", "regrid"], &first);
    assert!(code == Some(2) && stderr.contains("found regrid"), "{stderr}");
    // Two at once.
    let mut child = start(&folder, "out", &[]);
    let mut heard = String::new();
    writeln!(child.stdin.as_mut().unwrap(), "{}", good[20]).unwrap();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut heard).unwrap();
    let (code, _, stderr) = feed(&folder, "out", &[], &good[21]);
    assert!(code == Some(2) && stderr.contains("another hitl"), "{stderr}");
    drop(child.stdin.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
