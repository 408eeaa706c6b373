//! Small valid files with a few bytes changed, through the readers and everything behind them: no panic.

use std::io::{Read, Write};
use std::path::Path;

use hitl_slam::front_end::{self, Chain};
use hitl_slam::io::{self, Source, corrections};
use hitl_slam::metrics::{DEFAULT_TOLERANCE_S, Reference, evaluate};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::{interpret, render};

use super::{Bench, SMALL_CORRECTIONS, small_map};
use crate::support::{Dice, small_log};

const MUTATIONS: usize = 200;

/// Bytes that do harm in text, and some that do in binary.
const BYTES: &[u8] = b"0123456789-+.eE ,\n\t\"[]{}#nN\0\x01\x7f\x80\xff";

fn mutated(whole: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..1 + dice.uniform(0.0, 3.0) as usize {
        let at = dice.uniform(0.0, bytes.len() as f64) as usize;
        if bytes[at].is_ascii_digit() && dice.uniform(0.0, 1.0) < 0.8 {
            bytes[at] = b'0' + dice.uniform(0.0, 10.0) as u8; // still a number
            continue;
        }
        let byte = BYTES[dice.uniform(0.0, BYTES.len() as f64) as usize];
        match dice.uniform(0.0, 4.0) as usize {
            0 => bytes.insert(at, byte),
            1 if bytes.len() > 2 => drop(bytes.remove(at)),
            2 => bytes[at] ^= 1 << (at % 8),
            _ => bytes[at] = byte,
        }
    }
    bytes
}

/// Reads a file and does with it all that the program does; false if it could not be read.
fn is_read(path: &Path, corrections: &Path) -> bool {
    match io::read(path) {
        Ok((_, read)) => {
            use_all(read.value, corrections);
            true
        }
        Err(_) => false,
    }
}

fn use_all(source: Source, corrections_path: &Path) {
    let map = match source {
        Source::Map(map) => map,
        Source::Log(log) => match front_end::build(&log, Chain::Odometry, &front_end::Options::default()) {
            Ok((map, _)) => map,
            Err(_) => return,
        },
        _ => return,
    };
    map.validate("a map that was read").unwrap();
    let truth = map.trajectory();
    let reference =
        Reference { truth: Some(&truth), relations: None, walls: None, tolerance_s: DEFAULT_TOLERANCE_S };
    let _ = evaluate(&map, &reference);
    let _ = render::map(&map, &render::MapPictureOptions { size_px: 120, ..Default::default() }).to_png();
    let Ok(read) = corrections::read(corrections_path) else { return };
    if interpret::check(&map, &read.value).is_err() {
        return;
    }
    let Ok(mut corrector) = Corrector::new(map, Options::default()) else { return };
    for correction in &read.value {
        corrector.apply(correction).unwrap();
    }
    corrector.map().validate("a corrected map").unwrap();
}

/// Says how many of the damaged files could be read.
fn mutate(test: &str, name: &str, whole: &[u8]) -> usize {
    let bench = Bench::new(&format!("mutate-{test}"));
    let corrections = bench.scratch.file("c.jsonl", SMALL_CORRECTIONS);
    let path = bench.scratch.file(name, whole);
    assert!(is_read(&path, &corrections), "undamaged");
    let mut read = 0;
    let mut dice = Dice::new(20 + whole.len() as u64);
    for round in 0..MUTATIONS {
        std::fs::write(&path, mutated(whole, &mut dice)).unwrap();
        read += usize::from(is_read(&path, &corrections));
        if round % 20 == 0 {
            let run = bench.hitl(&format!("correct {name} -c c.jsonl -o o.npz"));
            assert!(matches!(run.code, Some(0 | 2)), "round {round}: {:?} {}", run.code, run.stderr);
            let notes = run.stderr.lines().filter(|l| l.starts_with("hitl: note: ")).count();
            let lines = run.stderr.lines().count() - notes;
            assert_eq!(lines, usize::from(run.code == Some(2)), "round {round}: {}", run.stderr);
        }
    }
    read
}

fn mutate_written(extension: &str) -> usize {
    let bench = Bench::new(&format!("to-mutate-{extension}"));
    let name = format!("a.{extension}");
    io::write_map(&bench.scratch.path(&name), &small_map()).unwrap();
    mutate(extension, &name, &bench.bytes(&name))
}

#[test]
fn damaged_native_maps_make_no_panic() {
    mutate_written("npz");
}

/// The checksums of the archive catch nearly all damage, so here every array is damaged before it is packed.
#[test]
fn native_maps_with_damaged_arrays_make_no_panic() {
    let bench = Bench::new("mutate-arrays");
    let corrections = bench.scratch.file("c.jsonl", SMALL_CORRECTIONS);
    let mut corrector = Corrector::new(small_map(), Options::default()).unwrap();
    for correction in corrections::read(&corrections).unwrap().value {
        let report = corrector.apply(&correction).unwrap();
        assert!(report.accepted(), "{:?}", report.rejection);
    }
    let mut map = corrector.into_map();
    map.vertex_ids = Some((0..map.poses.len() as i64).collect());
    let path = bench.scratch.path("a.npz");
    io::native::write(&path, &map).unwrap();
    let arrays = unpack(&path);
    std::fs::write(&corrections, SMALL_CORRECTIONS.replace("one", "two")).unwrap();
    let mut dice = Dice::new(3);
    let mut read = 0;
    for damaged in 0..arrays.len() {
        for _ in 0..40 {
            let mut changed = arrays.clone();
            let bytes = &mut changed[damaged].1;
            // Past the header, mostly; at the first numbers, often.
            let from = if dice.uniform(0.0, 1.0) < 0.2 { 0 } else { 128.min(bytes.len() - 1) };
            let to = if dice.uniform(0.0, 1.0) < 0.5 { bytes.len() } else { bytes.len().min(from + 64) };
            let at = dice.uniform(from as f64, to as f64) as usize;
            bytes[at] = if dice.uniform(0.0, 1.0) < 0.5 { 0xff } else { dice.uniform(0.0, 256.0) as u8 };
            pack(&path, &changed);
            read += usize::from(is_read(&path, &corrections));
        }
    }
    assert!(read > 100, "{read} of {} could be read", 40 * arrays.len());
}

fn unpack(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let mut arrays = Vec::new();
    for k in 0..archive.len() {
        let mut entry = archive.by_index(k).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        arrays.push((name, bytes));
    }
    arrays
}

fn pack(path: &Path, arrays: &[(String, Vec<u8>)]) {
    let mut archive = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    let options = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, bytes) in arrays {
        archive.start_file(name.as_str(), options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap();
}

#[test]
fn damaged_stfs_maps_make_no_panic() {
    assert!(mutate_written("stfs.covars") > 20);
}

#[test]
fn damaged_graphs_make_no_panic() {
    assert!(mutate_written("g2o") > 20);
}

#[test]
fn damaged_trajectories_make_no_panic() {
    assert!(mutate_written("tum") > 20);
}

#[test]
fn damaged_logs_make_no_panic() {
    assert!(mutate("log", "a.log", small_log(40).as_bytes()) > 20);
    let line = "ROBOTLASER1 0 -1.57 3.14 1.57 80 0.01 0 3 1 2 3 0 0.2 0 0 0 0 0 0 0 0 0 0 5.5 host 0\n";
    assert!(mutate("robotlaser", "a.log", line.repeat(5).as_bytes()) > 20);
}

#[test]
fn damaged_compressed_logs_make_no_panic() {
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gz.write_all(small_log(40).as_bytes()).unwrap();
    mutate("gz", "a.log.gz", &gz.finish().unwrap());
    let mut bz2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
    bz2.write_all(small_log(40).as_bytes()).unwrap();
    mutate("bz2", "a.log.bz2", &bz2.finish().unwrap());
}

#[test]
fn damaged_corrections_make_no_panic() {
    let bench = Bench::new("mutate-corrections");
    let map = small_map();
    io::native::write(&bench.scratch.path("a.npz"), &map).unwrap();
    let path = bench.scratch.path("c.jsonl");
    let whole = SMALL_CORRECTIONS.as_bytes();
    let mut dice = Dice::new(9);
    let mut read_all = 0;
    for _ in 0..2 * MUTATIONS {
        std::fs::write(&path, mutated(whole, &mut dice)).unwrap();
        let Ok(read) = corrections::read(&path) else { continue };
        if interpret::check(&map, &read.value).is_err() {
            continue;
        }
        read_all += 1;
        let mut corrector = Corrector::new(map.clone(), Options::default()).unwrap();
        for correction in &read.value {
            corrector.apply(correction).unwrap();
        }
        corrector.map().validate("a corrected map").unwrap();
    }
    assert!(read_all > 20, "{read_all} of them could be applied");
}
