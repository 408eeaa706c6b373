use std::fs;

use hitl_slam::io::g2o;
use hitl_slam::map::{Observations, SlamMap};

use crate::support::{Dice, Scratch, message, shared};

#[test]
fn a_graph_comes_back_as_it_was_written() {
    let scratch = Scratch::new("g2o-round-trip");
    for seed in 0..20 {
        let map = Dice::new(seed).map(30);
        let path = scratch.path("a.g2o");
        g2o::write(&path, &map).unwrap();
        let read = g2o::read(&path).unwrap();
        assert!(read.warnings.is_empty());
        let expected = SlamMap {
            poses: map.poses.clone(),
            vertex_ids: map.vertex_ids.clone(),
            held: map.held.clone(),
            relative_factors: map.every_relative_factor().copied().collect(),
            observations: Observations::empty(30),
            ..SlamMap::default()
        };
        assert_eq!(read.value, expected);
    }
}

#[test]
fn ids_order_duplicates_and_fix_are_kept_to_the_byte() {
    let scratch = Scratch::new("g2o-bytes");
    let text = "VERTEX_SE2 7 0.5 0 0\nVERTEX_SE2 -3 1 0 3.141592653589793\nFIX -3\n\
                EDGE_SE2 -3 7 1 0.25 0.125 2 0.5 0 3 0 4\nEDGE_SE2 -3 7 1 0.25 0.125 2 0.5 0 3 0 4\n";
    let read = g2o::read(&scratch.file("a.g2o", text)).unwrap();
    g2o::write(&scratch.path("b.g2o"), &read.value).unwrap();
    assert_eq!(fs::read_to_string(scratch.path("b.g2o")).unwrap(), text);
}

#[test]
fn a_vertex_may_come_after_its_edges_and_unknown_tags_warn_once() {
    let scratch = Scratch::new("g2o-order");
    let text = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nWHAT 1\nWHAT 2\nVERTEX_SE2 1 0 0 0\nVERTEX_SE2 0 0 0 0\n\
                EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n";
    let read = g2o::read(&scratch.file("a.g2o", text)).unwrap();
    assert_eq!((read.value.relative_factors[0].i, read.value.relative_factors[0].j), (1, 0));
    assert_eq!(read.warnings.len(), 2, "{:?}", read.warnings);
    assert!(read.warnings[0].ends_with("a.g2o:2: unknown tag WHAT: its lines are skipped"));
    assert!(read.warnings[1].ends_with("a.g2o:6: the edge joins vertex 1 to itself: dropped"));
}

#[test]
fn scans_after_the_vertices_give_their_stamps() {
    let scratch = Scratch::new("g2o-stamps");
    let scan =
        |t: f64| format!("ROBOTLASER1 0 -1.57 3.14 1.57 80 0 0 1 5 0 0 0 0 0 0 0 0 0 0 0 0 {t} host 0\n");
    let text = format!("VERTEX_SE2 0 0 0 0\n{}VERTEX_SE2 1 0 0 0\n{}", scan(5.5), scan(6.25));
    let read = g2o::read(&scratch.file("a.g2o", text)).unwrap();
    assert_eq!(read.value.stamps_s, Some(vec![5.5, 6.25]));
    let text = format!("VERTEX_SE2 0 0 0 0\n{}VERTEX_SE2 1 0 0 0\n", scan(5.5));
    let read = g2o::read(&scratch.file("a.g2o", text)).unwrap();
    assert_eq!(read.value.stamps_s, None);
    assert!(read.warnings[0].contains("only 1 of 2 vertices have a stamp"));
}

#[test]
fn faults_are_named_with_line_and_field() {
    let scratch = Scratch::new("g2o-errors");
    let cases = [
        ("VERTEX_SE2 2 1 0", "VERTEX_SE2: found 3 fields, expected 4 after the tag"),
        ("VERTEX_SE2 2 1 0 0 9", "VERTEX_SE2: found 5 fields, expected 4 after the tag"),
        ("VERTEX_SE2 2.5 1 0 0", "VERTEX_SE2: id: found '2.5', expected a whole number"),
        ("VERTEX_SE2 2 1 nan 0", "VERTEX_SE2: y: found 'nan', expected a finite number"),
        ("VERTEX_SE2 1 0 0 0", "VERTEX_SE2: found vertex 1 a second time, expected each id once"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0", "EDGE_SE2: found 10 fields, expected 11 after the tag"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 inf", "EDGE_SE2: tt: found 'inf', expected a finite number"),
        ("EDGE_SE2 0 1 1 0 x 1 0 0 1 0 1", "EDGE_SE2: theta: found 'x', expected a finite number"),
        (
            "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1",
            "EDGE_SE2: information matrix: found one that is not positive definite, expected a positive definite one",
        ),
        ("EDGE_SE2 0 9 1 0 0 1 0 0 1 0 1", "found vertex 9, expected one that the file defines"),
        ("FIX", "FIX: found no id, expected at least one"),
        ("FIX 4", "found vertex 4, expected one that the file defines"),
        ("ROBOTLASER1 0 1", "ROBOTLASER1: field of view: found the end of the line"),
    ];
    for (line, expected) in cases {
        let path = scratch.file("a.g2o", format!("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n{line}\n"));
        assert_eq!(message(g2o::read(&path)), format!("a.g2o:3: {expected}"));
    }
    assert_eq!(
        message(g2o::read(&scratch.file("a.g2o", "# x\n"))),
        "a.g2o: poses: found none, expected at least one"
    );
}

#[test]
fn the_public_graphs_are_read_whole() {
    for (name, vertices, edges) in [
        ("INTEL", 1_228, 1_483),
        ("MITb", 808, 827),
        ("CSAIL", 1_045, 1_172),
        ("FR079", 989, 1_217),
        ("M3500", 3_500, 5_453),
        ("city10000", 10_000, 20_687),
        ("kitti_00", 4_541, 4_677),
        ("ais2klinik", 15_115, 16_727),
        ("bicocca/Bicocca25b_GT_GPS", 6_580, 6_579),
    ] {
        let Some(path) = shared(&format!("g2o_2d/{name}.g2o.xz")) else { return };
        let read = g2o::read(&path).unwrap();
        assert_eq!(read.warnings, [""; 0], "{name}");
        assert_eq!((read.value.poses.len(), read.value.relative_factors.len()), (vertices, edges), "{name}");
    }
}

/// 192 of the false closures that were put into this public file have an indefinite information matrix (checked in
/// exact arithmetic): it is refused at the first of them, not repaired.
#[test]
fn a_public_graph_with_indefinite_information_is_refused_at_its_line() {
    let Some(path) = shared("g2o_2d/bicocca/B25b_0.000-lc-312-type-random-n-1.g2o.xz") else { return };
    let expected = "B25b_0.000-lc-312-type-random-n-1.g2o.xz:17162: EDGE_SE2: information matrix: \
                    found one that is not positive definite, expected a positive definite one";
    assert_eq!(message(g2o::read(&path)), expected);
}
