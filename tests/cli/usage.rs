//! Wrong usage, and help.

use std::ffi::OsString;

use super::{Bench, hitl_with};

const CORRECT: &str = "correct run/map.npz -c run/corrections.jsonl -o o.npz";

#[test]
fn without_arguments_the_help_comes_with_exit_code_2() {
    let run = Bench::new("no-arguments").hitl("");
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""));
    assert!(run.stderr.contains("Usage: hitl <COMMAND>") && run.stderr.contains("First steps"));
}

#[test]
fn version_and_help_go_to_stdout() {
    let bench = Bench::new("help");
    let version = format!("hitl {}\nback ends: rust", env!("CARGO_PKG_VERSION"));
    assert!(bench.good("--version").starts_with(&version));
    for command in ["info", "import", "correct", "crosscheck", "optimize", "evaluate", "render", "simulate"] {
        assert!(bench.good("help").contains(&format!("\n  {command} ")), "{command}");
        let page = bench.good(&format!("{command} --help"));
        assert!(page.contains(&format!("Usage: hitl {command}")), "{page}");
        assert_eq!(page, bench.good(&format!("help {command}")));
    }
    let page = bench.good("correct --help");
    for word in ["colocation", "collinear", "parallel", "perpendicular", "--interpret-only", "default: 0.05"]
    {
        assert!(page.contains(word), "{word}");
    }
}

#[test]
fn wrong_values_of_flags_are_named_with_the_flag() {
    let bench = Bench::with_loop("flags");
    for (flags, found) in [
        ("--drawing-sigma-m -1", "--drawing-sigma-m: found -1, expected a number > 0"),
        ("--drawing-sigma-m nan", "--drawing-sigma-m: found NaN, expected a number > 0"),
        ("--drawing-sigma-m inf", "--drawing-sigma-m: found inf, expected a number > 0"),
        ("--drawing-sigma-m 5cm", "--drawing-sigma-m <M>: found '5cm', expected a number"),
        ("--observation-sigma-m 0", "--observation-sigma-m: found 0, expected a number > 0"),
        ("--tie-sigma-m 0", "--tie-sigma-m: found 0, expected"),
        ("--offset-sigma-m -0.1", "--offset-sigma-m: found -0.1, expected"),
        ("--angle-sigma-rad nan", "--angle-sigma-rad: found NaN, expected"),
        ("--min-points 0", "--min-points: found 0, expected 1 or more"),
        ("--min-points -3", "--min-points <N>: found '-3', expected a whole number of 0 or more"),
        ("--loss-scale 0", "--loss-scale: found 0, expected a number > 0"),
        ("--max-iterations 0", "--max-iterations: found 0, expected 1 or more"),
        ("--loss tukey", "--loss <LOSS>: found 'tukey', expected one of none, huber, cauchy, geman-mcclure"),
        ("--loss", "--loss <LOSS>: found nothing, expected one of none, huber"),
        ("--frobnicate", "--frobnicate: found an unknown argument, expected"),
        ("--report o.npz", "--report: found the same file as for --output, expected another"),
        ("--strict --strict", "--strict: found more than once, expected it once"),
    ] {
        bench.refused(&format!("{CORRECT} {flags}"), &[found]);
    }
    for (arguments, found) in [
        ("correct run/map.npz", "--corrections <C.jsonl>, --output <OUT>: found nothing"),
        ("frobnicate", "command: found 'frobnicate', expected one that `hitl help` lists"),
        ("imprt a.log", "command: found 'imprt', expected export, import or one that"),
        ("simulate spiral -o x", "<SCENARIO>: found 'spiral', expected one of loop, campus"),
        ("simulate loop --drift -1 -o x", "drift: found -1, expected"),
        ("simulate loop --drift nan -o x", "drift: found NaN, expected"),
        ("evaluate run/map.npz --plot x.png", "--truth <T.tum>: found nothing"),
        (
            "evaluate run/map.npz --truth run/truth.tum --plot x.gif",
            "x.gif: found .gif, expected .png or .svg",
        ),
        (
            "evaluate run/map.npz --picture x.png",
            "--picture: found neither --truth nor --relations, expected",
        ),
        (
            "evaluate run/map.npz --truth run/truth.tum --picture x.gif",
            "x.gif: found .gif, expected .png or .svg",
        ),
        ("evaluate run/map.npz --tolerance-s -1", "--tolerance-s: found -1, expected"),
        ("render run/map.npz -o x.png --size-px 3", "--size-px <N>: found '3', expected 120..=7000"),
        ("render run/map.npz -o x.png --crop 1,1,1,1", "--crop: found \"1,1,1,1\", expected x0,y0,x1,y1"),
        ("render run/map.npz -o x.png --crop 1,nan,1,1", "--crop: "),
        ("import run/map.npz -o x.npz --front-end odometry", "run/map.npz: found a map, expected a log"),
        ("import run/map.npz -o x.npz --front-end none --initial x", "found together with"),
    ] {
        bench.refused(arguments, &[found]);
    }
}

#[test]
fn wrong_keyframe_options_are_named_with_the_flag() {
    let bench = Bench::new("keyframes");
    bench.scratch.file("a.log", crate::support::small_log(3));
    for (flags, found) in [
        ("--keyframe-distance-m 0", "--keyframe-distance-m: found 0, expected a number > 0"),
        ("--keyframe-angle-deg -1", "--keyframe-angle-deg: found -1, expected a number > 0"),
        ("--max-range-m inf", "--max-range-m: found inf, expected a number > 0"),
        ("--min-range-m 99", "--min-range-m: found 99, expected"),
        ("--min-range-m nan", "--min-range-m: found NaN, expected"),
    ] {
        bench.refused(&format!("import a.log -o a.npz {flags}"), &[found]);
    }
}

#[test]
fn places_that_cannot_be_written_are_found_before_the_work() {
    let bench = Bench::with_loop("places");
    bench.scratch.file("file", "old");
    std::fs::create_dir(bench.scratch.path("folder.npz")).unwrap();
    let start = "correct run/map.npz -c run/corrections.jsonl";
    for (arguments, found) in [
        (format!("{start} -o o.xyz"), "o.xyz: found no known extension, expected .npz, .g2o"),
        (format!("{start} -o o"), "o: found no known extension"),
        (format!("{start} -o file/o.npz"), "file/o.npz: found the file file, expected a folder"),
        (format!("{start} -o folder.npz"), "folder.npz: found a folder, expected the name of a file"),
        (format!("{start} -o new/o.npz --report file/r.json"), "file/r.json: found the file file"),
        (format!("{start} -o o.npz --trajectory file/t.tum"), "file/t.tum: found the file file"),
        (format!("{start} -o o.npz --pictures file"), "found the file file, expected a folder"),
        (format!("{start} -o o.npz --report ."), ".: found a folder"),
        ("import run/map.npz -o file/o.npz".into(), "found the file file"),
        ("evaluate run/map.npz --report file/r.json".into(), "found the file file"),
        ("render run/map.npz -o file/o.png".into(), "found the file file"),
        ("simulate loop -o file".into(), "found the file file"),
    ] {
        bench.refused(&arguments, &[found]);
    }
    #[cfg(target_os = "linux")] // not even root can make a file there
    bench.refused(&format!("{start} -o /proc/o.npz"), &["/proc/o.npz: found that no file can be made there"]);
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf8_are_names_all_the_same() {
    use std::os::unix::ffi::OsStringExt;
    let bench = Bench::with_loop("names");
    let name = |end: &str| OsString::from_vec([b"m\xffp", end.as_bytes()].concat());
    std::fs::copy(bench.scratch.path("run/map.npz"), bench.folder().join(name(".npz"))).unwrap();
    let run = hitl_with(&bench.folder(), ["import".into(), name(".npz"), "-o".into(), name(".g2o")]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(bench.folder().join(name(".g2o")).exists());
}
