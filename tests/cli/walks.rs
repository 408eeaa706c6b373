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
    let correct = "correct map.npz -c c.jsonl --drawing-sigma-m 0.3 --observation-sigma-m 0.2 --strict";
    let said = bench.good(&format!("{correct} -o corrected.npz"));
    assert!(said.contains("re-association: off, since this is a map of walks"), "{said}");
    let read = |name: &str| std::fs::read(bench.folder().join(name)).unwrap();
    bench.good(&format!("{correct} --report r.json --no-reassociate -o alone.npz"));
    assert_eq!(read("corrected.npz"), read("alone.npz"));
    bench.good(&format!("{correct} --report r.json -o corrected.npz"));
    let report: serde_json::Value = serde_json::from_slice(&read("r.json")).unwrap();
    assert_eq!(report["reassociation"]["footprints"], true);
    assert_eq!(report["automatic_factors"], serde_json::json!([]));
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
        ("export map.npz -o x-1.csv --walkers a,../b,c", "walkers: found the name \"../b\""),
        ("export map.npz -o x-1.csv --walkers a,b\\c,d", "no slash"),
        ("export map.npz -o x-1.csv --walkers a,,c", "walkers: found the name \"\""),
        ("export map.npz -o x-1.csv --walkers a,b,a", "walkers: found the name \"a\" twice"),
        ("export map.npz -o x.tum --walkers a,b,c", "expected it with .csv only"),
    ] {
        let run = hitl_in(&bench.folder(), command);
        assert_eq!(run.code, Some(2), "{command}: {}", run.stderr);
        assert!(run.stderr.lines().count() == 1 && run.stderr.contains(words), "{command}: {}", run.stderr);
    }
    assert!(["x.npz", "x-1.csv", "a.csv", "../b.csv"].iter().all(|file| !bench.exists(file)));
}

#[test]
fn what_feetslam_wrote_is_a_map_too() {
    let bench = Bench::new("walk-paths");
    bench.good("feetslam simulate six --seed 3 -o six");
    let walks = "six/w1.csv six/w2.csv";
    bench.good(&format!(
        "feetslam run {walks} --mode footslam --particles 50 --start 0,0,-90 --plan six/walls.csv -o out"
    ));
    assert!(bench.exists("out/walls.csv"), "the plan stays with the paths");
    bench.good("info out/paths.csv");
    bench.good("import out/paths.csv -o map.npz");
    bench.good("export map.npz -o back.csv --walkers w1,w2");
    // The weighted means, step by step, where they were.
    let text = std::fs::read_to_string(bench.folder().join("out/paths.csv")).unwrap();
    let last = text.lines().rfind(|l| l.starts_with("w2,")).unwrap();
    let value = |k: usize| last.split(',').nth(k).unwrap().parse::<f64>().unwrap();
    let hitl_slam::io::Source::Map(map) =
        hitl_slam::io::read(&bench.folder().join("map.npz")).unwrap().1.value
    else {
        panic!("a map")
    };
    let end = *map.trajectory().poses.last().unwrap();
    assert!((end.x_m - value(4)).hypot(end.y_m - value(5)) < 1e-9);
    let damaged = [
        ("walker,time_s,best_x_m\n", "found the header"),
        (&text.replacen("w1,", "w1,x", 1), "time_s: found"),
        (&text.lines().take(2).collect::<Vec<_>>().join("\n"), "without steps"),
    ];
    for (content, words) in damaged {
        std::fs::write(bench.folder().join("bad.csv"), content).unwrap();
        let run = hitl_in(&bench.folder(), "import bad.csv -o bad.npz");
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert!(run.stderr.contains("bad.csv") && run.stderr.contains(words), "{}", run.stderr);
    }
}
