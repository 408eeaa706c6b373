//! `hitl crosscheck`: both solvers, field by field, and what a build without Ceres says.

use hitl_slam::joint::Backend;
use serde_json::Value;

use super::Bench;
use crate::support::both_backends::ceres_or_skip;

const TOTALS: [&str; 9] = [
    "max_residual_difference",
    "max_jacobian_difference",
    "max_pose_difference_m",
    "max_angle_difference_rad",
    "relative_cost_difference",
    "rust_ms",
    "ceres_ms",
    "rust_iterations",
    "ceres_iterations",
];

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn has_totals(value: &Value) {
    for field in TOTALS {
        assert!(value[field].as_f64().is_some_and(|v| v >= 0.0), "{field} in {value}");
    }
    assert!(value["rust_iterations"].is_u64() && value["ceres_iterations"].is_u64());
}

#[test]
fn agreement_is_exit_code_0_and_the_report_has_the_fields_of_the_contract() {
    if !ceres_or_skip() {
        return;
    }
    let bench = Bench::with_loop("crosscheck");
    let printed = bench.good("crosscheck run/map.npz -c run/corrections.jsonl --report r.json");
    let report = bench.json("r.json");
    assert_eq!(report["agree"], true);
    // `formulation` was added to the contract's.
    let mut top = keys(&report);
    top.sort_unstable();
    assert_eq!(top, ["agree", "corrections", "formulation", "total"]);
    assert_eq!(keys(&report["total"]).len(), TOTALS.len());
    has_totals(&report["total"]);
    let entries = report["corrections"].as_array().unwrap();
    assert_eq!(entries.iter().map(|e| e["id"].as_str().unwrap()).collect::<Vec<_>>(), ["c1", "c2", "c3"]);
    for entry in entries {
        has_totals(entry);
        assert_eq!(entry["agree"], true);
        assert!(entry["worst_residual"]["kind"].is_string() && entry["worst_jacobian"]["column"].is_u64());
    }
    let largest = |field: &str| entries.iter().filter_map(|e| e[field].as_f64()).fold(0.0, f64::max);
    assert_eq!(report["total"]["max_pose_difference_m"], largest("max_pose_difference_m"));
    let sum: u64 = entries.iter().filter_map(|e| e["rust_iterations"].as_u64()).sum();
    assert_eq!(report["total"]["rust_iterations"], sum);
    for words in ["largest difference of a jacobian: ", "rust", "ceres", "start", "converged", "agree"] {
        assert!(printed.contains(words), "'{words}' is not in {printed}");
    }
    assert!(!printed.contains("DISAGREE"), "{printed}");
}

#[test]
fn json_on_stdout_is_json_alone() {
    if !ceres_or_skip() {
        return;
    }
    let bench = Bench::with_loop("crosscheck-stdout");
    let run = bench
        .hitl("crosscheck run/map.npz -c run/corrections.jsonl --formulation paper --loss cauchy --report -");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(report["formulation"], "paper");
    assert_eq!(run.stderr, "");
}

#[test]
fn disagreement_is_exit_code_1_and_the_report_is_written_all_the_same() {
    if !ceres_or_skip() {
        return;
    }
    let bench = Bench::with_loop("crosscheck-disagree");
    // Stopped after one step of their own kind, the two are nowhere near each other.
    let run = bench.hitl(
        "crosscheck run/map.npz -c run/corrections.jsonl --max-iterations 1 --no-initial-guess --report r.json",
    );
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), ""), "{}", run.stdout);
    assert!(run.stdout.contains("the two solvers DISAGREE"), "{}", run.stdout);
    let report = bench.json("r.json");
    assert_eq!(report["agree"], false);
    assert!(report["total"]["max_residual_difference"].as_f64().unwrap() <= 1e-9, "terms still agree");
}

#[test]
fn a_rejected_correction_is_named_and_the_rest_are_compared() {
    if !ceres_or_skip() {
        return;
    }
    let bench = Bench::with_loop("crosscheck-rejected");
    let far = r#"{"mode": "parallel", "id": "far", "a": [[900, 900], [901, 900]], "b": [[0, 0], [1, 0]]}"#;
    bench.scratch.file("c.jsonl", format!("{far}\n{}", bench.text("run/corrections.jsonl")));
    let printed = bench.good("crosscheck run/map.npz -c c.jsonl --report r.json");
    assert!(printed.contains("far        rejected: stroke a: no wall"), "{printed}");
    let entries = bench.json("r.json")["corrections"].as_array().unwrap().clone();
    assert_eq!(entries.len(), 4);
    assert!(entries[0]["rejected"].is_string() && entries[1].get("rejected").is_none());
}

#[test]
fn bad_input_is_exit_code_2() {
    if !ceres_or_skip() {
        return;
    }
    let bench = Bench::with_loop("crosscheck-bad");
    bench.scratch.file("c.jsonl", "{\"mode\": \"sideways\"}\n");
    bench.refused("crosscheck run/map.npz -c c.jsonl --report r.json", &["c.jsonl:1"]);
    bench.refused("crosscheck run/map.npz -c run/corrections.jsonl --tie-sigma-m 0", &["--tie-sigma-m"]);
    assert_eq!(bench.hitl("crosscheck run/map.npz").code, Some(2));
    assert_eq!(bench.hitl("crosscheck run/absent.npz -c run/corrections.jsonl").code, Some(2));
}

#[test]
fn a_build_says_which_back_ends_it_has_and_explains_what_it_lacks() {
    let bench = Bench::with_loop("crosscheck-absent");
    let version = bench.good("--version");
    assert!(version.contains("rust"), "{version}");
    if Backend::Ceres.available() {
        assert!(version.contains("ceres 2."), "{version}");
        return;
    }
    assert!(version.contains("no ceres"), "{version}");
    bench.scratch.file("a.g2o", "VERTEX_SE2 0 0 0 0\n");
    for arguments in [
        "crosscheck run/map.npz -c run/corrections.jsonl --report r.json",
        "correct run/map.npz -c run/corrections.jsonl -o o.npz --solver ceres",
        "optimize a.g2o -o b.g2o --solver ceres",
    ] {
        bench.refused(arguments, &["solver: found ceres", "libceres-dev"]);
    }
    bench.good("correct run/map.npz -c run/corrections.jsonl -o o.npz");
}
