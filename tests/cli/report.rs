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
    let text = bench.good("correct run/map.npz -c c.jsonl -o o.npz --report - --no-reassociate");
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
fn evaluate_draws_errors_along_the_trajectory_and_says_of_what() {
    let bench = Bench::with_loop("picture-evaluate");
    bench.scratch.file("relations", "0 1 0 0 0 0 0 0\n0 100 0 0 0 0 0 0\n");
    for (reference, legend) in [
        ("--relations relations", "error of a relation at its two poses (m)"),
        ("--truth run/truth.tum", "position error after alignment (m)"),
        ("--truth run/truth.tum --relations relations", "position error after alignment (m)"),
    ] {
        bench.good(&format!("evaluate run/map.npz {reference} --picture e.svg"));
        let svg = std::fs::read_to_string(bench.scratch.path("e.svg")).unwrap();
        assert!(svg.contains(legend), "{reference}: no {legend}");
    }
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

#[test]
fn what_re_association_found_is_listed_with_what_spoke_for_it() {
    let bench = Bench::with_loop("report-automatic");
    let printed = bench.good("correct run/map.npz -c run/corrections.jsonl -o o.npz --report r.json");
    let (report, map) = (bench.json("r.json"), bench.map("o.npz"));
    let listed = report["automatic_factors"].as_array().unwrap();
    assert!(listed.len() > 5 && listed.len() == map.automatic_factors.len());
    assert!(printed.contains(&format!("re-association: {} automatic factors in", listed.len())), "{printed}");
    for (entry, factor) in listed.iter().zip(&map.automatic_factors) {
        let fields = ["name", "i", "j", "inliers", "ambiguity", "weak_direction_rad", "chi2", "agrees"];
        has_all(entry, &fields);
        assert_eq!(entry["name"], factor.name());
        assert!(entry["inliers"].as_f64().is_some_and(|v| (0.55..=1.0).contains(&v)), "{entry}");
    }
    has_all(&report["reassociation"], &["rounds", "near_passes", "withdrawn", "footprints"]);
    has_all(
        &report["reassociation"]["rounds"][0],
        &["pairs", "accepted", "disagreeing", "moved_m", "widest_m"],
    );
    assert!(report["reassociate_ms"].as_f64().unwrap() > 0.0);
    assert!(bench.good("info o.npz").contains(&format!("{}, all in agreement", listed.len())));

    // Without it: nothing found, and the field says so.
    bench.good("correct run/map.npz -c run/corrections.jsonl -o n.npz --no-reassociate --report n.json");
    let report = bench.json("n.json");
    assert_eq!(report["automatic_factors"], Value::Array(vec![]));
    assert_eq!((&report["reassociation"], &report["reassociate_ms"]), (&Value::Null, &0.0.into()));

    // One that a person does not believe does not come back.
    let name = listed[0]["name"].as_str().unwrap();
    let refuse =
        format!("correct run/map.npz -c run/corrections.jsonl -o f.npz --report f.json --refuse {name}");
    bench.good(&refuse);
    let report = bench.json("f.json");
    assert!(report["automatic_factors"].as_array().unwrap().iter().all(|a| a["name"] != name));
    bench.refused(&refuse.replace(name, "first"), &["--refuse", "found \"first\""]);
    let both = format!("{refuse} --no-reassociate");
    bench.refused(&both, &["--refuse", "found together with --no-reassociate"]);
}

#[test]
fn loops_close_on_import_without_a_stroke() {
    let bench = Bench::with_loop("close-loops");
    let printed = bench.good("import run/map.npz --close-loops -o closed.npz");
    assert!(printed.contains("re-association: "), "{printed}");
    bench.good("evaluate closed.npz --truth run/truth.tum --report after.json");
    bench.good("evaluate run/map.npz --truth run/truth.tum --report before.json");
    let ate_m = |name: &str| bench.json(name)["ate_rmse_m"].as_f64().unwrap();
    assert!(ate_m("after.json") < 0.1 * ate_m("before.json"));
    bench.good("export closed.npz -o closed.g2o");
    let edges = bench.text("closed.g2o").lines().filter(|l| l.starts_with("EDGE_SE2")).count();
    let map = bench.map("closed.npz");
    assert_eq!(edges, map.relative_factors.len() + map.automatic_factors.len());
    // The report: what was found; refused, one less.
    let report: Value =
        serde_json::from_str(&bench.good("import run/map.npz --close-loops -o c.npz --report -")).unwrap();
    let listed = report["automatic_factors"].as_array().unwrap();
    assert_eq!(listed.len(), map.automatic_factors.len());
    let name = listed[0]["name"].as_str().unwrap();
    bench.good(&format!("import run/map.npz --close-loops --refuse {name} -o c.npz"));
    assert!(bench.map("c.npz").automatic_factors.iter().all(|a| a.name() != name));
    bench.refused("import run/map.npz --report r.json -o d.npz", &["--close-loops"]);
    bench.scratch.file("empty.g2o", "VERTEX_SE2 0 0 0 0\n");
    bench.refused("import empty.g2o --close-loops -o o.npz", &["map: points: found none"]);
}

#[test]
fn a_raw_log_becomes_a_closed_map_with_a_pose_for_every_scan() {
    let bench = Bench::with_loop("close-log");
    bench.good("export run/map.npz -o raw.log");
    bench.good("import raw.log --front-end scan-match --close-loops -o closed.npz");
    bench.good("import raw.log --front-end scan-match -o open.npz");
    let (closed, open) = (bench.map("closed.npz"), bench.map("open.npz"));
    assert!(!closed.automatic_factors.is_empty() && closed.scans.len() == open.scans.len());
    let moved =
        closed.scans.iter().zip(&open.scans).filter(|(a, b)| a.parent_from_robot != b.parent_from_robot);
    assert!(moved.count() > 0, "scans between poses are matched again");
}
