//! `hitl feetslam run` and `simulate` as a user meets them.

use serde_json::Value;

use super::Bench;

const SMALL: &str = "--particles 300 --iterations 2 --start 0,0,-90";

/// With `six/`, what `feetslam simulate six` makes.
fn with_six(test: &str) -> Bench {
    let bench = Bench::new(test);
    bench.good("feetslam simulate six --seed 3 -o six");
    bench
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("found {value}, expected a number"))
}

#[test]
fn successive_mapping_reports_every_walker_at_its_true_positions_and_draws_what_the_paper_draws() {
    let bench = with_six("feetslam");
    let walks = "six/w1.csv six/w2.csv six/w3.csv six/w4.csv six/w5.csv six/w6.csv";
    let said = bench.good(&format!(
        "feetslam run {walks} --mode successive --ends-m 14,24,34 {SMALL} --truth six/truth.csv --plan six/walls.csv \
         -o out --report r.json --pictures pictures"
    ));
    assert!(said.contains("6 walkers, 4 rounds, 2 iterations, 300 particles"), "{said}");

    let report = bench.json("r.json");
    assert_eq!(report, bench.json("out/report.json"));
    let truth = bench.text("six/truth.csv");
    let names: Vec<&str> =
        report["walkers"].as_array().unwrap().iter().map(|w| w["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["w1", "w2", "w3", "w4", "w5", "w6"]);
    let (mut error, mut mean, mut pdr) = (0.0, 0.0, 0.0);
    for walker in report["walkers"].as_array().unwrap() {
        let name = walker["name"].as_str().unwrap();
        let lines = truth.lines().filter(|l| l.starts_with(&format!("{name},")));
        let stamps: Vec<f64> = lines.map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
        let points = walker["points"].as_array().unwrap();
        assert_eq!(points.iter().map(|p| number(&p["stamp"])).collect::<Vec<_>>(), stamps, "{name}");
        assert!(number(&points[0]["error_pdr_m"]) < 1e-9, "all start at --start");
        let last = &points[points.len() - 1];
        error += number(&last["error_m"]);
        mean += number(&last["error_mean_m"]);
        pdr += number(&last["error_pdr_m"]);
    }
    assert!(error < 0.6 * pdr && mean < 0.3 * pdr, "best {error}, mean {mean}, dead reckoning {pdr}");
    assert_eq!(
        (&report["rounds"], &report["iterations"], &report["particles"]),
        (&4.into(), &2.into(), &300.into())
    );
    // Steps at the four ends, three passes each.
    let steps: u64 = bench.text("out/paths.csv").lines().count() as u64 - 1;
    let passed = report["particle_steps"].as_u64().unwrap();
    assert!(passed > 3 * 300 * steps && passed < 4 * 3 * 300 * steps, "{passed} of {steps} steps");
    assert!(number(&report["wall_ms"]) > 0.0 && number(&report["peak_rss_mb"]) > 1.0);
    assert!(number(&report["map_precision"]) > 0.9 && number(&report["map_recall"]) > 0.8, "{report}");
    assert!(number(&report["crossed_wall_ratio"]) < 0.05);

    let png = |name: &str| bench.bytes(&format!("pictures/{name}"))[..4] == *b"\x89PNG";
    for name in [
        "iterations",
        "rounds",
        "paths-before",
        "paths-after",
        "paths-best",
        "errors-mean",
        "errors-best",
        "errors-pdr",
    ] {
        assert!(png(&format!("{name}.png")), "{name}");
    }
    assert!(bench.text("pictures/map.svg").starts_with("<svg"));
    let map = bench.json("out/map.json");
    let crossings: f64 = map["edges"].as_array().unwrap().iter().map(|e| number(&e["count"])).sum();
    assert!((crossings - number(&map["crossings"])).abs() < 1e-6 * crossings);
    assert!(bench.bytes("out/map.npz").starts_with(b"PK"));
}

#[test]
fn any_number_of_threads_writes_the_same_bytes_in_every_mode() {
    let bench = with_six("feetslam-threads");
    let walks = "six/w1.csv six/w4.csv";
    let clean = |name: &str| {
        let mut report = bench.json(name);
        report["wall_ms"] = 0.into();
        report["peak_rss_mb"] = 0.into();
        report
    };
    for mode in [
        "footslam",
        "feetslam --grid regrid",
        "successive --ends-m 14,24",
        "successive --ends-s 20,40 --own-map",
        "successive --ends-m 14,24 --window-m 12",
    ] {
        for threads in [1, 2] {
            let run = format!("feetslam run {walks} --mode {mode} {SMALL} --threads {threads} -o {threads}");
            bench.good(&run);
        }
        for file in ["paths.csv", "map.json", "map.npz"] {
            assert!(bench.bytes(&format!("1/{file}")) == bench.bytes(&format!("2/{file}")), "{mode}: {file}");
        }
        assert_eq!(clean("1/report.json"), clean("2/report.json"), "{mode}");
    }
}

#[test]
fn the_start_the_norm_the_grid_and_the_gain_are_options_that_the_report_echoes() {
    let bench = with_six("feetslam-options");
    let run = |more: &str| {
        bench.good(&format!(
            "feetslam run six/w1.csv six/w2.csv --mode feetslam --particles 200 --iterations 1 {more} -o out"
        ));
        bench.json("out/report.json")
    };
    let first_x = || -> f64 {
        bench.text("out/paths.csv").lines().nth(1).unwrap().split(',').nth(8).unwrap().parse().unwrap()
    };
    let report = run(
        "--start 5,1,0 --start-sigma-m 0.5 --start-heading-sigma-deg 3 --norm literal --gain 0.5 --gain-schedule annealed --grid fixed --grid-angle-deg 15 --hex-radius-m 0.8 --converged-below 0.9 --seed 9",
    );
    let settings = &report["settings"];
    for (name, value) in [("norm", "literal"), ("gain_schedule", "annealed"), ("grid", "fixed")] {
        assert_eq!(settings[name], value);
    }
    for (name, value) in [
        ("start_sigma_m", 0.5),
        ("start_heading_sigma_deg", 3.0),
        ("gain", 0.5),
        ("hex_radius_m", 0.8),
        ("converged_below", 0.9),
        ("seed", 9.0),
    ] {
        assert!((number(&settings[name]) - value).abs() < 1e-9, "{name}: {}", settings[name]);
    }
    assert!((number(&report["grid_angle_deg"]) - 15.0).abs() < 1e-9);
    // The first step leads 0.7 m ahead: to the right at heading 0, down at heading −90°.
    assert!((first_x() - 5.7).abs() < 0.1, "{}", first_x());
    for norm in ["uniform", "fresh"] {
        assert_eq!(run(&format!("--norm {norm} --start 0,0,-90"))["settings"]["norm"], norm);
    }
    assert!(first_x().abs() < 0.1, "{}", first_x());
}

#[test]
fn standing_still_for_two_seconds_is_reported_where_the_walker_stood() {
    let bench = with_six("feetslam-standing");
    bench.good(&format!("feetslam run six/w1.csv --mode footslam {SMALL} -o out"));
    let report = bench.json("out/report.json");
    let stood = report["walkers"][0]["standstills"].as_array().unwrap();
    // At the corner (0, −4), after 10, 20 and 30 m of corridor; the start and the end have no step on one side.
    let corner =
        stood.iter().find(|s| (number(&s["y_m"]) + 4.0).abs() < 0.3 && number(&s["x_m"]).abs() < 0.3);
    assert!(stood.len() >= 4 && corner.is_some(), "{stood:?}");
    assert!(stood.iter().all(|s| number(&s["to_s"]) - number(&s["from_s"]) >= 2.0), "{stood:?}");
}

#[test]
fn bad_walks_and_options_are_one_line_and_nothing_is_written() {
    let bench = with_six("feetslam-bad");
    let header = "time_s,forward_m,left_m,turn_rad\n";
    let file = |name: &str, rows: &str| bench.scratch.file(name, format!("{header}{rows}"));
    file("gap.csv", "1,0.7,0,0\n2,40,0,0\n");
    file("nan.csv", "1,0.7,NaN,0\n");
    file("back.csv", "1,0.7,0,0\n0.5,0.7,0,0\n");
    file("none.csv", "");
    file("short.csv", "1,0.7\n");
    bench.scratch.file("empty.csv", "");
    bench.scratch.file("columns.csv", "time_s,forward_m,left_m,turn_rad,mood\n1,0.7,0,0,3\n");
    bench.scratch.file("names.csv", "t,x,y\n1,2,3\n");
    bench.scratch.file("truth.csv", "walker,time_s,x_m,y_m\nsomebody,1,0,0\n");
    std::fs::create_dir_all(bench.scratch.path("more")).unwrap();
    file("more/w1.csv", "1,0.7,0,0\n");
    for (arguments, found) in [
        (
            "six/w1.csv gap.csv --mode feetslam",
            "gap.csv:3: found a step of 40.0 m, expected at most 5 m: are steps missing?",
        ),
        ("nan.csv --mode footslam", "nan.csv:2: left_m: found 'NaN', expected a finite number"),
        ("back.csv --mode footslam", "back.csv:3: time_s: found 0.5 after 1, expected a later time"),
        ("none.csv --mode footslam", "none.csv: found no step, expected at least one line"),
        ("short.csv --mode footslam", "short.csv:2: found 2 fields, expected 4"),
        ("empty.csv --mode footslam", "empty.csv: found an empty file, expected the header"),
        ("columns.csv --mode footslam", "columns.csv:1: found the column 'mood', expected"),
        ("names.csv --mode footslam", "names.csv:1: found the header 't,x,y', expected time_s"),
        ("absent.csv --mode footslam", "absent.csv: found no such file"),
        (
            "six/w1.csv more/w1.csv --mode feetslam",
            "found a second walker with the name 'w1', expected different",
        ),
        ("six/w1.csv --mode successive", "--ends-m: found none, expected the ends of the rounds"),
        (
            "six/w1.csv --mode successive --ends-m 20,10",
            "--ends-m: found 10 after 20, expected ascending numbers > 0",
        ),
        ("six/w1.csv --mode successive --ends-s 0,10", "--ends-s: found 0 after 0, expected ascending"),
        ("six/w1.csv --mode footslam --start 1,2", "--start: found '1,2', expected x_m,y_m,heading_deg"),
        ("six/w1.csv --mode footslam --start 1,2,nan", "--start: found '1,2,nan', expected"),
        (
            "six/w1.csv --mode footslam --start-sigma-m=-1",
            "--start-sigma-m: found -1, expected a number from 0",
        ),
        ("six/w1.csv --mode footslam --particles 1", "particles: found 1, expected a number from 2"),
        ("six/w1.csv --mode footslam --hex-radius-m 0", "hexagon radius: found 0, expected"),
        ("six/w1.csv --mode footslam --iterations 11", "iterations: found 11, expected"),
        (
            "six/w1.csv --mode footslam --truth truth.csv",
            "truth.csv: found no line of w1, expected true positions",
        ),
        ("six/w1.csv --mode footslam --plan nan.csv", "nan.csv:1: found"),
        ("six/w1.csv --mode both", "found 'both', expected one of footslam"),
    ] {
        bench.refused(&format!("feetslam run {arguments} -o out --report r.json --pictures p"), &[found]);
    }
    for (arguments, found) in [
        ("nine", "found 'nine', expected one of six"),
        ("building", "--plan: found none, expected the walls of the building"),
        ("building --plan absent", "absent: found no such file"),
        ("curve --radius-m 3", "radius: found 3, expected at least 10 m"),
        ("loops --minutes 0", "minutes: found 0, expected"),
    ] {
        bench.refused(&format!("feetslam simulate {arguments} -o out"), &[found]);
    }
}

#[test]
fn the_same_seed_simulates_the_same_bytes_and_another_one_does_not() {
    let bench = Bench::new("feetslam-simulate");
    let scenarios = [
        "six",
        "opposite",
        "one-sided",
        "corner --bend-deg 20",
        "curve --radius-m -200",
        "rooms",
        "loops --minutes 2 --walkers 3",
    ];
    for scenario in scenarios {
        for (folder, seed) in [("a", 5), ("b", 5), ("c", 6)] {
            bench.good(&format!("feetslam simulate {scenario} --seed {seed} --turn-deg 12 -o {folder}"));
        }
        for file in ["w1.csv", "w2.csv", "truth.csv", "walls.csv", "start.txt"] {
            assert!(
                bench.bytes(&format!("a/{file}")) == bench.bytes(&format!("b/{file}")),
                "{scenario}: {file}"
            );
        }
        assert!(bench.bytes("a/w1.csv") != bench.bytes("c/w1.csv"), "{scenario}");
    }
}

#[test]
fn walks_with_unknown_starts_are_placed_and_one_in_other_units_gets_its_scale() {
    let bench = Bench::new("feetslam-align");
    let said =
        bench.good("feetslam simulate office --seed 4 --walkers 3 --half-strangers 1 --minutes 5 -o office");
    let first = said.split("start ").nth(1).and_then(|s| s.split(' ').next()).unwrap().to_owned();
    let starts: Vec<[f64; 3]> = bench
        .text("office/start.txt")
        .lines()
        .map(|line| {
            let numbers: Vec<f64> = line.split([',', ' ']).filter_map(|n| n.parse().ok()).collect();
            numbers[numbers.len() - 3..].try_into().unwrap()
        })
        .collect();
    // The second walker's sensor takes 1.05 m for 1 m.
    let rows = bench.text("office/w2.csv");
    let (header, rows) = rows.split_once('\n').unwrap();
    let stretched: String = rows
        .lines()
        .map(|row| {
            let n: Vec<f64> = row.split(',').map(|n| n.parse().unwrap()).collect();
            format!("{},{},{},{}\n", n[0], n[1] / 0.95, n[2] / 0.95, n[3])
        })
        .collect();
    std::fs::write(bench.scratch.path("office/w2.csv"), format!("{header}\n{stretched}")).unwrap();
    let run = format!(
        "feetslam run office/w1.csv office/w2.csv --mode feetslam --particles 600 --iterations 1 --start {first} \
         --truth office/truth.csv"
    );
    bench.good(&format!("{run} --align --align-scale -o out"));
    let report = bench.json("out/report.json");
    let walker = &report["walkers"][1];
    assert_eq!((&walker["takes_part"], &report["walkers"][0]["scale"]), (&true.into(), &1.0.into()));
    let [support, rival] = ["support", "rival"].map(|key| walker[key].as_f64().expect("a number"));
    assert!(support > 0.3 && rival < support, "{support} {rival}");
    assert!((number(&walker["scale"]) - 0.95).abs() < 0.015, "{walker}");
    let start: Vec<f64> = walker["start"].as_array().unwrap().iter().map(number).collect();
    let off_m = (start[0] - starts[1][0]).hypot(start[1] - starts[1][1]);
    assert!(off_m < 0.8, "{start:?} {:?}", starts[1]);
    let points = walker["points"].as_array().unwrap();
    let mean = points.iter().map(|p| number(&p["error_m"])).sum::<f64>() / points.len() as f64;
    assert!(mean < 0.8, "{mean}");

    // Without it nobody's lengths are touched, and without --align there is nothing to estimate a scale from.
    bench.good(&format!("{run} --align -o plain"));
    let plain = bench.json("plain/report.json");
    assert_eq!(plain["walkers"][1]["scale"], 1.0);
    let refused = bench.hitl(&format!("{run} --align-scale -o none"));
    assert!(refused.code == Some(2) && refused.stderr.contains("--align"), "{}", refused.stderr);
    assert!(!bench.exists("none"));
}
