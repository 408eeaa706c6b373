use hitl_slam::geometry::Vec2;
use hitl_slam::io::corrections;
use hitl_slam::map::{Correction, Mode, Stroke};

use crate::support::{Scratch, message};

const STROKES: &str = r#""a": [[0, 0], [1, 0]], "b": {"pose": 3, "points": [[0, 0], [1, 0.5]]}"#;

#[test]
fn all_kinds_of_strokes_are_read_and_written() {
    let scratch = Scratch::new("corrections-round-trip");
    let points = [Vec2::new(0.5, -1e-7), Vec2::new(1e3, 2.25)];
    let strokes = [
        Stroke::World(points),
        Stroke::Pose { pose: 4, points },
        Stroke::Stamp { stamp_s: 976052857.33753, points },
    ];
    let correction = |k: usize| Correction {
        id: format!("Wall \"{k}\""),
        mode: Mode::ALL[k],
        a: strokes[k % 3],
        b: strokes[(k + 1) % 3],
        weight: 0.5 + k as f64,
        enabled: k != 2,
    };
    let all: Vec<Correction> = (0..4).map(correction).collect();
    let path = scratch.path("c.jsonl");
    corrections::write(&path, &all).unwrap();
    assert_eq!(corrections::read(&path).unwrap().value, all);
}

#[test]
fn what_may_be_left_out_has_its_default() {
    let scratch = Scratch::new("corrections-defaults");
    let line = |more: &str| format!("{{\"mode\": \"parallel\", {STROKES}{more}}}\n");
    let text = format!("{}\n  \n{}{}", line(""), line(", \"id\": \"c3\""), line(""));
    let read = corrections::read(&scratch.file("c.jsonl", text)).unwrap().value;
    assert_eq!(read.iter().map(|c| c.id.as_str()).collect::<Vec<_>>(), ["c1", "c3", "c3_"]);
    assert!(read.iter().all(|c| c.weight == 1.0 && c.enabled && c.mode == Mode::Parallel));
}

#[test]
fn faults_are_named_with_line_and_field() {
    let scratch = Scratch::new("corrections-errors");
    let with = |more: &str| format!("{{\"mode\": \"parallel\", {STROKES}, {more}}}");
    let strokes = |a: &str| format!("{{\"mode\": \"parallel\", \"a\": {a}, \"b\": [[0, 0], [1, 0]]}}");
    let two = "two points [[x, y], [x, y]] in metres";
    let cases = [
        (
            format!("{{\"mode\": \"colinear\", {STROKES}}}"),
            "mode: found \"colinear\", expected one of colocation, collinear, perpendicular, parallel".into(),
        ),
        (
            format!("{{{STROKES}}}"),
            "mode: found nothing, expected one of colocation, collinear, perpendicular, parallel".into(),
        ),
        (with("\"weight\": 0"), "weight: found 0, expected a number > 0".into()),
        (with("\"weight\": -1.5"), "weight: found -1.5, expected a number > 0".into()),
        (with("\"weight\": \"1\""), "weight: found \"1\", expected a number > 0".into()),
        (with("\"id\": 4"), "id: found 4, expected a non-empty text".into()),
        (with("\"id\": \"first\""), "id: found 'first' a second time, expected each id once".into()),
        (with("\"enabled\": 1"), "enabled: found 1, expected true or false".into()),
        (
            with("\"wieght\": 1"),
            "wieght: found an unknown field, expected mode, a, b, weight, id, enabled".into(),
        ),
        (
            with("\"event\": \"undo\""),
            "event: found a session event, expected a correction: a session begins with its event `session`"
                .into(),
        ),
        (
            strokes("[[1, 2], [1, 2]]"),
            "a: found a stroke of zero length, expected two different points".into(),
        ),
        (strokes("[[1, 2]]"), format!("a: found [[1,2]], expected {two}")),
        (strokes("[[1, 2], [1, null]]"), format!("a: found [[1,2],[1,null]], expected {two}")),
        (
            strokes("4"),
            "a: found 4, expected a stroke: [[x, y], [x, y]] or an object with pose or stamp".into(),
        ),
        (
            strokes("{\"pose\": -1, \"points\": [[0, 0], [1, 0]]}"),
            "a: pose: found -1, expected an index of 0 or more".into(),
        ),
        (
            strokes("{\"pose\": 1.5, \"points\": [[0, 0], [1, 0]]}"),
            "a: pose: found 1.5, expected an index of 0 or more".into(),
        ),
        (strokes("{\"pose\": 1}"), format!("a: points: found nothing, expected {two}")),
        (
            strokes("{\"points\": [[0, 0], [1, 0]]}"),
            "a: found neither pose nor stamp, expected one of them".into(),
        ),
        (
            strokes("{\"pose\": 1, \"stamp\": 2, \"points\": [[0, 0], [1, 0]]}"),
            "a: found both pose and stamp, expected one of them".into(),
        ),
        (
            strokes("{\"stamp\": \"x\", \"points\": [[0, 0], [1, 0]]}"),
            "a: stamp: found \"x\", expected seconds".into(),
        ),
        (
            strokes("{\"pose\": 1, \"poinst\": [[0, 0], [1, 0]]}"),
            "a: poinst: found an unknown field, expected pose, stamp, points".into(),
        ),
        (strokes("[[0, 0], [1e308, 1e308]]"), "a: found a stroke of infinite length, expected metres".into()),
        ("[1]".into(), "found [1], expected a JSON object".into()),
    ];
    for (line, expected) in cases {
        let first = with("\"id\": \"first\"");
        let path = scratch.file("c.jsonl", format!("{first}\n{line}\n"));
        let found = message(corrections::read(&path));
        assert_eq!(found, format!("c.jsonl:2: {expected}"));
    }
    for line in ["{\"mode\": ", "NaN", "[[1, NaN], [2, 3]]", "{\"weight\": 1e999}"] {
        let found = message(corrections::read(&scratch.file("c.jsonl", line)));
        assert!(found.starts_with("c.jsonl:1: found text that is not JSON ("), "{found}");
    }
}
