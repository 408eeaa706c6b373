//! Recordings as files, layout by layout, and what is refused of them.

use hitl_slam::inertial::{self, Options, Recording};
use hitl_slam::io::imu;

use super::walker::{FootWalk, Sensor};
use crate::support::{Scratch, message};

const HEADER: &str = "time_s,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps";

fn walk() -> Recording {
    FootWalk::random(8, 1).recording(&Sensor::default(), 1)
}

/// A table with these factors on force and rate.
fn table(header: &str, recording: &Recording, force: f64, rate: f64) -> String {
    let mut text = format!("{header}\n");
    for s in &recording.samples {
        let (f, w) = (s.force_mps2 * force, s.rate_radps * rate);
        text += &format!("{},{},{},{},{},{},{}\n", s.time_s, f.x, f.y, f.z, w.x, w.y, w.z);
    }
    text
}

fn assert_same(read: &Recording, wanted: &Recording) {
    assert_eq!(read.samples.len(), wanted.samples.len());
    for (a, b) in read.samples.iter().zip(&wanted.samples) {
        assert!((a.time_s - b.time_s).abs() < 1e-12);
        assert!((a.force_mps2 - b.force_mps2).norm() < 1e-9 && (a.rate_radps - b.rate_radps).norm() < 1e-9);
    }
}

#[test]
fn the_canonical_table_and_others_are_recognised_by_their_header() {
    let (scratch, walk) = (Scratch::new("imu-tables"), walk());
    let (g, deg) = (1.0 / 9.80665, 1f64.to_degrees());
    let scaled = "Time,inertial-1.2:scaledAccelX,inertial-1.2:scaledAccelY,inertial-1.2:scaledAccelZ,\
        inertial-1.2:scaledGyroX,inertial-1.2:scaledGyroY,inertial-1.2:scaledGyroZ";
    let named = "Time (s),Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g),\
        Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s)";
    for (header, force, rate, remarks) in [
        (HEADER, 1.0, 1.0, 0),
        (named, g, deg, 0),
        (scaled, g, 1.0, 1),
        (scaled, 1.0, 1.0, 0),
        (scaled, g, deg, 2),
    ] {
        let read = imu::read(&scratch.file("any.name", table(header, &walk, force, rate))).unwrap();
        assert_eq!(read.warnings.len(), remarks, "{header}: {:?}", read.warnings);
        assert_same(&read.value, &walk);
    }
}

#[test]
fn lines_marked_as_not_valid_and_repeated_lines_are_left_out() {
    let scratch = Scratch::new("imu-valid");
    let names = ["estCompensatedAccelX", "estCompensatedAccelY", "estCompensatedAccelZ"];
    let rates = ["estAngularRateX", "estAngularRateY", "estAngularRateZ"];
    let columns: Vec<String> = names.iter().chain(&rates).map(|n| format!("i:{n},i:{n}:valid")).collect();
    let line = |t: f64, valid: u8| format!("{t},0,1,0,1,9.8,{valid},0,1,0,1,{t},1\n");
    let text = format!(
        "Time,{}\n{}{}{}{}",
        columns.join(","),
        line(0.0, 1),
        line(0.1, 0),
        line(0.2, 1),
        line(0.2, 1)
    );
    let read = imu::read(&scratch.file("a.csv", text)).unwrap();
    assert_eq!(read.value.samples.iter().map(|s| s.time_s).collect::<Vec<_>>(), [0.0, 0.2]);
    assert_eq!(read.warnings.len(), 2, "{:?}", read.warnings);
}

#[test]
fn two_files_of_a_phone_are_one_recording_whichever_is_named() {
    let (scratch, walk) = (Scratch::new("imu-pair"), walk());
    let head = "\nhttp://example\n\nelapsed-time-system elapsed-time-sensor x y z\n";
    let mut texts = [
        format!("some name\n\nAll values are in SI units (m/s^2).{head}"),
        format!("other name\n\nAll values are in radians/second.{head}"),
    ];
    for s in &walk.samples {
        let (t, f, w) = (s.time_s, s.force_mps2, s.rate_radps);
        texts[0] += &format!("{} {} {} {} {}\n", t + 0.5, t, f.x, f.y, f.z);
        texts[1] += &format!("{} {} {} {} {}\n", t + 0.5, t, w.x, w.y, w.z);
    }
    let files = [scratch.file("b.txt", &texts[0]), scratch.file("a.txt", &texts[1])];
    scratch.file("notes.json", "{}");
    for path in [&files[0], &files[1], &scratch.path("")] {
        let read = imu::read(path).unwrap().value;
        // The system's clock counts; the first sample has no earlier one to be interpolated from.
        assert_eq!(read.samples.len(), walk.samples.len() - 1);
        for (a, b) in read.samples.iter().zip(&walk.samples[1..]) {
            assert!((a.time_s - b.time_s - 0.5).abs() < 1e-9);
            assert!((a.force_mps2 - b.force_mps2).norm() < 1e-9 && a.rate_radps == b.rate_radps);
        }
    }
    std::fs::remove_file(&files[1]).unwrap();
    let said = hitl_slam::error::Error::to_string(&imu::read(&files[0]).unwrap_err());
    assert!(said.contains("found no gyroscope readings, expected one file of them"), "{said}");
}

#[test]
fn what_is_wrong_with_a_table_is_named_by_file_and_line() {
    let scratch = Scratch::new("imu-bad");
    let cases = [
        ("", "i.csv: found an empty file, expected the header "),
        ("a,b,c\n", "i.csv:1: found the header 'a,b,c', expected time_s,acc_x_mps2"),
        (HEADER, "i.csv: found no sample, expected at least one line below the header"),
        (&format!("{HEADER}\n0,0,0\n"), "i.csv:2: found 3 fields, expected 7"),
        (
            &format!("{HEADER}\n0,0,0,9.8,0,0,0\n0.01,0,NaN,9.8,0,0,0\n"),
            "i.csv:3: acc_y_mps2: found 'NaN', expected a finite number",
        ),
        (
            &format!("{HEADER}\n0.1,0,0,9.8,0,0,0\n0.05,0,0,9.8,0,0,0\n"),
            "i.csv:3: time_s: found 0.05 after 0.1, expected a later time",
        ),
        (
            &format!("{HEADER}\n0.1,0,0,9.8,0,0,0\n0.1,0,0,9.7,0,0,0\n"),
            "i.csv:3: time_s: found 0.1 after 0.1, expected a later time",
        ),
    ];
    for (content, expected) in cases {
        let found = message(imu::read(&scratch.file("i.csv", content)));
        assert!(found.starts_with(expected), "{found}\nexpected {expected}");
    }
}

fn refusal(change: impl FnOnce(&mut Recording)) -> String {
    let mut recording = walk();
    change(&mut recording);
    let refused = inertial::reckon("imu.csv", &recording, &Options::default());
    refused.map(|pdr| format!("accepted: {} steps", pdr.steps.len())).unwrap_or_else(|e| e.to_string())
}

#[test]
fn recordings_that_are_no_walk_are_refused_with_the_reason() {
    let said = [
        (refusal(|r| r.samples.truncate(1)), "found 1 samples, expected at least 2 s of them"),
        (refusal(|r| r.samples.truncate(50)), "s of samples, expected at least 2 s"),
        (refusal(|r| r.samples.iter_mut().for_each(|s| s.force_mps2 /= 9.8)), "is it in g?"),
        (refusal(|r| r.samples.iter_mut().for_each(|s| s.force_mps2 *= 102.0)), "is it in thousandths of g?"),
        (
            refusal(|r| r.samples.iter_mut().for_each(|s| s.rate_radps *= 57.3)),
            "are they in degrees per second?",
        ),
        (refusal(|r| r.samples.iter_mut().for_each(|s| s.time_s *= 1e3)), "is the time in seconds?"),
        (refusal(|r| r.samples.swap(300, 301)), "time_s: found 1.5 after 1.505, expected a later time"),
        (refusal(|r| r.samples[9].force_mps2.x = f64::NAN), "found a number that is not finite at 0.045 s"),
        (
            refusal(|r| r.samples.iter_mut().for_each(|s| s.rate_radps.y = 0.0)),
            "gyro_y_radps: found 0 in every sample",
        ),
        (
            refusal(|r| {
                r.samples
                    .iter_mut()
                    .for_each(|s| s.rate_radps = s.rate_radps.map(|w| w.clamp(-1.0, 1.0) * 4.0))
            }),
            "at the end of the sensor's range, expected at most 1 %",
        ),
        (
            refusal(|r| r.samples.retain(|s| s.time_s < 4.0 || s.time_s > 5.5)),
            "expected at most 1 s: cut the recording there",
        ),
        (refusal(|r| r.samples.iter_mut().for_each(|s| s.rate_radps *= 1e-3)), "does the gyroscope work?"),
    ];
    for (found, expected) in said {
        assert!(found.starts_with("imu.csv: ") && found.contains(expected), "{found}\nexpected {expected}");
    }
}

#[test]
fn what_may_be_a_foot_or_a_hand_has_to_be_said() {
    let found = refusal(|r| {
        let fast = r.rate_quantile_radps(0.99);
        r.samples.iter_mut().for_each(|s| s.rate_radps *= 3.5 / fast);
    });
    assert!(found.contains("expected to be told which: --mount foot|hand"), "{found}");
}

#[test]
fn some_samples_at_the_end_of_the_range_are_reported_and_doubted() {
    let mut recording = walk();
    let rate = |k: usize, r: &Recording| r.samples[k].rate_radps.y;
    let fastest = (0..recording.samples.len())
        .max_by(|&a, &b| rate(a, &recording).total_cmp(&rate(b, &recording)))
        .unwrap();
    let top = rate(fastest, &recording);
    recording.samples[fastest - 2..fastest + 3].iter_mut().for_each(|s| s.rate_radps.y = top);
    let clean = inertial::reckon("imu.csv", &walk(), &Options::default()).unwrap();
    let cut = inertial::reckon("imu.csv", &recording, &Options::default()).unwrap();
    assert_eq!(cut.steps.len(), clean.steps.len());
    assert!(cut.remarks.iter().any(|r| r.starts_with("gyro_y_radps: ")), "{:?}", cut.remarks);
}
