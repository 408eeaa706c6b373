use std::fs;

use hitl_slam::io::{g2o, toro};
use hitl_slam::map::{Observations, SlamMap};
use nalgebra::Matrix3;

use crate::support::{Dice, Scratch, message, public_graph};

#[test]
fn a_graph_comes_back_as_it_was_written_but_for_what_is_held() {
    let scratch = Scratch::new("toro-round-trip");
    for seed in 0..20 {
        let map = Dice::new(seed).map(30);
        let path = scratch.path("a.graph");
        toro::write(&path, &map).unwrap();
        let read = toro::read(&path).unwrap();
        assert!(read.warnings.is_empty());
        let expected = SlamMap {
            poses: map.poses.clone(),
            vertex_ids: map.vertex_ids.clone(),
            relative_factors: map.every_relative_factor().copied().collect(),
            observations: Observations::empty(30),
            ..SlamMap::default()
        };
        assert_eq!(read.value, expected);
    }
}

#[test]
fn the_information_is_in_toro_s_own_order() {
    let scratch = Scratch::new("toro-order");
    // ff fs ss rr fr sr = xx xy yy tt xt yt.
    let text = "VERTEX2 7 0.5 0 0\nVERTEX2 -3 1 0 3.141592653589793\n\
                EDGE2 -3 7 1 0.25 0.125 10 1 20 30 2 3\nEDGE2 -3 7 1 0.25 0.125 10 1 20 30 2 3\n";
    let read = toro::read(&scratch.file("a.graph", text)).unwrap().value;
    let expected = Matrix3::new(10.0, 1.0, 2.0, 1.0, 20.0, 3.0, 2.0, 3.0, 30.0);
    assert_eq!(read.relative_factors[0].information.matrix(), expected);
    assert_eq!((read.relative_factors[0].i, read.relative_factors[0].j), (1, 0));
    toro::write(&scratch.path("b.graph"), &read).unwrap();
    assert_eq!(fs::read_to_string(scratch.path("b.graph")).unwrap(), text);
    g2o::write(&scratch.path("b.g2o"), &read).unwrap();
    let same_in_g2o = "EDGE_SE2 -3 7 1 0.25 0.125 10 1 2 20 3 30";
    assert!(fs::read_to_string(scratch.path("b.g2o")).unwrap().lines().any(|l| l == same_in_g2o));
}

#[test]
fn a_public_graph_is_the_same_by_way_of_toro() {
    let Some(map) = public_graph("M3500") else { return };
    let scratch = Scratch::new("toro-public");
    toro::write(&scratch.path("a.toro"), &map).unwrap();
    assert_eq!(toro::read(&scratch.path("a.toro")).unwrap().value, map);
}

#[test]
fn lines_of_other_formats_warn_once() {
    let scratch = Scratch::new("toro-tags");
    let text = "# a comment\nVERTEX2 0 0 0 0\nFIX 0\nFIX 0\nEQUIV 0 0\nVERTEX_SE2 1 0 0 0\n";
    let read = toro::read(&scratch.file("a.graph", text)).unwrap();
    assert_eq!(read.warnings.len(), 3, "{:?}", read.warnings);
    assert!(read.warnings[0].ends_with("a.graph:3: unknown tag FIX: its lines are skipped"));
    assert!(read.value.held.is_empty());
}

#[test]
fn faults_are_named_with_line_and_field() {
    let scratch = Scratch::new("toro-errors");
    let cases = [
        ("VERTEX2 2 1 0", "VERTEX2: found 3 fields, expected 4 after the tag"),
        ("VERTEX2 2.5 1 0 0", "VERTEX2: id: found '2.5', expected a whole number"),
        ("VERTEX2 2 1 nan 0", "VERTEX2: y: found 'nan', expected a finite number"),
        ("VERTEX2 1 0 0 0", "VERTEX2: found vertex 1 a second time, expected each id once"),
        ("EDGE2 0 1 1 0 0 1 0 1 1 0", "EDGE2: found 10 fields, expected 11 after the tag"),
        ("EDGE2 0 1 1 0 0 1 0 1 1 0 inf", "EDGE2: sr: found 'inf', expected a finite number"),
        ("EDGE2 0 1 1 0 x 1 0 1 1 0 0", "EDGE2: rotate: found 'x', expected a finite number"),
        (
            "EDGE2 0 1 1 0 0 1 0 0 1 0 1",
            "EDGE2: information matrix: found one that is not positive definite, expected a positive definite one",
        ),
        ("EDGE2 0 9 1 0 0 1 0 1 1 0 0", "found vertex 9, expected one that the file defines"),
    ];
    for (line, expected) in cases {
        let path = scratch.file("a.graph", format!("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\n{line}\n"));
        assert_eq!(message(toro::read(&path)), format!("a.graph:3: {expected}"));
    }
    let none = message(toro::read(&scratch.file("a.graph", "# x\n")));
    assert_eq!(none, "a.graph: poses: found none, expected at least one");
}
