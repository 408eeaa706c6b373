//! Every command on clean data: what it prints, what it writes.

use std::fs;

use hitl_slam::io;

use super::Bench;
use crate::support::small_log;

#[test]
fn the_first_steps_of_the_help_page_work_as_printed() {
    let bench = Bench::new("first-steps");
    let help = bench.good("help");
    let steps: Vec<&str> = help.lines().filter_map(|l| l.trim().strip_prefix("hitl ")).collect();
    assert_eq!(steps.len(), 4, "{help}");
    for step in steps {
        let printed = bench.good(step);
        assert!(!printed.is_empty());
    }
    for file in ["run/map.npz", "run/truth.tum", "run/corrections.jsonl", "run/walls.csv", "run/both.png"] {
        assert!(bench.exists(file), "{file}");
    }
    assert!(bench.bytes("run/both.png").starts_with(b"\x89PNG"));
}

#[test]
fn a_simulated_loop_is_closed() {
    let bench = Bench::with_loop("closed");
    bench.good("correct run/map.npz -c run/corrections.jsonl -o out.npz");
    let ate = |map: &str| {
        let report = bench.good(&format!("evaluate {map} --truth run/truth.tum --report -"));
        serde_json::from_str::<serde_json::Value>(&report).unwrap()["ate_rmse_m"].as_f64().unwrap()
    };
    let (before, after) = (ate("run/map.npz"), ate("out.npz"));
    assert!(after < 0.1 && after < before / 5.0, "ATE {before} m became {after} m");
}

#[test]
fn info_knows_every_format_by_its_content() {
    let bench = Bench::with_loop("info");
    let extensions = ["npz", "g2o", "stfs.covars", "tum"];
    let formats = ["native map", "g2o pose graph", "HitL-SLAM 16-column text", "TUM trajectory"];
    for (extension, format) in extensions.iter().zip(formats) {
        bench.good(&format!("import run/map.npz -o a.{extension}"));
        fs::rename(bench.scratch.path(&format!("a.{extension}")), bench.scratch.path("nameless")).unwrap();
        let printed = bench.good("info nameless");
        assert!(printed.contains(&format!("format              {format}")), "{printed}");
        assert!(printed.contains("poses               650"), "{printed}");
        assert!(!printed.contains("inf") && !printed.contains("NaN"), "{printed}");
    }
    bench.scratch.file("log", small_log(5));
    let printed = bench.good("info log");
    assert!(printed.contains("CARMEN log") && printed.contains("scans               5"), "{printed}");
}

#[test]
fn a_log_becomes_a_map_by_every_way_in() {
    let bench = Bench::new("import");
    bench.scratch.file("a.log", small_log(30));
    for options in ["", "--front-end none", "--front-end odometry", "--keyframe-distance-m 0.5"] {
        let printed = bench.good(&format!("import a.log -o a.npz {options}"));
        assert!(printed.starts_with("a.npz: ") && printed.contains("30 scans"), "{printed}");
    }
    bench.good("import a.log -o a.tum");
    bench.good("import a.log -o b.npz --initial a.tum");
    assert_eq!(bench.text("a.tum").lines().count(), 30);
    let map = bench.map("a.npz");
    io::g2o::write(&bench.scratch.path("a.g2o"), &map).unwrap();
    let stamps: Vec<f64> = map.stamps_s.clone().unwrap();
    let keyframes = hitl_slam::map::Trajectory { stamps_s: stamps, poses: map.poses.clone() };
    io::tum::write(&bench.scratch.path("keyframes.tum"), &keyframes).unwrap();
    bench.good("import a.log -o c.npz --graph a.g2o --initial keyframes.tum");
    assert_eq!(bench.map("c.npz").scans.len(), 30);
}

#[test]
fn the_extension_of_the_output_picks_its_format() {
    let bench = Bench::with_loop("extensions");
    for (name, head) in
        [("o.npz", "PK"), ("o.g2o", "VERTEX_SE2 0 "), ("o.stfs.covars", "hitl-slam\n"), ("o.tum", "0 ")]
    {
        bench.good(&format!("correct run/map.npz -c run/corrections.jsonl -o {name}"));
        let bytes = bench.bytes(name);
        assert!(bytes.starts_with(head.as_bytes()), "{name}");
    }
    assert_eq!(bench.map("o.npz").human_factors.len(), 3);
    assert_eq!(bench.text("o.tum").lines().count(), 650);
}

#[test]
fn a_trajectory_has_one_line_per_scan_of_the_log() {
    let bench = Bench::new("trajectory");
    bench.scratch.file("a.log", small_log(41));
    let stroke = "[[-0.5, -2], [0.5, -2]]";
    bench.scratch.file("c.jsonl", format!("{{\"mode\": \"parallel\", \"a\": {stroke}, \"b\": {stroke}}}\n"));
    bench.good("correct a.log -c c.jsonl -o a.npz --trajectory a.tum");
    let text = bench.text("a.tum");
    assert!(bench.map("a.npz").poses.len() < 41, "some scans are not poses");
    assert_eq!(text.lines().count(), 41);
    assert!(text.lines().next().unwrap().starts_with("100 "), "the stamps of the log");
    assert!(text.lines().all(|l| l.split(' ').count() == 8));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let bench = Bench::with_loop("bytes");
    bench.good("simulate loop --seed 7 -o again");
    for file in ["map.npz", "truth.tum", "corrections.jsonl", "walls.csv"] {
        assert!(bench.bytes(&format!("run/{file}")) == bench.bytes(&format!("again/{file}")), "{file}");
    }
    let names = ["o.npz", "t.tum", "p/before.png", "p/after.png", "p/before-after.png", "r.svg"];
    let run = |folder: &str| {
        bench.good(&format!(
            "correct run/map.npz -c run/corrections.jsonl -o {folder}/o.npz --trajectory {folder}/t.tum --pictures {folder}/p"
        ));
        bench.good(&format!("render {folder}/o.npz -o {folder}/r.svg --grid --crop -5,-5,5,5"));
        bench.good(&format!("evaluate {folder}/o.npz --truth run/truth.tum --report {folder}/e.json"));
        names.map(|n| bench.bytes(&format!("{folder}/{n}")))
    };
    let (first, second) = (run("one"), run("two"));
    for (k, name) in names.iter().enumerate() {
        assert!(first[k] == second[k], "{name}");
    }
    assert!(bench.bytes("one/e.json") == bench.bytes("two/e.json"));
}

#[test]
fn a_corrected_map_is_corrected_further() {
    let bench = Bench::with_loop("further");
    let all = bench.text("run/corrections.jsonl");
    let (first, rest) = all.split_at(all.find('\n').unwrap() + 1);
    bench.scratch.file("first.jsonl", first);
    bench.scratch.file("rest.jsonl", rest);
    bench.good("correct run/map.npz -c first.jsonl -o one.npz --no-reassociate");
    bench.good("correct one.npz -c rest.jsonl -o two.npz --no-reassociate");
    bench.good("correct run/map.npz -c run/corrections.jsonl -o once.npz --no-reassociate");
    let (two, once) = (bench.map("two.npz"), bench.map("once.npz"));
    let ids =
        |map: &hitl_slam::map::SlamMap| map.human_factors.iter().map(|f| f.id.clone()).collect::<Vec<_>>();
    assert_eq!(ids(&two), ids(&once));
    for (p, q) in two.poses.iter().zip(&once.poses) {
        assert!((p.translation() - q.translation()).norm() < 1e-9, "{p:?} {q:?}");
    }
}

#[test]
fn an_interpretation_writes_no_map() {
    let bench = Bench::with_loop("interpret-only");
    let printed = bench.good(
        "correct run/map.npz -c run/corrections.jsonl --interpret-only -o o.npz --trajectory o.tum --report r.json --pictures p",
    );
    assert!(printed.contains("c1") && printed.contains("points of"), "{printed}");
    assert!(!bench.exists("o.npz") && !bench.exists("o.tum"));
    assert!(bench.exists("p/before.png") && !bench.exists("p/after.png"));
    let report = bench.json("r.json");
    let c1 = &report["corrections"][0];
    assert!(c1["poses_a"].as_u64().unwrap() > 0 && c1["final_cost"].is_null(), "{c1}");
    bench.good("correct run/map.npz -c run/corrections.jsonl --interpret-only");
}

#[test]
fn strict_turns_a_rejected_correction_into_exit_code_1_and_still_writes_the_map() {
    let bench = Bench::with_loop("strict");
    let far = r#"{"mode": "parallel", "a": [[900, 900], [901, 900]], "b": [[0, 0], [1, 0]]}"#;
    let off = far.replace('}', r#", "enabled": false}"#);
    bench.scratch.file("far.jsonl", format!("{}{far}\n", bench.text("run/corrections.jsonl")));
    bench.scratch.file("off.jsonl", format!("{}{off}\n", bench.text("run/corrections.jsonl")));
    let run = bench.hitl("correct run/map.npz -c far.jsonl -o o.npz --strict --no-reassociate");
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), ""));
    assert!(run.stdout.contains("rejected: stroke a: no wall within"), "{}", run.stdout);
    assert_eq!(bench.map("o.npz").human_factors.len(), 3);
    bench.good("correct run/map.npz -c far.jsonl -o o.npz --no-reassociate");
    bench.good("correct run/map.npz -c off.jsonl -o o.npz --strict");
}
