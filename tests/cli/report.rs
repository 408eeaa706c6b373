//! The reports, field by field.

use serde_json::Value;

use super::Bench;

const TOP: [&str; 12] = [
    "version",
    "solver",
    "formulation",
    "settings",
    "poses",
    "observations",
    "corrections",
    "automatic_factors",
    "reassociate_ms",
    "total_ms",
    "peak_rss_mb",
    "uncertainty",
];
const ENTRY: [&str; 22] = [
    "id",
    "mode",
    "accepted",
    "reason",
    "poses_a",
    "poses_b",
    "observations_a",
    "observations_b",
    "offset_before_m",
    "offset_after_m",
    "angle_before_rad",
    "angle_after_rad",
    "chi2",
    "iterations",
    "termination",
    "initial_cost",
    "final_cost",
    "interpret_ms",
    "explicit_ms",
    "copslam_ms",
    "optimize_ms",
    "total_ms",
];

fn has_all(value: &Value, fields: &[&str]) {
    for field in fields {
        assert!(value.get(field).is_some(), "{field} is not in {value}");
    }
}

/// Accepted colocation, rejected, disabled, accepted perpendicular and parallel: in that order.
fn mixed(bench: &Bench) -> String {
    let text = bench.text("run/corrections.jsonl");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let far = r#"{"mode": "collinear", "id": "far", "a": [[900, 900], [901, 900]], "b": [[0, 0], [1, 0]]}"#;
    lines.insert(1, far.to_owned());
    lines.insert(2, far.replace("\"far\"", "\"off\", \"enabled\": false"));
    lines.join("\n") + "\n"
}

#[test]
fn the_report_of_correct_has_every_field_of_the_contract_with_its_type() {
    let bench = Bench::with_loop("report-fields");
    bench.scratch.file("c.jsonl", mixed(&bench));
    let text = bench.good("correct run/map.npz -c c.jsonl -o o.npz --report -");
    let report: Value = serde_json::from_str(&text).unwrap();
    has_all(&report, &TOP);
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&report["solver"], &report["formulation"]), (&"rust".into(), &"smooth".into()));
    let map = bench.map("run/map.npz");
    assert_eq!(report["poses"], map.poses.len());
    assert_eq!(report["observations"], map.observations.len());
    assert_eq!(report["automatic_factors"], Value::Array(vec![]));
    for field in ["reassociate_ms", "total_ms", "peak_rss_mb"] {
        assert!(report[field].as_f64().is_some_and(|v| v >= 0.0), "{field}");
    }
    let entries = report["corrections"].as_array().unwrap();
    for entry in entries {
        has_all(entry, &ENTRY);
        let is = |field: &str, fits: fn(&Value) -> bool| assert!(fits(&entry[field]), "{field} in {entry}");
        is("id", Value::is_string);
        is("mode", Value::is_string);
        is("accepted", Value::is_boolean);
        for field in ["poses_a", "poses_b", "observations_a", "observations_b", "iterations"] {
            is(field, Value::is_u64);
        }
        for field in ["interpret_ms", "explicit_ms", "copslam_ms", "optimize_ms", "total_ms"] {
            is(field, Value::is_f64);
        }
    }
}

#[test]
fn corrections_are_reported_in_order_and_null_where_there_is_no_number() {
    let bench = Bench::with_loop("report-order");
    bench.scratch.file("c.jsonl", mixed(&bench));
    bench.good("correct run/map.npz -c c.jsonl -o o.npz --report r.json");
    let report = bench.json("r.json");
    let entries = report["corrections"].as_array().unwrap();
    let ids: Vec<&str> = entries.iter().map(|e| e["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["c1", "far", "off", "c2", "c3"]);
    let [c1, far, off, c2, c3] = &entries[..] else { panic!("five") };
    for accepted in [c1, c2, c3] {
        assert_eq!((&accepted["accepted"], &accepted["reason"]), (&true.into(), &Value::Null));
        assert!(accepted["termination"].is_string());
        for field in ["angle_before_rad", "angle_after_rad", "chi2", "initial_cost", "final_cost"] {
            assert!(accepted[field].is_f64(), "{field} in {accepted}");
        }
    }
    assert!(c1["offset_before_m"].as_f64() > c1["offset_after_m"].as_f64());
    for free in [c2, c3] {
        assert!(free["offset_before_m"].is_null() && free["offset_after_m"].is_null(), "{free}");
    }
    for not_applied in [far, off] {
        assert_eq!(not_applied["accepted"], false);
        for field in [
            "offset_before_m",
            "offset_after_m",
            "angle_before_rad",
            "angle_after_rad",
            "chi2",
            "termination",
            "initial_cost",
            "final_cost",
        ] {
            assert!(not_applied[field].is_null(), "{field} in {not_applied}");
        }
    }
    assert_eq!(off["reason"], "disabled");
    assert!(far["reason"].as_str().unwrap().starts_with("stroke a: "), "{far}");
}

#[test]
fn the_settings_are_echoed() {
    let bench = Bench::with_loop("report-settings");
    let flags = "--drawing-sigma-m 0.0625 --min-points 5 --observation-sigma-m 0.125 --normalization mean \
                 --tie-sigma-m 0.25 --offset-sigma-m 0.5 --angle-sigma-rad 0.03125 --loss huber --loss-scale 3 \
                 --max-iterations 7 --no-initial-guess";
    bench.good(&format!("correct run/map.npz -c run/corrections.jsonl -o o.npz --report r.json {flags}"));
    let settings = &bench.json("r.json")["settings"];
    for (field, value) in [
        ("drawing_sigma_m", Value::from(0.0625)),
        ("min_points", 5.into()),
        ("min_points_used", 5.into()),
        ("observation_sigma_m", 0.125.into()),
        ("normalization", "mean".into()),
        ("tie_sigma_m", 0.25.into()),
        ("offset_sigma_m", 0.5.into()),
        ("angle_sigma_rad", 0.03125.into()),
        ("loss", "huber".into()),
        ("loss_scale", 3.0.into()),
        ("max_iterations", 7.into()),
        ("no_initial_guess", true.into()),
    ] {
        assert_eq!(settings[field], value, "{field}");
    }
    bench.good("correct run/map.npz -c run/corrections.jsonl -o o.npz --report r.json");
    let settings = &bench.json("r.json")["settings"];
    assert!(settings["min_points"].is_null() && settings["min_points_used"].is_u64());
}

#[test]
fn the_report_of_evaluate_has_what_was_asked_for_and_no_more() {
    let bench = Bench::with_loop("report-evaluate");
    bench.good("evaluate run/map.npz --report r.json");
    let report = bench.json("r.json");
    assert!(report["worst_edge_m"].is_f64());
    assert!(report.get("ate_rmse_m").is_none() && report.get("relations").is_none(), "{report}");
    bench.scratch.file("relations", "0 1 0 0 0 0 0 0\n0 100 0 0 0 0 0 0\n");
    let text = bench
        .good("evaluate run/map.npz --truth run/truth.tum --relations relations --report - --plot e.svg");
    let report: Value = serde_json::from_str(&text).unwrap();
    let errors = ["ate_rmse_m", "ate_max_m", "heading_rmse_rad", "rpe_trans_rmse_m", "rpe_rot_rmse_rad"];
    has_all(&report, &errors);
    has_all(
        &report["relations"],
        &[
            "count",
            "translation_mean_m",
            "translation_std_m",
            "rotation_mean_deg",
            "rotation_std_deg",
            "translation_median_m",
            "translation_worst_m",
            "by_span",
        ],
    );
    has_all(
        &report["relations"]["by_span"][0],
        &["from_s", "to_s", "count", "translation_mean_m", "rotation_mean_deg"],
    );
    assert!(bench.exists("e.svg"));
}
