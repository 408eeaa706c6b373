//! Cut a small valid file of every format after every byte: the reader answers, and never with a panic.

use std::fs;
use std::path::Path;

use hitl_slam::io::{self, carmen, corrections, g2o, native, relations, stfs, toro, tum};

use crate::support::{Dice, Scratch, small_log};

/// Reads every prefix of `whole`. A text cut inside a line may still be sound (a number that lost digits), but only with
/// a warning; `is_remarked` says that it must be so.
fn every_prefix(name: &str, whole: &[u8], is_remarked: bool, read: impl Fn(&Path) -> Option<Vec<String>>) {
    let scratch = Scratch::new(&format!("prefix-{name}"));
    let path = scratch.file(name, whole);
    assert!(read(&path).is_some_and(|warnings| warnings.is_empty()), "{name} as a whole");
    let mut sound = 0;
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        let _ = io::read(&path);
        if let Some(warnings) = read(&path) {
            sound += 1;
            let is_cut = length > 0 && whole[length - 1] != b'\n';
            assert!(!(is_remarked && is_cut && warnings.is_empty()), "{name} cut after {length} bytes");
        }
    }
    assert!(sound < whole.len() / 2, "{name}: {sound} of {} prefixes are sound", whole.len());
}

macro_rules! reader {
    ($read:path) => {
        |path: &Path| $read(path).ok().map(|r| r.warnings)
    };
}

#[test]
fn every_prefix_of_a_carmen_log_is_answered() {
    let line = "ROBOTLASER1 0 -1.57 3.14 1.57 80 0.01 0 3 1 2 3 0 0.2 0 0 0 0 0 0 0 0 0 0 5.5 host 0\n";
    every_prefix("r.clf", line.repeat(2).as_bytes(), true, reader!(carmen::read));
    let log = small_log(1);
    every_prefix("f.clf", log.as_bytes(), true, reader!(carmen::read));
}

#[test]
fn every_prefix_of_a_g2o_graph_is_answered() {
    let scratch = Scratch::new("prefixes-g2o");
    g2o::write(&scratch.path("a"), &Dice::new(1).map(3)).unwrap();
    every_prefix("a.g2o", &fs::read(scratch.path("a")).unwrap(), true, reader!(g2o::read));
}

#[test]
fn every_prefix_of_a_toro_graph_is_answered() {
    let scratch = Scratch::new("prefixes-toro");
    toro::write(&scratch.path("a"), &Dice::new(1).map(3)).unwrap();
    every_prefix("a.graph", &fs::read(scratch.path("a")).unwrap(), true, reader!(toro::read));
}

#[test]
fn every_prefix_of_an_stfs_map_is_answered() {
    let mut map = Dice::new(1).map(2);
    map.relative_factors.retain(|f| f.j == f.i + 1);
    let scratch = Scratch::new("prefixes-stfs");
    stfs::write(&scratch.path("a"), &map).unwrap();
    every_prefix("a.stfs.covars", &fs::read(scratch.path("a")).unwrap(), true, reader!(stfs::read));
}

#[test]
fn every_prefix_of_a_trajectory_is_answered() {
    let scratch = Scratch::new("prefixes-tum");
    tum::write(&scratch.path("a"), &Dice::new(1).map(3).trajectory()).unwrap();
    every_prefix("a.tum", &fs::read(scratch.path("a")).unwrap(), true, reader!(tum::read));
    let relations = "1.5 2.5 0.1 0.2 0 0 0 -1.25\n";
    every_prefix("a.relations", relations.as_bytes(), true, reader!(relations::read));
}

#[test]
fn every_prefix_of_corrections_is_answered() {
    let line =
        r#"{"mode": "collinear", "a": [[0, 0], [1, 0]], "b": {"stamp": 3.5, "points": [[0, 0], [1, 0.5]]}}"#;
    // Without its line end a JSON line is still whole.
    every_prefix("c.jsonl", format!("{line}\n{line}\n").as_bytes(), false, reader!(corrections::read));
}

#[test]
fn every_prefix_of_a_native_map_is_refused() {
    let scratch = Scratch::new("prefixes-native");
    native::write(&scratch.path("a.npz"), &Dice::new(1).map(3)).unwrap();
    let whole = fs::read(scratch.path("a.npz")).unwrap();
    let path = scratch.path("b.npz");
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(native::read(&path).is_err(), "cut after {length} of {} bytes", whole.len());
        assert!(io::read(&path).is_err());
    }
}

#[test]
fn no_single_changed_byte_of_a_native_map_makes_a_panic() {
    let scratch = Scratch::new("prefixes-native-bytes");
    native::write(&scratch.path("a.npz"), &Dice::new(1).map(3)).unwrap();
    let mut whole = fs::read(scratch.path("a.npz")).unwrap();
    let path = scratch.path("b.npz");
    for at in 0..whole.len() {
        let was = whole[at];
        whole[at] ^= 1 << (at % 8);
        fs::write(&path, &whole).unwrap();
        let _ = native::read(&path);
        whole[at] = was;
    }
}
