//! The commands that reproduce the paper: scenarios, walls, inconsistency, figures, export.

use super::Bench;

#[test]
fn lost_poses_are_found_again_and_the_walls_say_so() {
    let bench = Bench::new("lost-poses");
    bench.good("simulate lost-poses --seed 1 -o run");
    bench.good("correct run/map.npz -c run/corrections.jsonl -o out.npz --strict");
    let walls = |map: &str| {
        let printed = bench
            .good(&format!("evaluate {map} --truth run/truth.tum --walls run/walls.csv --report r.json"));
        assert!(printed.contains("wall pairs") && printed.contains("mean of 6"), "{printed}");
        bench.json("r.json")["walls"].clone()
    };
    let (before, after) = (walls("run/map.npz"), walls("out.npz"));
    assert_eq!((after["angle_count"].as_u64(), after["distance_count"].as_u64()), (Some(6), Some(2)));
    let number = |walls: &serde_json::Value, name: &str| walls[name].as_f64().unwrap();
    assert!(
        number(&before, "angle_mean_deg") > 2.0 && number(&after, "angle_mean_deg") < 0.7,
        "{before} {after}"
    );
    assert!(number(&after, "distance_mean_m") < 0.03, "{after}");
    bench.refused("evaluate out.npz --truth run/truth.tum --walls run/pairs.csv", &["pairs.csv:1: "]);
}

#[test]
fn inconsistency_reports_what_the_contract_names_and_falls() {
    let bench = Bench::with_loop("inconsistency");
    bench.good("correct run/map.npz -c run/corrections.jsonl -o out.npz");
    let measure = |map: &str| {
        let report: serde_json::Value =
            serde_json::from_str(&bench.good(&format!("inconsistency {map} --report -"))).unwrap();
        assert_eq!(
            (report["resolution_m"].as_f64(), report["free_margin_m"].as_f64()),
            (Some(0.05), Some(0.3))
        );
        let (area, pairs) = (report["inconsistency_m2"].as_f64().unwrap(), report["pairs"].as_u64().unwrap());
        assert!((area - 0.0025 * pairs as f64).abs() < 1e-6);
        area
    };
    assert!(measure("out.npz") < 0.5 * measure("run/map.npz"));
    assert!(bench.good("inconsistency out.npz").contains("m²"));
    bench.refused("inconsistency out.npz --resolution-m 0", &["--resolution-m"]);
}

#[test]
fn the_information_matrix_and_the_heat_map_are_drawn() {
    let bench = Bench::with_loop("figures");
    bench.good("correct run/map.npz -c run/corrections.jsonl -o out.npz");
    bench.good("render out.npz --information -o i.svg --size-px 300");
    let svg = bench.text("i.svg").to_lowercase();
    for colour in ["#3d8bff", "#2fc46b", "#f2a01e"] {
        assert!(svg.contains(colour), "colocation, perpendicular, parallel: {colour}");
    }
    assert!(!svg.contains("#e83fc8"), "no collinear correction");
    bench.good("render run/map.npz --inconsistency -o h.png --size-px 300");
    bench.refused("render out.npz --information --before run/map.npz -o i.png", &["--information"]);
}

#[test]
fn export_writes_every_format_by_its_extension() {
    let bench = Bench::with_loop("export");
    for (name, head) in [
        ("e.clf", "# CARMEN"),
        ("e.ply", "ply\n"),
        ("e.pgm", "P5\n"),
        ("e.g2o", "VERTEX_SE2 0 "),
        ("e.tum", "0 "),
        ("e.stfs.covars", "hitl-slam\n"),
        ("e.npz", "PK"),
    ] {
        bench.good(&format!("export run/map.npz -o {name}"));
        assert!(bench.bytes(name).starts_with(head.as_bytes()), "{name}");
    }
    assert!(bench.text("e.yaml").contains("image: e.pgm\n") && bench.text("e.yaml").contains(", 0.0]"));
    // A corrected log is a log again.
    assert!(bench.good("info e.clf").contains("CARMEN log"));
    bench.good("import e.clf --front-end none -o again.npz");
    bench.refused("export run/map.npz -o e.xyz", &["e.xyz", ".pgm"]);
    bench.refused("export run/map.npz -o e.ply --log e.clf", &["--log"]);
}
