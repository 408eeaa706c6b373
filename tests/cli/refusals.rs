//! Bad input files: exit code 2, one line that says where, and nothing written.

use super::{Bench, SMALL_CORRECTIONS, small_map};
use crate::support::{Dice, small_log};
use hitl_slam::io;

/// A small valid file of every format, and corrections for the maps.
fn bench_with_files(test: &str) -> Bench {
    let bench = Bench::new(test);
    let map = small_map();
    for name in ["a.npz", "a.g2o", "a.stfs.covars", "a.tum"] {
        io::write_map(&bench.scratch.path(name), &map).unwrap();
    }
    bench.scratch.file("a.log", small_log(20));
    bench.scratch.file("c.jsonl", SMALL_CORRECTIONS);
    bench.scratch.file("o.npz", "what stood here before");
    bench
}

/// Every command that reads a map must refuse `bad` and say `part`.
fn refused_by_all(bench: &Bench, bad: &str, part: &str) {
    bench.refused(&format!("info {bad}"), &[part]);
    bench.refused(&format!("import {bad} -o o.npz"), &[part]);
    bench.refused(&format!("import {bad} -o new/o.g2o"), &[part]);
    bench.refused(&format!("correct {bad} -c c.jsonl -o o.npz --report r.json --trajectory t.tum"), &[part]);
    bench.refused(&format!("evaluate {bad} --report r.json"), &[part]);
    bench.refused(&format!("evaluate a.tum --truth {bad} --report r.json"), &[part]);
    bench.refused(&format!("render {bad} -o r.png"), &[part]);
}

/// `name` with its `line` (from 1) changed.
fn with_line(bench: &Bench, name: &str, line: usize, change: impl Fn(&str) -> String) {
    let text = bench.text(name);
    let lines: Vec<String> =
        text.lines().enumerate().map(|(k, l)| if k + 1 == line { change(l) } else { l.to_owned() }).collect();
    bench.scratch.file(&format!("bad-{name}"), lines.join("\n") + "\n");
}

#[test]
fn files_that_are_not_there_or_are_folders_are_refused() {
    let bench = bench_with_files("absent");
    std::fs::create_dir(bench.scratch.path("folder")).unwrap();
    bench.scratch.file("empty", "");
    refused_by_all(&bench, "absent.npz", "absent.npz: found no such file, expected one that exists");
    refused_by_all(&bench, "folder", "folder: found a folder, expected a file");
    refused_by_all(&bench, "empty", "empty: found an empty file, expected a log or a map");
    refused_by_all(&bench, "c.jsonl", "c.jsonl: found nothing that tells its format");
    bench.refused("correct a.npz -c absent -o o.npz", &["absent: found no such file"]);
    bench.refused("correct a.npz -c folder -o o.npz", &["folder", "found a folder"]);
    bench.refused("evaluate a.npz --relations absent", &["absent: found no such file"]);
}

#[test]
fn cut_off_lines_are_named() {
    let bench = bench_with_files("cut");
    for (name, line) in [("a.g2o", 41), ("a.stfs.covars", 5), ("a.tum", 3), ("a.log", 4)] {
        with_line(&bench, name, line, |l| l[..l.len() / 2].to_owned());
        refused_by_all(&bench, &format!("bad-{name}"), &format!("bad-{name}:{line}: "));
    }
    let whole = bench.bytes("a.npz");
    bench.scratch.file("bad.npz", &whole[..whole.len() / 2]);
    refused_by_all(&bench, "bad.npz", "bad.npz: found a damaged or cut-off archive");
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    let bench = bench_with_files("finite");
    for bad in ["nan", "inf", "-inf", "1e999", "x", "1,5"] {
        for (name, line, separator, field) in
            [("a.g2o", 41, ' ', 4), ("a.stfs.covars", 5, ',', 1), ("a.tum", 3, ' ', 1), ("a.log", 4, ' ', 9)]
        {
            if bad.contains(separator) {
                continue;
            }
            with_line(&bench, name, line, |l| {
                let mut fields: Vec<&str> = l.split(separator).collect();
                fields[field] = bad;
                fields.join(&separator.to_string())
            });
            let place = format!("bad-{name}:{line}: ");
            bench.refused(&format!("info bad-{name}"), &[&place, bad, "finite number"]);
        }
    }
    let mut map = small_map();
    map.poses[7].x_m = f64::NAN;
    io::native::write(&bench.scratch.path("bad.npz"), &map).unwrap();
    refused_by_all(&bench, "bad.npz", "bad.npz: poses: pose 7: found a value that is not finite");
}

#[test]
fn information_that_is_not_positive_definite_is_refused() {
    let bench = bench_with_files("definite");
    with_line(&bench, "a.g2o", 41, |l| {
        let mut fields: Vec<&str> = l.split(' ').collect();
        fields[6] = "-1";
        fields.join(" ")
    });
    refused_by_all(&bench, "bad-a.g2o", "bad-a.g2o:41: EDGE_SE2: information matrix: found one that is not");
    let first_of_second_pose = 2 + bench.map("a.npz").observations.starts[1] as usize + 1;
    with_line(&bench, "a.stfs.covars", first_of_second_pose, |l| {
        let mut fields: Vec<&str> = l.split(',').collect();
        fields[7] = "-1";
        fields.join(",")
    });
    let place = format!("bad-a.stfs.covars:{first_of_second_pose}: covariance of pose 1: ");
    refused_by_all(&bench, "bad-a.stfs.covars", &place);
}

#[test]
fn a_map_without_points_cannot_be_corrected() {
    let bench = bench_with_files("pointless");
    for name in ["a.g2o", "a.tum"] {
        let found = format!("{name}: found a map without points, expected laser points");
        bench.refused(&format!("correct {name} -c c.jsonl -o o.npz"), &[&found]);
    }
}

#[test]
fn faults_of_corrections_are_named_with_their_line() {
    let bench = bench_with_files("corrections");
    let good = SMALL_CORRECTIONS.trim();
    let change = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        format!("\n{}\n", good.replacen(from, to, 1))
    };
    let twice = format!("{good}\n{good}\n");
    for (text, parts) in [
        (change("collinear", "colinear"), ["bad:2: mode: found \"colinear\"", "collinear, perpendicular"]),
        (change("\"mode\"", "\"modus\""), ["bad:2: modus: found an unknown field", "mode"]),
        (change("[2.5, -1.2]", "[0.5, -1.2]"), ["bad:2: a: points: found a stroke of zero length", "two"]),
        (change("[2.5, -1.2]", "[NaN, -1.2]"), ["bad:2: found text that is not JSON", "column"]),
        (change("[2.5, -1.2]", "[1e999, -1.2]"), ["bad:2: found text that is not JSON", "column"]),
        (change("[2.5, -1.2]", "[null, -1.2]"), ["bad:2: a: points: found [[", "two points"]),
        (change("[2.5, -1.2]", "[1e308, -1.2], [3, 4]"), ["bad:2: a: points: found [[", "two points"]),
        (change("[2.5, -1.2]", "[1e200, -1.2]"), ["bad:2: a: points: found a stroke of infinite", "metres"]),
        (change("\"pose\": 2", "\"pose\": -2"), ["bad:2: a: pose: found -2", "index of 0 or more"]),
        (change("\"pose\": 2", "\"pose\": 2.5"), ["bad:2: a: pose: found 2.5", "index"]),
        (change("\"pose\": 2", "\"pose\": 1e30"), ["bad:2: a: pose: found 1e+30", "index"]),
        (change("\"pose\": 2", "\"pose\": 40"), ["bad: correction one: a: found pose 40", "below 40"]),
        (
            change("\"pose\": 2", "\"pose\": 18446744073709551615"),
            ["a: found pose 18446744073709551615", "40"],
        ),
        (change("\"pose\": 2", "\"stamp\": 1e9"), ["bad: correction one: a: found stamp 1000000000", "0 to"]),
        (change("\"pose\": 2", "\"stamp\": -1"), ["bad: correction one: a: found stamp -1", "0 to 19.5"]),
        (change("\"pose\": 35", "\"pose\": 1, \"stamp\": 1"), ["bad:2: b: found both pose and stamp", "one"]),
        (change("\"id\": \"one\"", "\"weight\": 0"), ["bad:2: weight: found 0", "a number > 0"]),
        (change("\"id\": \"one\"", "\"weight\": \"2\""), ["bad:2: weight: found \"2\"", "a number > 0"]),
        (change("}}", "}"), ["bad:2: found text that is not JSON", "one JSON object a line"]),
        (twice, ["bad:2: id: found 'one' a second time", "each id once"]),
        (String::new(), ["bad: found no correction", "one JSON object a line"]),
        ("\n \n".into(), ["bad: found no correction", "one JSON object a line"]),
        ("[1]\n".into(), ["bad:1: found [1]", "a JSON object"]),
        (format!("{}1{}", "[".repeat(500), "]".repeat(500)), ["bad:1: ", "JSON"]),
    ] {
        bench.scratch.file("bad", text);
        bench.refused("correct a.npz -c bad -o o.npz --report r.json --pictures p", &parts);
    }
    bench.scratch.file("bad", [b"\n", good.replace("one", "\u{1}\u{2}").as_bytes()].concat());
    bench.refused("correct a.npz -c bad -o o.npz", &["bad:2: "]);
    bench.scratch.file("bad", b"\xff\xfe{\0\"\0m\0");
    bench.refused("correct a.npz -c bad -o o.npz", &["bad:1: found text that is not JSON"]);
    bench.scratch.file("bad", good.replace("one", "\u{e9}").bytes().map(|b| b & 0xdf).collect::<Vec<u8>>());
    bench.refused("correct a.npz -c bad -o o.npz", &["bad:1: "]);
    bench.refused("correct a.npz -c a.tum -o o.npz", &["a.tum:1: found text that is not JSON"]);
}

#[test]
fn a_stamp_on_a_map_without_stamps_is_refused() {
    let bench = bench_with_files("no-stamps");
    let stroke = |frame: &str| format!("{{{frame}, \"points\": [[0.5, -1.2], [2.5, -1.2]]}}");
    let (stamp, pose) = (stroke("\"stamp\": 3"), stroke("\"pose\": 3"));
    bench.scratch.file("s.jsonl", format!("{{\"mode\": \"parallel\", \"a\": {pose}, \"b\": {stamp}}}\n"));
    let found = "s.jsonl: correction c1: b: found a stamp, but the map has none; expected a pose index";
    bench.refused("correct a.stfs.covars -c s.jsonl -o o.npz", &[found]);
}

#[test]
fn truth_and_relations_without_a_common_stamp_are_refused() {
    let bench = bench_with_files("no-common");
    bench.scratch.file("t.tum", "5e5 0 0 0 0 0 0 1\n500000.5 0 0 0 0 0 0 1\n");
    bench.refused("evaluate a.npz --truth t.tum --report r.json", &["truth: found stamps 500000"]);
    bench.scratch.file("r", "5e5 500001 0 0 0 0 0 0\n");
    bench.refused("evaluate a.npz --relations r --report r.json", &["relations: found stamps 500000"]);
    bench.scratch.file("r", "1 2 0 0 0 0 0\n");
    bench.refused("evaluate a.npz --relations r --report r.json", &["r:1: found 7 fields, expected 8"]);
}

#[test]
fn a_format_that_cannot_hold_the_map_is_told_before_anything_is_written() {
    let bench = bench_with_files("cannot-hold");
    let mut map = small_map();
    map.relative_factors.remove(11);
    io::native::write(&bench.scratch.path("torn.npz"), &map).unwrap();
    let found = "found no relative factor from pose 11 to 12, expected a chain";
    bench.refused("import torn.npz -o o.stfs.covars", &[found]);
    bench.refused(
        "correct torn.npz -c c.jsonl -o o.stfs.covars --trajectory t.tum --report r.json --pictures p",
        &[found],
    );
    io::native::write(&bench.scratch.path("random.npz"), &Dice::new(5).map(4)).unwrap();
    bench.good("info random.npz");
}
