use hitl_slam::io::{self, Format, Source};

use crate::support::{Dice, Scratch, message, shared, small_log};

#[test]
fn a_file_is_what_stands_in_it_whatever_its_name() {
    let scratch = Scratch::new("detect");
    let mut map = Dice::new(2).map(5);
    map.relative_factors.retain(|f| f.j == f.i + 1);
    for (name, format) in [
        ("a.npz", Format::Native),
        ("a.g2o", Format::G2o),
        ("a.graph", Format::Toro),
        ("a.toro", Format::Toro),
        ("a.stfs.covars", Format::Stfs),
        ("a.tum", Format::Tum),
        ("a.txt", Format::Tum),
    ] {
        io::write_map(&scratch.path(name), &map).unwrap();
        std::fs::rename(scratch.path(name), scratch.path("misleading.clf")).unwrap();
        assert_eq!(io::detect::format(&scratch.path("misleading.clf")).unwrap(), format);
        assert_eq!(io::read(&scratch.path("misleading.clf")).unwrap().0, format);
    }
    let (format, read) = io::read(&scratch.file("log.tum", small_log(2))).unwrap();
    assert_eq!(format, Format::Carmen);
    assert!(matches!(read.value, Source::Log(log) if log.scans.len() == 2));
}

#[test]
fn a_tum_file_has_a_line_for_every_scan_of_the_log() {
    let scratch = Scratch::new("detect-tum");
    let map = Dice::new(2).map(5);
    io::write_map(&scratch.path("a.tum"), &map).unwrap();
    let Source::Trajectory(t) = io::read(&scratch.path("a.tum")).unwrap().1.value else { panic!() };
    assert_eq!(t.poses.len(), 10);
}

#[test]
fn what_is_no_input_is_said_so() {
    let scratch = Scratch::new("detect-errors");
    let empty = scratch.file("empty.clf", "");
    assert_eq!(message(io::read(&empty)), "empty.clf: found an empty file, expected a log or a map");
    let other = scratch.file("a.dat", "hello\nworld\n");
    let expected = "a.dat: found nothing that tells its format, expected a CARMEN log, g2o, TORO, .stfs.covars, TUM, a walk (.csv) or a native map (.npz)";
    assert_eq!(message(io::read(&other)), expected);
    let binary = scratch.file("a.bin", vec![0x80_u8; 3 << 20]);
    assert_eq!(message(io::read(&binary)), "a.bin:1: found a line of more than 1 MiB, expected a text file");
    // A file too damaged to tell goes to the reader of its name, which says on which line.
    let damaged = scratch.file("a.stfs.covars", "map\n1\n0,0,0,1,0\n");
    let expected = "a.stfs.covars:3: found 5 fields, expected 16 comma-separated numbers";
    assert_eq!(message(io::read(&damaged)), expected);
    let map = Dice::new(2).map(3);
    let text = message(io::write_map(&scratch.path("a.xyz"), &map));
    assert_eq!(
        text,
        "a.xyz: found no known extension, expected .npz, .g2o, .graph, .toro, .stfs.covars, .tum or .txt"
    );
    assert!(io::read(&scratch.path("absent")).is_err());
}

#[test]
fn other_peoples_files_are_refused_in_one_line() {
    for name in
        ["rosbag/test_turtlebot.bag", "pbstream/map.pbstream", "maps_pgm/willow-full.pgm.gz", "ual/SOURCE.md"]
    {
        let Some(path) = shared(name) else { return };
        message(io::read(&path));
    }
}
