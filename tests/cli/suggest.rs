//! `hitl suggest` as a user meets it.

use super::Bench;

#[test]
fn what_is_suggested_can_be_looked_at_and_applied_as_it_is() {
    let bench = Bench::with_loop("suggest");
    let said = bench.good("suggest run/map.npz -c s.jsonl --report s.json --picture s.png");
    assert!(said.contains("doubled-wall") || said.contains("visits"), "{said}");
    let report: serde_json::Value = serde_json::from_slice(&bench.bytes("s.json")).unwrap();
    let suggestions = report["suggestions"].as_array().unwrap();
    let lines = String::from_utf8(bench.bytes("s.jsonl")).unwrap();
    assert!(!suggestions.is_empty() && lines.lines().count() == suggestions.len(), "{lines}");
    for (line, suggestion) in lines.lines().zip(suggestions) {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        assert_eq!(line, suggestion["correction"]);
        assert!(!suggestion["reason"].as_str().unwrap().is_empty());
    }
    assert!(bench.bytes("s.png").starts_with(b"\x89PNG"));
    bench.good("correct run/map.npz -c s.jsonl -o fixed.npz --strict");
    // On the mended map there is nothing left to say, and that is said.
    assert!(bench.good("suggest fixed.npz").starts_with("nothing to suggest"));
}

#[test]
fn a_bad_suggest_is_one_line_and_nothing_is_written() {
    let bench = Bench::with_loop("suggest-bad");
    for (arguments, found) in [
        ("suggest absent", "absent: found no such file"),
        ("suggest run/truth.tum -c x.jsonl", "points: found none, expected laser points"),
        ("suggest run/map.npz --most 0 -c x.jsonl", "--most: found 0, expected 1 or more"),
        ("suggest run/map.npz --visible-m 0 -c x.jsonl", "--visible-m: found 0"),
        ("suggest run/map.npz --picture x.gif", "x.gif: found .gif, expected .png or .svg"),
    ] {
        bench.refused(arguments, &[found]);
    }
}
