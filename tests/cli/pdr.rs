//! `hitl feetslam pdr`: the walk in data/, and what is refused.

use std::path::Path;

use super::Bench;

const HEADER: &str = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps\n";

fn shipped(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).display().to_string()
}

/// The lines of the shipped walk's first 12 s.
fn lines() -> Vec<String> {
    use std::io::Read;
    let file = std::fs::File::open(shipped("walk.csv.xz")).unwrap();
    let mut text = String::new();
    lzma_rust2::XzReader::new(file, true).read_to_string(&mut text).unwrap();
    text.lines().skip(1).take(3_000).map(str::to_owned).collect()
}

fn changed(change: impl Fn(usize, &mut [f64])) -> String {
    let mut text = HEADER.to_owned();
    for (k, line) in lines().iter().enumerate() {
        let mut v: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
        change(k, &mut v);
        if v[0].is_infinite() {
            continue;
        }
        text += &v.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        text += "\n";
    }
    text
}

#[test]
fn the_shipped_walk_becomes_its_measured_strides() {
    let bench = Bench::new("pdr-shipped");
    let said = bench.good(&format!("feetslam pdr {} -o walk.csv --report r.json", shipped("walk.csv.xz")));
    assert!(said.contains("foot-mounted") && said.contains("102 steps"), "{said}");
    let report = bench.json("r.json");
    assert_eq!((report["mount"].as_str(), report["steps"].as_u64()), (Some("foot"), Some(102)));
    // 3.84 m and 3.32 m from the first footfall, by ruler; 131 m walked.
    let end = report["end_m"].as_array().unwrap();
    let away = end[0].as_f64().unwrap().hypot(end[1].as_f64().unwrap());
    assert!((away - 3.837f64.hypot(3.32)).abs() < 0.6, "{away}");
    let header = bench.text("walk.csv").lines().next().unwrap().to_owned();
    assert!(header.starts_with("time_s,forward_m,left_m,turn_rad,rests_until_s,var_forward_m2,"), "{header}");
    // What it writes is a walk; the footfalls are its truth.
    bench.good(&format!(
        "feetslam run walk.csv --mode footslam --particles 500 --truth {} -o out",
        shipped("walk.footfalls.csv")
    ));
    assert_eq!(bench.json("out/report.json")["walkers"][0]["points"].as_array().unwrap().len(), 103);
}

#[test]
fn the_same_recording_gives_the_same_bytes() {
    let bench = Bench::new("pdr-bytes");
    bench.scratch.file("imu.csv", changed(|_, _| ()));
    bench.good("feetslam pdr imu.csv -o a.csv");
    bench.good("feetslam pdr imu.csv --mount foot -o b.csv --report -");
    assert_eq!(bench.bytes("a.csv"), bench.bytes("b.csv"));
}

#[test]
fn a_recording_that_is_none_is_refused_in_one_line_and_nothing_is_written() {
    let bench = Bench::new("pdr-refused");
    let cases: [(&str, String, &[&str]); 10] = [
        (
            "nan",
            changed(|k, v| v[2] = if k == 99 { f64::NAN } else { v[2] }),
            &["i.csv:101: acc_y_mps2: found 'NaN'"],
        ),
        ("g", changed(|_, v| v[1..4].iter_mut().for_each(|a| *a /= 9.80665)), &["is it in g?"]),
        ("degrees", changed(|_, v| v[4..].iter_mut().for_each(|w| *w *= 57.29578)), &["degrees per second?"]),
        ("milliseconds", changed(|_, v| v[0] *= 1e3), &["is the time in seconds?"]),
        (
            "backwards",
            changed(|k, v| v[0] -= if k == 500 { 1.0 } else { 0.0 }),
            &["i.csv:502: time_s: found ", "a later time"],
        ),
        (
            "saturated",
            changed(|_, v| v[4..].iter_mut().for_each(|w| *w = w.clamp(-3.5, 3.5) * 1.01)),
            &["end of the sensor's range"],
        ),
        ("stuck", changed(|_, v| v[3] = -7.5), &["acc_z_mps2: found -7.5 in every sample"]),
        (
            "gap",
            changed(|k, v| v[0] += if k > 1_500 { 4.0 } else { 0.0 }),
            &["found a dropout from ", "cut the recording there"],
        ),
        ("one sample", changed(|k, v| v[0] = if k > 0 { f64::INFINITY } else { v[0] }), &["found 1 samples"]),
        ("no sample", HEADER.to_owned(), &["found no sample"]),
    ];
    for (name, text, parts) in cases {
        bench.scratch.file("i.csv", text);
        println!("{name}");
        bench.refused("feetslam pdr i.csv -o walk.csv --report r.json", parts);
    }
    bench.refused("feetslam pdr absent.csv -o walk.csv", &["absent.csv: found no such file"]);
    bench.refused("feetslam pdr i.csv --mount leg -o walk.csv", &["leg"]);
    bench.scratch.file("i.csv", changed(|_, _| ()));
    bench.refused(
        "feetslam pdr i.csv --weinberg-gain 9 -o walk.csv",
        &["Weinberg gain", "expected a number from 0.1 to 2"],
    );
}

#[test]
fn a_dropout_within_the_walk_is_bridged_and_said() {
    let bench = Bench::new("pdr-dropout");
    bench.scratch.file("whole.csv", changed(|_, _| ()));
    bench
        .scratch
        .file("i.csv", changed(|k, v| v[0] = if (2_000..2_080).contains(&k) { f64::INFINITY } else { v[0] }));
    let whole = bench.good("feetslam pdr whole.csv -o whole-walk.csv");
    let said = bench.good("feetslam pdr i.csv -o walk.csv --report r.json");
    assert!(said.contains("bridged from ") && said.contains("samples are missing"), "{said}");
    assert!(!whole.contains("bridged"), "{whole}");
    assert_eq!(bench.json("r.json")["dropouts"].as_array().unwrap().len(), 1);
    let count = |name: &str| bench.text(name).lines().count();
    assert!(count("walk.csv").abs_diff(count("whole-walk.csv")) <= 1);
}
