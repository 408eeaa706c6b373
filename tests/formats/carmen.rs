use std::io::Write;

use hitl_slam::io::carmen;
use hitl_slam::map::RawLog;

use crate::support::{Scratch, message, shared, small_log};

fn flaser(n: usize, ranges: &str, tail: &str) -> String {
    format!("FLASER {n} {ranges} {tail}\n")
}

const TAIL: &str = "1 2 0.5 1 2 0.5 100.25 nohost 0.1";

#[test]
fn the_number_of_ranges_gives_the_bearings() {
    let scratch = Scratch::new("carmen-bearings");
    for (n, step_deg) in [(180, 1.0), (360, 0.5), (181, 1.0), (361, 0.5)] {
        let path = scratch.file("a.clf", flaser(n, &"1 ".repeat(n), TAIL));
        let scan = &carmen::read(&path).unwrap().value.scans[0];
        assert!((scan.first_bearing_rad.to_degrees() + 90.0).abs() < 1e-12);
        assert!((scan.bearing_step_rad.to_degrees() - step_deg).abs() < 1e-12, "{n} ranges");
        assert_eq!((scan.stamp_s, scan.ranges_m.len()), (100.25, n));
    }
}

#[test]
fn truncated_and_garbled_lines_name_line_and_field() {
    let scratch = Scratch::new("carmen-errors");
    let robot_laser =
        "ROBOTLASER1 0 -1.57 3.14 1.57 80 0.01 0 3 1 2 3 0 0.2 0 0 0 0 0 0 0 0 0 0 5.5 host 0\n";
    let cases = [
        (
            flaser(4, "1 2 3", TAIL),
            "expected 4 ranges, found 3 before the poses, stamp, host and logger stamp",
        ),
        ("FLASER\n".into(), "found the end of the line, expected the number of ranges"),
        (
            "FLASER 3 1 2\n".into(),
            "expected 3 ranges, found 0 before the poses, stamp, host and logger stamp",
        ),
        (flaser(3, "1 x 3", TAIL), "range 1: found 'x', expected a finite number"),
        (flaser(3, "1 nan 3", TAIL), "range 1: found 'nan', expected a finite number"),
        (flaser(3, "1 inf 3", TAIL), "range 1: found 'inf', expected a finite number"),
        (flaser(3, "1 -2 3", TAIL), "range 1: found -2, expected metres, 0 or more"),
        (
            flaser(3, "1 1e39 3", TAIL),
            "range 1: found 1000000000000000000000000000000000000000, expected metres, 0 or more",
        ),
        (flaser(1, "1", "1 2 NaN 1 2 0.5 100 h 0"), "laser theta: found 'NaN', expected a finite number"),
        (flaser(1, "1", "1 2 0 1 2 0.5 1e400 h 0"), "stamp: found '1e400', expected a finite number"),
        ("FLASER -3 1\n".into(), "number of ranges: found -3, expected 0 or more"),
        (robot_laser.replace(" 3 1 2 3 ", " 30 1 2 3 "), "expected 30 ranges, found 18"),
        (robot_laser.replace(" 5.5 host 0", ""), "expected 14 fields after 0 remissions, found 11"),
        (robot_laser.replace("5.5", "inf"), "stamp: found 'inf', expected a finite number"),
    ];
    for (line, expected) in cases {
        let path = scratch.file("a.clf", format!("# first\n{line}"));
        let tag = line.split_whitespace().next().unwrap();
        assert_eq!(message(carmen::read(&path)), format!("a.clf:2: {tag}: {expected}"), "{line}");
    }
    let path = scratch.file("a.clf", format!("{robot_laser}\u{1}\u{2}garbage 1 2\n"));
    let text = message(carmen::read(&path));
    assert_eq!(text, "a.clf:2: found a line that begins with 'garbage…', expected a CARMEN message");
    let path = scratch.file("a.clf", "ODOM 0 0 x 0 0 0 1 h 0\n");
    assert_eq!(message(carmen::read(&path)), "a.clf:1: ODOM: theta: found 'x', expected a finite number");
    let path = scratch.file("a.clf", "PARAM robot_frontlaser_offset\n");
    let text = message(carmen::read(&path));
    assert_eq!(text, "a.clf:1: PARAM: robot_frontlaser_offset: found no value, expected a number");
    let path = scratch.file("a.clf", "# nothing\n");
    assert_eq!(message(carmen::read(&path)), "a.clf: found no scan, expected FLASER or ROBOTLASER1 lines");
}

#[test]
fn unknown_messages_warn_once_and_known_ones_not_at_all() {
    let scratch = Scratch::new("carmen-warnings");
    let text = format!("NEFF 3\nSYNC a\nWHAT 1\nWHAT 2\n{}", flaser(1, "1", TAIL));
    let read = carmen::read(&scratch.file("a.clf", text.trim_end())).unwrap();
    assert_eq!(read.warnings.len(), 2, "{:?}", read.warnings);
    assert!(read.warnings[0].ends_with("a.clf:3: unknown message WHAT: skipped"));
    assert!(read.warnings[1].contains("the last line has no line end"));
}

#[test]
fn a_laser_ahead_of_the_robot_is_found_from_the_lines() {
    let scratch = Scratch::new("carmen-offset");
    let log = carmen::read(&scratch.file("a.clf", small_log(5))).unwrap().value;
    assert!((log.robot_from_laser.x_m - 0.2).abs() < 1e-12);
    for scan in &log.scans {
        assert!((scan.world_from_robot.x_m - scan.odometry_from_robot.x_m).abs() < 1e-12);
    }
}

#[test]
fn the_parameter_places_the_laser_where_the_poses_are_corrected() {
    let scratch = Scratch::new("carmen-corrected");
    let line = |k: u32| flaser(1, "1", &format!("{} 0 0 {k} 0 0 {k} h 0", f64::from(k) * 1.1 + 0.3));
    let lines: String = (0..9).map(line).collect();
    let path = scratch.file("a.clf", format!("PARAM robot_frontlaser_offset 0.3 nohost 0\n{lines}"));
    let log = carmen::read(&path).unwrap().value;
    assert_eq!(log.robot_from_laser.to_array(), [0.3, 0.0, 0.0]);
    assert!((log.scans[8].world_from_robot.x_m - 8.8).abs() < 1e-12);
    assert_eq!(log.scans[8].odometry_from_robot.x_m, 8.0);
    let read = carmen::read(&scratch.file("a.clf", lines)).unwrap();
    assert!(read.warnings[0].contains("no PARAM robot_frontlaser_offset"));
    assert_eq!(read.value.robot_from_laser.x_m, 0.0);
}

#[test]
fn compressed_logs_of_several_streams_are_read_and_cut_ones_refused() {
    let scratch = Scratch::new("carmen-compressed");
    let halves = [small_log(3), small_log(4)].map(String::into_bytes);
    let gz = |part: &Vec<u8>| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(part).unwrap();
        encoder.finish().unwrap()
    };
    let bz2 = |part: &Vec<u8>| {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
        encoder.write_all(part).unwrap();
        encoder.finish().unwrap()
    };
    for whole in [halves.each_ref().map(gz).concat(), halves.each_ref().map(bz2).concat()] {
        // The name says nothing about the compression: the first bytes do.
        let log: RawLog = carmen::read(&scratch.file("a.clf", &whole)).unwrap().value;
        assert_eq!(log.scans.len(), 7);
        let text = message(carmen::read(&scratch.file("a.clf", &whole[..whole.len() - 9])));
        assert!(text.contains("found damaged or cut-off data"), "{text}");
    }
}

#[test]
fn the_public_logs_hold_as_many_scans_as_their_sources_say() {
    for (name, scans, offset_m) in [
        ("radish_raw/intel.clf.bz2", 13_631, 0.0),
        ("radish_raw/aces.clf.bz2", 7_374, 0.0),
        ("radish_raw/mit-csail.clf.bz2", 1_988, 0.0),
        ("radish_raw/fr-clinic_robotlaser.clf.bz2", 6_917, 0.22),
        ("ual/ual_2014_05_23.clf.bz2", 3_318, 2.0),
        ("radish_corrected/intel-corrected.log.gz", 910, 0.0),
        ("radish_corrected/freiburg-campus-corrected.log.gz", 2_008, 0.0),
    ] {
        let Some(path) = shared(name) else { return };
        let read = carmen::read(&path).unwrap();
        assert_eq!(read.warnings, [""; 0], "{name}");
        assert_eq!(read.value.scans.len(), scans, "{name}");
        let offset = read.value.robot_from_laser;
        assert!((offset.x_m - offset_m).abs() < 1e-4 && offset.y_m.abs() < 1e-4, "{name}: {offset:?}");
    }
}

#[test]
fn scans_stay_in_the_order_of_the_file_where_the_clock_jumps() {
    let Some(path) = shared("radish_raw/intel.clf.bz2") else { return };
    let log = carmen::read(&path).unwrap().value;
    let backwards = log.scans.windows(2).filter(|w| w[1].stamp_s <= w[0].stamp_s).count();
    assert_eq!(backwards, 631);
}
