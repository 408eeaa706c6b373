//! A folder of maps corrected by one command.

use std::fs;

use super::Bench;

/// Two good maps and their corrections, in `maps` and `strokes`.
fn folders(test: &str) -> Bench {
    let bench = Bench::new(test);
    for (name, scenario) in [("ring", "loop"), ("room", "lost-poses")] {
        bench.good(&format!("simulate {scenario} --seed 4 -o run-{name}"));
        for folder in ["maps", "strokes"] {
            fs::create_dir_all(bench.scratch.path(folder)).unwrap();
        }
        let from = |file: &str| bench.scratch.path(&format!("run-{name}/{file}"));
        fs::copy(from("map.npz"), bench.scratch.path(&format!("maps/{name}.npz"))).unwrap();
        fs::copy(from("corrections.jsonl"), bench.scratch.path(&format!("strokes/{name}.jsonl"))).unwrap();
    }
    bench
}

#[test]
fn a_folder_is_corrected_the_same_by_any_number_of_jobs() {
    let bench = folders("batch-jobs");
    for jobs in [1, 2, 5] {
        let printed = bench.good(&format!(
            "correct maps --corrections strokes -o out{jobs} --jobs {jobs} --pictures out{jobs}/p"
        ));
        assert!(printed.contains("3 of 3 applied") && printed.contains("2 done, 0 failed"), "{printed}");
    }
    let files = ["ring.npz", "room.npz", "summary.json", "p/ring/before-after.png", "p/room/after.png"];
    for file in files {
        let one = bench.bytes(&format!("out1/{file}"));
        assert!(
            one == bench.bytes(&format!("out2/{file}")) && one == bench.bytes(&format!("out5/{file}")),
            "{file}"
        );
    }
    bench.good("correct maps/ring.npz -c strokes/ring.jsonl -o alone.npz");
    assert!(bench.bytes("alone.npz") == bench.bytes("out1/ring.npz"), "as if corrected alone");
}

#[test]
fn a_failed_map_is_named_at_the_end_and_the_others_are_done() {
    let bench = folders("batch-failed");
    bench.scratch.file("maps/broken.npz", "junk");
    bench.scratch.file("strokes/broken.jsonl", bench.text("strokes/ring.jsonl"));
    bench.scratch.file("maps/lonely.npz", "junk");
    let run = bench.hitl("correct maps --corrections strokes -o out --jobs 2");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.trim_end().ends_with("expected none: broken, lonely"), "{}", run.stderr);
    assert!(bench.exists("out/ring.npz") && bench.exists("out/room.npz") && !bench.exists("out/broken.npz"));
    let summary = bench.json("out/summary.json");
    assert_eq!((summary["done"].as_u64(), summary["failed"].as_u64()), (Some(2), Some(2)));
    let error = |k: usize| summary["maps"][k]["error"].as_str().unwrap_or_default().to_owned();
    assert!(
        error(0).contains("maps/broken.npz") && error(1).contains("expected one of this stem"),
        "{summary}"
    );
}

#[test]
fn disabled_and_rejected_corrections_of_a_folder_are_told_apart() {
    let bench = folders("batch-disabled");
    let off = bench.text("strokes/ring.jsonl");
    let far = r#"{"mode": "parallel", "id": "far", "a": [[900, 900], [901, 900]], "b": [[0, 0], [1, 0]]}"#;
    let off =
        r#"{"mode": "parallel", "id": "off", "enabled": false, "a": [[0, 0], [1, 0]], "b": [[0, 0], [1, 0]]}"#
            .to_owned()
            + "\n" + &off;
    bench.scratch.file("strokes/ring.jsonl", format!("{off}{far}\n"));
    let arguments = "correct maps --corrections strokes -o out --report s.json";
    bench.good(arguments);
    let ring = &bench.json("s.json")["maps"][0];
    assert_eq!((ring["disabled"].as_u64(), ring["accepted"].as_u64()), (Some(1), Some(3)), "{ring}");
    assert_eq!(ring["rejected"][0]["id"], "far");
    assert_eq!(bench.hitl(&format!("{arguments} --strict")).code, Some(1));
}

#[test]
fn what_makes_no_sense_for_a_folder_is_refused() {
    let bench = folders("batch-refused");
    bench.refused(
        "correct maps --corrections strokes/ring.jsonl -o out.npz",
        &["maps: found a folder, expected a file"],
    );
    bench.refused("correct maps --corrections strokes -o out --jobs 0", &["--jobs"]);
    bench.refused("correct maps --corrections strokes -o out --trajectory t.tum", &["--trajectory"]);
    bench.refused("correct maps/ring.npz --corrections strokes/ring.jsonl -o o.npz --jobs 2", &["--jobs"]);
}
