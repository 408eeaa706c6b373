use std::fs;
use std::io::{Read as _, Write as _};
use std::process::Command;

use hitl_slam::io::{native, stfs};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::support::{Dice, Scratch, message};

type Arrays = Vec<(String, Vec<u8>)>;

fn arrays(path: &std::path::Path) -> Arrays {
    let mut zip = ZipArchive::new(fs::File::open(path).unwrap()).unwrap();
    let read = |k: usize| {
        let mut entry = zip.by_index(k).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.name().unwrap().trim_end_matches(".npy").to_string(), bytes)
    };
    (0..ZipArchive::new(fs::File::open(path).unwrap()).unwrap().len()).map(read).collect()
}

fn pack(path: &std::path::Path, arrays: &Arrays, method: CompressionMethod) {
    let mut zip = ZipWriter::new(fs::File::create(path).unwrap());
    for (name, bytes) in arrays {
        let options = SimpleFileOptions::default().compression_method(method);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}

#[test]
fn a_map_comes_back_bit_for_bit_and_equal_maps_make_equal_files() {
    let scratch = Scratch::new("native-round-trip");
    for seed in 0..20 {
        let mut map = Dice::new(seed).map(12);
        if seed % 2 == 1 {
            (map.stamps_s, map.vertex_ids) = (None, None);
            map.human_factors.clear();
            map.held.clear();
        }
        native::write(&scratch.path("a.npz"), &map).unwrap();
        let read = native::read(&scratch.path("a.npz")).unwrap().value;
        assert_eq!(read, map, "seed {seed}");
        native::write(&scratch.path("b.npz"), &read).unwrap();
        assert_eq!(fs::read(scratch.path("a.npz")).unwrap(), fs::read(scratch.path("b.npz")).unwrap());
    }
}

/// Turning a covariance into a factor's frame once left Ω asymmetric in its last bit: the file that was read back differed.
#[test]
fn imported_maps_come_back_bit_for_bit_too() {
    let scratch = Scratch::new("native-imported");
    for seed in 0..5 {
        let mut map = Dice::new(seed).map(40);
        map.relative_factors.retain(|f| f.j == f.i + 1);
        stfs::write(&scratch.path("a.stfs.covars"), &map).unwrap();
        let imported = stfs::read(&scratch.path("a.stfs.covars")).unwrap().value;
        native::write(&scratch.path("a.npz"), &imported).unwrap();
        assert_eq!(native::read(&scratch.path("a.npz")).unwrap().value, imported, "seed {seed}");
    }
}

#[test]
fn compressed_archives_and_unknown_fields_are_read() {
    let scratch = Scratch::new("native-deflated");
    let map = Dice::new(3).map(8);
    native::write(&scratch.path("a.npz"), &map).unwrap();
    let mut all = arrays(&scratch.path("a.npz"));
    all.push(("added_later".into(), b"anything".to_vec()));
    all.reverse();
    pack(&scratch.path("b.npz"), &all, CompressionMethod::Deflated);
    assert_eq!(native::read(&scratch.path("b.npz")).unwrap().value, map);
}

/// Replaces `from` by `to` in one array's header or data and reads the result.
fn tampered(field: &str, change: impl Fn(&mut Vec<u8>)) -> String {
    let scratch = Scratch::new(&format!("native-tampered-{field}"));
    native::write(&scratch.path("a.npz"), &Dice::new(5).map(4)).unwrap();
    let mut all = arrays(&scratch.path("a.npz"));
    let (_, bytes) = all.iter_mut().find(|(name, _)| name == field).unwrap();
    change(bytes);
    pack(&scratch.path("a.npz"), &all, CompressionMethod::Stored);
    message(native::read(&scratch.path("a.npz")))
}

fn replace(bytes: &mut [u8], from: &str, to: &str) {
    assert_eq!(from.len(), to.len());
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
}

#[test]
fn wrong_shapes_types_and_numbers_are_named_by_field() {
    let float = |v: f64| move |b: &mut Vec<u8>| b[128..136].copy_from_slice(&v.to_le_bytes());
    let cases = [
        (
            tampered("poses", |b| replace(b, "(4,3,)", "(3,4,)")),
            "poses: found shape [3, 4], expected [rows, 3]",
        ),
        (
            tampered("poses", |b| replace(b, "<f8", ">f8")),
            "poses: found type '>f8', expected one of <f8, <f4, <i8, <i4, <u4, |u1",
        ),
        (
            tampered("poses", |b| replace(b, "False", "True ")),
            "poses: found Fortran order, expected C order (numpy.ascontiguousarray)",
        ),
        (tampered("poses", |b| b[0] = 0), "poses: found no numpy array, expected a .npy header"),
        (
            tampered("poses", |b| b.truncate(130)),
            "poses: found damaged or cut-off data (failed to fill whole buffer)",
        ),
        (tampered("poses", |b| b.push(0)), "poses: found more than 12 numbers, expected the shape [4, 3]"),
        (
            tampered("poses", float(f64::NAN)),
            "poses: pose 0: found a value that is not finite, expected finite numbers",
        ),
        (
            tampered("stamps", float(f64::INFINITY)),
            "stamps: found a value that is not finite, expected finite numbers",
        ),
        (
            tampered("robot_from_laser", float(f64::NAN)),
            "robot_from_laser: expected three finite numbers: x, y, theta",
        ),
        (
            tampered("relative_information", float(-1.0)),
            "relative_information: factor 0: information matrix: found one that is not positive definite, expected a positive definite one",
        ),
        (
            tampered("points_pose", |b| b[128] = 9),
            "points_pose: point 0: found pose 9, expected ascending poses below 4",
        ),
        (tampered("scan_parent", |b| b[128..132].fill(255)), "scan_parent: found -1, expected 0 or more"),
        (
            tampered("human_mode", |b| b[128] = 4),
            "human_mode: wall “colocation”, 'c': found code 4, expected 0 to 3",
        ),
        (
            tampered("human_weight", float(0.0)),
            "human factors: wall “colocation”, 'c': found weight 0, expected a number > 0",
        ),
        (
            tampered("human_points_start", |b| b[128] = 1),
            "human_points_start: expected 9 ascending bounds from 0 to 24",
        ),
        (tampered("format_version", |b| b[128] = 2), "format_version: found [2], expected [1]"),
        (tampered("held", |b| replace(b, "<i4", "<f4")), "held: found 0, expected whole numbers"),
    ];
    for (found, expected) in cases {
        assert_eq!(found, format!("a.npz: {expected}"));
    }
    let deep = tampered("poses", |b| {
        b.truncate(0);
        b.extend_from_slice(b"\x93NUMPY\x02\x00\xff\xff\x00\x00");
        b.resize(66_000, b'(');
    });
    assert!(deep.starts_with("a.npz: poses: found the header '((("), "{}", &deep[..60]);
    let huge = tampered("points_range", |b| replace(b, "(40,), }           ", "(9999999999999999,)"));
    assert!(huge.starts_with("a.npz: points_range: found "), "{huge}");
}

#[test]
fn a_missing_field_is_named() {
    let scratch = Scratch::new("native-missing");
    native::write(&scratch.path("a.npz"), &Dice::new(5).map(4)).unwrap();
    let mut all = arrays(&scratch.path("a.npz"));
    all.retain(|(name, _)| name != "points_xy");
    pack(&scratch.path("a.npz"), &all, CompressionMethod::Stored);
    let text = message(native::read(&scratch.path("a.npz")));
    assert!(text.starts_with("a.npz: points_xy: found no such array"), "{text}");
}

#[test]
fn numpy_opens_a_native_map() {
    let has_numpy = Command::new("python3").args(["-c", "import numpy"]).output();
    if !has_numpy.is_ok_and(|o| o.status.success()) {
        println!("skipped: python3 with numpy is absent");
        return;
    }
    let scratch = Scratch::new("native-numpy");
    let map = Dice::new(9).map(6);
    native::write(&scratch.path("a.npz"), &map).unwrap();
    let script = "import numpy, sys, json\nm = numpy.load(sys.argv[1])\n\
        assert m['points_normal'].dtype == numpy.float32 and m['relative_information'].shape[1:] == (3, 3)\n\
        assert len(json.loads(m['human_ids'].tobytes())) == 4\n\
        for k in m.files: m[k]\n\
        numpy.savez_compressed(sys.argv[2], **m)\n";
    let (a, b) = (scratch.path("a.npz"), scratch.path("b.npz"));
    let output = Command::new("python3").arg("-c").arg(script).args([&a, &b]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(native::read(&b).unwrap().value, map);
}

#[test]
fn a_map_from_before_automatic_factors_is_read() {
    let scratch = Scratch::new("native-older");
    let mut map = Dice::new(5).map(8);
    native::write(&scratch.path("a.npz"), &map).unwrap();
    let mut all = arrays(&scratch.path("a.npz"));
    all.retain(|(name, _)| !name.starts_with("automatic_"));
    pack(&scratch.path("b.npz"), &all, CompressionMethod::Stored);
    map.automatic_factors.clear();
    assert_eq!(native::read(&scratch.path("b.npz")).unwrap().value, map);
}
