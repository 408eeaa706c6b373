//! `hitl optimize`: plain pose graphs from file to file.

use hitl_slam::joint::Backend;
use serde_json::Value;

use super::Bench;
use crate::support::shared;

const FIELDS: [&str; 9] = [
    "edges",
    "final_chi2",
    "initial_chi2",
    "iterations",
    "load_ms",
    "optimize_ms",
    "order_ms",
    "termination",
    "vertices",
];

/// A closed square of four vertices, ids out of order, one edge twice, two of the corners held.
const SQUARE: &str = "VERTEX_SE2 40 0 0 0\nVERTEX_SE2 -2 1.1 0.05 1.5\nVERTEX_SE2 7 0.9 1.1 3.1\n\
    VERTEX_SE2 9 0 1 -1.6\nFIX 7\nFIX 40\n\
    EDGE_SE2 40 -2 1 0 1.5707963267948966 100 10 5 90 4 400\n\
    EDGE_SE2 -2 7 1 0 1.5707963267948966 100 0 0 100 0 400\n\
    EDGE_SE2 7 9 1.02 0 1.5707963267948966 100 0 0 100 0 400\n\
    EDGE_SE2 9 40 1 0.01 1.5707963267948966 100 0 0 100 0 400\n\
    EDGE_SE2 9 40 1 0.01 1.5707963267948966 100 0 0 100 0 400\n";

/// `with_solver("optimize a -o b")` on every back end that is there.
fn solvers() -> impl Iterator<Item = &'static str> {
    [Backend::Rust, Backend::Ceres].into_iter().filter(|b| b.available()).map(Backend::name)
}

/// Lines that begin with a tag.
fn lines<'a>(text: &'a str, tag: &str) -> Vec<&'a str> {
    text.lines().filter(|l| l.starts_with(tag)).collect()
}

#[test]
fn the_report_has_exactly_the_fields_of_the_contract() {
    let bench = Bench::new("optimize-report");
    bench.scratch.file("a.g2o", SQUARE);
    for solver in solvers() {
        let printed = bench.good(&format!("optimize a.g2o -o b.g2o --solver {solver} --report r.json"));
        let report = bench.json("r.json");
        let mut found: Vec<&String> = report.as_object().unwrap().keys().collect();
        found.sort_unstable();
        assert_eq!(found, FIELDS.iter().collect::<Vec<_>>());
        assert_eq!((&report["vertices"], &report["edges"]), (&4.into(), &5.into()));
        let chi2 = ["initial_chi2", "final_chi2"].map(|f| report[f].as_f64().unwrap());
        assert!(chi2[1] < chi2[0], "{chi2:?}");
        assert!(report["termination"].as_str().unwrap().starts_with("converged_"), "{report}");
        assert!(printed.starts_with("4 vertices, 5 edges\nchi2 "), "{printed}");
        let run = bench.hitl(&format!("optimize a.g2o -o c.g2o --solver {solver} --report -"));
        let again: Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(again["final_chi2"], report["final_chi2"]);
        assert_eq!(run.stderr, "");
    }
}

#[test]
fn ids_edges_their_order_and_what_is_fixed_are_kept() {
    let bench = Bench::new("optimize-kept");
    bench.scratch.file("a.g2o", SQUARE);
    for solver in solvers() {
        bench.good(&format!("optimize a.g2o -o b.g2o --solver {solver}"));
        let after = bench.text("b.g2o");
        assert_eq!(lines(&after, "EDGE_SE2"), lines(SQUARE, "EDGE_SE2"));
        let id = |l: &&str| l.split(' ').nth(1).unwrap().to_owned();
        let ids = |text: &str| lines(text, "VERTEX_SE2").iter().map(id).collect::<Vec<_>>();
        assert_eq!(ids(&after), ids(SQUARE));
        let (before, after) = (lines(SQUARE, "VERTEX_SE2"), lines(&after, "VERTEX_SE2"));
        for (k, is_held) in [(0, true), (1, false), (2, true), (3, false)] {
            assert_eq!(before[k] == after[k], is_held, "{}", after[k]);
        }
    }
}

#[test]
fn a_vertex_fixed_alone_frees_the_first() {
    let bench = Bench::new("optimize-fix");
    bench.scratch.file("a.g2o", SQUARE.replace("FIX 40\n", ""));
    for solver in solvers() {
        bench.good(&format!("optimize a.g2o -o b.g2o --solver {solver}"));
        let after = bench.text("b.g2o");
        assert!(after.contains("VERTEX_SE2 7 0.9 1.1 3.1\n"), "{after}");
        assert!(!after.contains("VERTEX_SE2 40 0 0 0\n"), "{after}");
    }
}

#[test]
fn a_toro_graph_and_the_same_in_g2o_have_the_same_minimum() {
    let bench = Bench::new("optimize-toro");
    // TORO cannot hold a vertex: without FIX both hold the first.
    bench.scratch.file("a.g2o", SQUARE.replace("FIX 7\nFIX 40\n", ""));
    bench.good("import a.g2o -o a.graph");
    assert!(bench.text("a.graph").contains("EDGE2 40 -2 1 0 1.5707963267948966 100 10 90 400 5 4\n"));
    for solver in solvers() {
        let chi2 = |graph: &str, out: &str| {
            bench.good(&format!("optimize {graph} -o {out} --solver {solver} --report r.json"));
            bench.json("r.json")["final_chi2"].as_f64().unwrap()
        };
        assert_eq!(chi2("a.graph", "b.toro"), chi2("a.g2o", "b.g2o"));
        assert!(bench.text("b.toro").starts_with("VERTEX2 40 0 0 0\n"));
    }
    let printed = bench.good("info a.graph");
    assert!(printed.contains("TORO pose graph"), "{printed}");
}

#[test]
fn an_unknown_tag_warns_once() {
    let bench = Bench::new("optimize-tags");
    bench.scratch.file("a.g2o", format!("{SQUARE}WHAT 1\nWHAT 2\nWHAT 3\n"));
    let run = bench.hitl("optimize a.g2o -o b.g2o");
    assert_eq!(run.code, Some(0));
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(run.stderr.contains("a.g2o:12: unknown tag WHAT"), "{}", run.stderr);
}

#[test]
fn every_separate_part_is_held_and_it_is_said() {
    let bench = Bench::new("optimize-parts");
    let part =
        "VERTEX_SE2 50 5 5 0\nVERTEX_SE2 51 6.2 5 0\nVERTEX_SE2 60 9 9 1\nEDGE_SE2 50 51 1 0 0 1 0 0 1 0 1\n";
    bench.scratch.file("a.g2o", format!("{SQUARE}{part}"));
    for solver in solvers() {
        let run = bench.hitl(&format!("optimize a.g2o -o b.g2o --solver {solver}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stderr.contains("separate parts") && run.stderr.lines().count() == 1, "{}", run.stderr);
        let after = bench.text("b.g2o");
        assert!(
            after.contains("VERTEX_SE2 50 5 5 0\n") && after.contains("VERTEX_SE2 60 9 9 1\n"),
            "{after}"
        );
        let moved = lines(&after, "VERTEX_SE2 51 ")[0];
        let numbers: Vec<f64> = moved.split(' ').skip(2).map(|w| w.parse().unwrap()).collect();
        let distance = [6.0, 5.0, 0.0].iter().zip(&numbers).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(distance < 1e-9, "{moved}");
    }
}

#[test]
fn what_has_not_converged_says_so() {
    let bench = Bench::new("optimize-stopped");
    bench.scratch.file("a.g2o", SQUARE);
    for solver in solvers() {
        let line = format!("optimize a.g2o -o b.g2o --solver {solver} --max-iterations 1 --report r.json");
        let printed = bench.good(&line);
        assert!(printed.contains("(max iterations, not converged)"), "{printed}");
        assert_eq!(bench.json("r.json")["termination"], "max_iterations");
    }
}

/// A corridor of ten vertices, there and back, with a right and a wrong closure and one of impossible information.
fn corridor() -> String {
    let mut text = String::new();
    for k in 0..10 {
        text += &format!("VERTEX_SE2 {} {k} 0 0\n", 100 + k);
    }
    for k in 0..9 {
        text += &format!("EDGE_SE2 {} {} 1 0 0 100 0 0 100 0 400\n", 100 + k, 101 + k);
    }
    text + "EDGE_SE2 100 109 9.1 0 0 100 0 0 100 0 400\nEDGE_SE2 102 107 0 3 1 100 0 0 100 0 400\n"
}

#[test]
fn false_closures_are_reported_by_the_ids_of_the_file() {
    let bench = Bench::new("optimize-outliers");
    bench.scratch.file("a.g2o", corridor());
    for solver in solvers() {
        let line = format!("optimize a.g2o -o b.g2o --solver {solver} --report r.json");
        bench.good(&line);
        assert_eq!(bench.json("r.json")["robust"], Value::Null);
        for how in ["--gnc", "--loss cauchy", "--loss geman-mcclure --loss-width 1.5", "--loss huber"] {
            let printed = bench.good(&format!("{line} {how}"));
            assert!(
                printed.contains("outliers: 1 of 2 doubted edges (chi2 above 11.34): 102–107\n"),
                "{how}: {printed}"
            );
            let robust = &bench.json("r.json")["robust"];
            let outlier = &robust["outliers"][0];
            assert_eq!(
                (&outlier["edge"], &outlier["from"], &outlier["to"]),
                (&10.into(), &102.into(), &107.into())
            );
            assert!(outlier["chi2"].as_f64().unwrap() > robust["chi2_threshold"].as_f64().unwrap());
            assert!(how.contains(robust["method"].as_str().unwrap()), "{robust}");
            assert_eq!(lines(&bench.text("b.g2o"), "EDGE_SE2"), lines(&corridor(), "EDGE_SE2"));
        }
        assert!(bench.good(&format!("{line} --gnc --doubt-odometry")).contains("of 11 doubted edges"));
    }
}

#[test]
fn impossible_information_is_refused_unless_it_may_be_repaired() {
    let bench = Bench::new("optimize-repair");
    bench.scratch.file("a.g2o", corridor() + "EDGE_SE2 101 105 4 0 0 100 0 0 -50 0 400\n");
    bench.refused("optimize a.g2o -o b.g2o", &["a.g2o:22: EDGE_SE2: information matrix"]);
    let run = bench.hitl("optimize a.g2o -o b.g2o --repair-information");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("a.g2o:22: information matrix: not positive definite"), "{}", run.stderr);
    let repaired = bench.text("b.g2o").lines().last().unwrap().to_owned();
    assert!(repaired.starts_with("EDGE_SE2 101 105 4 0 0 100 0 0 4.0"), "{repaired}");
    assert!(repaired.ends_with("e-7 0 400"), "{repaired}");
}

#[test]
fn refused_runs_write_nothing() {
    let bench = Bench::new("optimize-refused");
    bench.scratch.file("a.g2o", SQUARE);
    bench.scratch.file("bad.g2o", format!("{SQUARE}EDGE_SE2 7 8 1 0 0 1 0 0 1 0 1\n"));
    bench.refused("optimize bad.g2o -o b.g2o", &["bad.g2o:12: found vertex 8"]);
    bench.refused("optimize a.g2o -o b.xyz", &["b.xyz: found no known extension", ".graph"]);
    bench.refused("optimize a.g2o -o b.g2o --max-iterations 0", &["--max-iterations"]);
    assert_eq!(bench.hitl("optimize a.g2o -o b.g2o --solver best").code, Some(2));
    bench.refused("optimize a.g2o -o b.g2o --gnc --inlier-probability 1", &["--inlier-probability: found 1"]);
    bench.refused("optimize a.g2o -o b.g2o --loss huber --loss-width 0", &["--loss-scale: found 0"]);
    assert_eq!(bench.hitl("optimize a.g2o -o b.g2o --gnc --loss huber").code, Some(2));
}

#[test]
fn a_compressed_public_graph_reaches_its_known_minimum() {
    let Some(path) = shared("g2o_2d/CSAIL.g2o.xz") else { return };
    let bench = Bench::new("optimize-public");
    for solver in solvers() {
        bench.good(&format!("optimize {} -o b.g2o --solver {solver} --report r.json", path.display()));
        let chi2 = bench.json("r.json")["final_chi2"].as_f64().unwrap();
        assert!((chi2 - 38.95629).abs() < 1e-4, "{solver}: {chi2}");
    }
}
