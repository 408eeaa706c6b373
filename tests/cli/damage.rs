//! `hitl simulate damage|person|plan` as a user meets them.

use super::Bench;
use crate::support::small_log;

#[test]
fn a_damaged_map_is_repaired_by_a_person_whose_strokes_do_the_same_again() {
    let bench = Bench::with_loop("damage");
    let said = bench.good("simulate damage run/map.npz --kind kick --seed 2 -o bad");
    assert!(said.starts_with("kick ") && said.ends_with("→ bad/map.npz\n"), "{said}");
    bench.good("simulate damage run/map.npz --kind kick --seed 2 -o again");
    assert_eq!(bench.bytes("bad/map.npz"), bench.bytes("again/map.npz"));
    let report: serde_json::Value = serde_json::from_slice(&bench.bytes("bad/damage.json")).unwrap();
    assert_eq!(report["damages"][0]["kind"], "kick");
    assert_eq!(report["damages"][0]["heading_deg"].as_f64().unwrap().abs(), 30.0);

    let person =
        "simulate person bad/map.npz --reference run/truth.tum --strokes 4 -o p.jsonl --map fixed.npz";
    let said = bench.good(person);
    assert!(said.contains("weight 1000"), "{said}");
    bench.good("correct bad/map.npz -c p.jsonl -o same.npz --keep-contradictions --no-reassociate");
    assert_eq!(bench.bytes("fixed.npz"), bench.bytes("same.npz"));
}

#[test]
fn bad_input_is_one_line_and_nothing_is_written() {
    let bench = Bench::with_loop("damage-bad");
    bench.scratch.file("a.log", small_log(30));
    bench.good("correct run/map.npz -c run/corrections.jsonl -o corrected.npz");
    bench.scratch.file("other.tum", "9000 0 0 0 0 0 0 1\n9001 1 0 0 0 0 0 1\n");
    bench.scratch.file("point.txt", "1, 2, 3\n");
    bench.scratch.file("wall.txt", "0, 0, 1, 0\n");
    for (arguments, found) in [
        ("simulate damage a.log --kind flood -o x", "--kind <KIND>: found 'flood', expected one of kick"),
        ("simulate damage a.log --kind kick --count 0 -o x", "--count: found 0, expected 1 or more"),
        ("simulate damage a.log --kind slip -o x", "found room for 0 of 1 damages (slip), expected a longer"),
        ("simulate damage absent --kind kick -o x", "absent: found no such file"),
        (
            "simulate damage run/truth.tum --kind kick -o x",
            "run/truth.tum: found a trajectory, expected a log",
        ),
        ("simulate damage run/map.npz --kind blind -o x", "kind: found blind, expected kick, slip or drift"),
        ("simulate damage corrected.npz --kind kick -o x", "map: human factors: found 3, expected"),
        ("simulate damage run/map.npz --kind kick -o a.log", "found the file a.log, expected a folder"),
        ("simulate person run/map.npz -o x.jsonl", "found nothing"),
        ("simulate person run/map.npz --reference other.tum -o x.jsonl", "reference: found no two scans"),
        ("simulate person run/map.npz --reference run/truth.tum --wrong 2 -o x.jsonl", "found 2, expected"),
        (
            "simulate person run/map.npz --reference run/truth.tum --strokes 0 -o x.jsonl",
            "--strokes: found 0",
        ),
        ("simulate plan absent -o x", "absent: found no such file"),
        ("simulate plan point.txt -o x", "point.txt:1: found 3 numbers, expected 4"),
        ("simulate plan wall.txt -o x", "plan: found no free space"),
        ("simulate plan wall.txt --length-m -1 -o x", "length: found -1, expected metres from 10"),
    ] {
        bench.refused(arguments, &[found]);
    }
}
