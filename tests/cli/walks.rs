//! Walks through the commands for maps.

use super::{Bench, hitl_in};

#[test]
fn walks_become_a_map_are_corrected_and_come_back_as_walks() {
    let bench = Bench::new("walks");
    bench.good("feetslam simulate six --seed 1 -o six");
    bench.good("info six/w1.csv");
    bench.good("import six/w1.csv six/w2.csv six/w3.csv --start 0,0,-90 -o map.npz");
    let strokes = r#"{"mode": "collinear", "a": {"pose": 3, "points": [[0, 0], [5, 0]]}, "b": {"pose": 9, "points": [[0, 0], [5, 0]]}}"#;
    std::fs::write(bench.folder().join("c.jsonl"), strokes).unwrap();
    bench.good("correct map.npz -c c.jsonl --drawing-sigma-m 0.3 --observation-sigma-m 0.2 --strict -o corrected.npz");
    bench.good("export corrected.npz -o back/w.csv");
    bench.good("export corrected.npz -o named/x.csv --walkers w1,w2,w3");
    bench.good("feetslam run named/w1.csv named/w2.csv named/w3.csv --mode footslam --particles 50 --start 0,0,-90 --truth six/truth.csv -o run");
    for k in 1..=3 {
        let read = |name: String| std::fs::read(bench.folder().join(name)).unwrap();
        assert_eq!(read(format!("back/w-{k}.csv")), read(format!("named/w{k}.csv")));
    }
    // One walk is a map for every command.
    bench.good("render six/w1.csv -o w1.png");
    bench.good("export six/w1.csv -o one.csv");
    for (command, words) in [
        ("import six/w1.csv six/w1.csv -o x.npz", "second walker with the name 'w1'"),
        ("import six/w1.csv --front-end odometry -o x.npz", "need scans"),
        ("import six/w1.csv --start 0,0 -o x.npz", "expected x_m,y_m,heading_deg"),
        ("import six/w1.csv --start 0,0,0 --start 1,1,1 -o x.npz", "starts: found 2, expected 1 or 1"),
        ("import map.npz six/w1.csv -o x.npz", "expected one, or walks only"),
        ("import six/w1.csv --steps-per-pose 0 -o x.npz", "steps per pose: found 0"),
        ("export map.npz -o x.csv --walkers a,b", "found 2 names, expected 3"),
        ("export map.npz -o x.tum --walkers a,b,c", "expected it with .csv only"),
    ] {
        let run = hitl_in(&bench.folder(), command);
        assert_eq!(run.code, Some(2), "{command}: {}", run.stderr);
        assert!(run.stderr.lines().count() == 1 && run.stderr.contains(words), "{command}: {}", run.stderr);
    }
    assert!(!bench.exists("x.npz") && !bench.exists("x-1.csv"));
}
