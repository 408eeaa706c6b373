//! Sound but unusual maps: corrected, or refused with a reason; never a panic, never a number that is not finite.

use hitl_slam::map::Observations;
use serde_json::Value;

use super::Bench;

/// Corrects `map.npz` with the loop's corrections; returns the report.
fn corrected(bench: &Bench) -> Value {
    let printed =
        bench.hitl("correct map.npz -c run/corrections.jsonl -o o.npz --report r.json --pictures p");
    assert_eq!(printed.code, Some(0), "{}", printed.stdout);
    // Only what a person should know about the map: parts that nothing joins, say.
    assert!(printed.stderr.lines().all(|l| l.starts_with("hitl: note: ")), "{}", printed.stderr);
    bench.map("o.npz").validate("o.npz").unwrap();
    bench.good("evaluate o.npz");
    bench.json("r.json")
}

fn accepted(report: &Value) -> usize {
    report["corrections"].as_array().unwrap().iter().filter(|c| c["accepted"] == true).count()
}

#[test]
fn a_held_pose_does_not_move() {
    let bench = Bench::with_loop("held");
    bench.changed_map("map.npz", |map| map.held = vec![0, 300]);
    let report = corrected(&bench);
    assert_eq!(accepted(&report), 3, "{report}");
    let (before, after) = (bench.map("map.npz"), bench.map("o.npz"));
    assert_eq!((before.poses[0], before.poses[300]), (after.poses[0], after.poses[300]));
    assert_ne!(before.poses[600], after.poses[600]);
}

#[test]
fn where_every_pose_is_held_nothing_moves() {
    let bench = Bench::with_loop("all-held");
    bench.changed_map("map.npz", |map| map.held = (0..map.poses.len()).collect());
    corrected(&bench);
    assert_eq!(bench.map("map.npz").poses, bench.map("o.npz").poses);
}

#[test]
fn a_chain_with_a_missing_edge_is_corrected() {
    let bench = Bench::with_loop("torn");
    bench.changed_map("map.npz", |map| map.relative_factors.retain(|f| f.j != 300));
    assert_eq!(accepted(&corrected(&bench)), 3);
}

#[test]
fn a_map_without_any_factor_is_answered() {
    let bench = Bench::with_loop("loose");
    bench.changed_map("map.npz", |map| map.relative_factors.clear());
    corrected(&bench);
}

#[test]
fn a_map_far_from_the_origin_is_corrected_like_one_at_it() {
    let bench = Bench::with_loop("far");
    bench.changed_map("map.npz", |map| map.poses.iter_mut().for_each(|p| p.x_m += 4e6));
    let report = corrected(&bench);
    assert_eq!(accepted(&report), 3, "{report}");
    assert!(report["corrections"][0]["offset_after_m"].as_f64().unwrap() < 0.05, "{report}");
}

#[test]
fn absurd_numbers_are_answered() {
    for (name, scale) in [("huge", 1e150), ("most", 1e306), ("tiny", 1e-200)] {
        let bench = Bench::with_loop(name);
        bench.changed_map("map.npz", |map| {
            map.poses.iter_mut().for_each(|p| (p.x_m, p.y_m) = (p.x_m * scale, p.y_m * scale));
        });
        corrected(&bench);
        bench.good("render map.npz -o a.png --grid");
        bench.good("info map.npz");
    }
}

#[test]
fn extreme_information_is_answered() {
    for (name, scale) in [("stiff", 1e200), ("soft", 1e-200)] {
        let bench = Bench::with_loop(name);
        bench.changed_map("map.npz", |map| {
            for factor in &mut map.relative_factors {
                let scaled = factor.information.matrix() * scale;
                factor.information = hitl_slam::geometry::Information::new(scaled).unwrap();
            }
        });
        corrected(&bench);
    }
}

#[test]
fn a_map_of_one_pose_is_corrected_within_itself() {
    let bench = Bench::new("one-pose");
    let mut map = super::small_map();
    map.poses.truncate(1);
    map.stamps_s = None;
    map.relative_factors.clear();
    map.scans.clear();
    let o = &mut map.observations;
    let points = o.starts[1] as usize;
    o.starts.truncate(2);
    o.points.truncate(points);
    o.normals.truncate(points);
    o.ranges_m.truncate(points);
    hitl_slam::io::native::write(&bench.scratch.path("one.npz"), &map).unwrap();
    let stroke = "{\"pose\": 0, \"points\": [[0.5, -1.2], [2.5, -1.2]]}";
    bench.scratch.file("c.jsonl", format!("{{\"mode\": \"collinear\", \"a\": {stroke}, \"b\": {stroke}}}\n"));
    bench.good("correct one.npz -c c.jsonl -o o.npz --trajectory o.tum --pictures p");
    assert_eq!(bench.map("o.npz").poses, map.poses);
    assert_eq!(bench.text("o.tum").lines().count(), 1);
    bench.good("evaluate o.npz --truth o.tum");
    bench.good("render o.npz -o o.svg --before one.npz");
}

#[test]
fn strokes_far_away_or_too_short_are_rejected_with_the_reason() {
    let bench = Bench::with_loop("far-strokes");
    let line = |b: &str| {
        format!(
            "{{\"mode\": \"collinear\", \"a\": {{\"pose\": 78, \"points\": [[0.2, -1.2], [3, -1.2]]}}, \"b\": {b}}}\n"
        )
    };
    let far =
        line("[[1e9, 0], [1e9, 1]]") + &line("[[1e150, 0], [1.1e150, 1]]") + &line("[[0, 0], [1e150, 0]]");
    let short = line("[[0, 0], [0, 1e-9]]") + &line("{\"pose\": 626, \"points\": [[0, 0], [0, 1e-9]]}");
    bench.scratch.file("c.jsonl", far + &short);
    bench.good("correct run/map.npz -c c.jsonl -o o.npz --report r.json --no-reassociate");
    let report = bench.json("r.json");
    let reasons: Vec<&str> =
        report["corrections"].as_array().unwrap().iter().map(|c| c["reason"].as_str().unwrap()).collect();
    assert!(reasons[..2].iter().all(|r| r.starts_with("stroke b: no wall within")), "{reasons:?}");
    assert!(reasons[3..].iter().all(|r| r.contains("shorter than the drawing accuracy")), "{reasons:?}");
    assert_eq!(bench.map("o.npz").poses, bench.map("run/map.npz").poses);
}

#[test]
fn a_graph_whose_edges_do_not_follow_the_vertices_keeps_them() {
    let bench = Bench::new("graph");
    let graph = "VERTEX_SE2 9 0 0 0\nVERTEX_SE2 4 1 0 0\nVERTEX_SE2 7 2 0 0\nFIX 7\n\
                 EDGE_SE2 9 7 2 0 0 1 0 0 1 0 1\nEDGE_SE2 7 4 -1 0 0 1 0 0 1 0 1\nEDGE_SE2 7 4 -1 0 0 1 0 0 1 0 1\n";
    bench.scratch.file("a.g2o", graph);
    bench.good("import a.g2o -o b.npz");
    bench.good("import b.npz -o c.g2o");
    assert_eq!(bench.text("c.g2o"), graph);
    let printed = bench.good("info a.g2o");
    assert!(printed.contains("held poses          2\n"), "{printed}");
}

#[test]
fn poses_without_points_are_passed_over() {
    let bench = Bench::with_loop("blind");
    bench.changed_map("map.npz", |map| {
        let whole = std::mem::take(&mut map.observations);
        let mut rest = Observations { starts: vec![0], ..Observations::default() };
        for pose in 0..map.poses.len() {
            for p in whole.range(pose).filter(|_| pose % 3 != 0) {
                rest.push(whole.point(p), whole.normal(p), whole.ranges_m[p].into());
            }
            rest.end_pose();
        }
        map.observations = rest;
    });
    assert_eq!(accepted(&corrected(&bench)), 3);
}
