//! From raw logs to closed maps, without a stroke, with one setting: the bounds.

use std::path::{Path, PathBuf};

use hitl_slam::front_end::{self, Chain, Options, Visits};
use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::joint::Backend;
use hitl_slam::map::{RawLog, SlamMap};
use hitl_slam::metrics::{align, relation_errors};

use super::{corrector, reassociate};
use crate::support::{largest_distance_m, shared};

fn ours(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn closed(log: &Path) -> SlamMap {
    closed_log(&io::carmen::read(log).expect("a log").value)
}

/// Log → chain → closed → every scan matched again.
fn closed_log(log: &RawLog) -> SlamMap {
    let (progress, options) = (|_| {}, Options { second_look: false, ..Options::for_scan_matching() });
    let (map, _) =
        front_end::build(log, Chain::ScanMatch { progress: &progress }, &options).expect("a chain");
    let mut corrector = corrector(&map, Backend::Rust);
    let report = reassociate(&mut corrector);
    assert!(!report.withdrawn, "{report:?}");
    let mut map = corrector.into_map();
    front_end::rematch(&mut map, log, Visits::All, &options, &|_| {}).expect("its own log");
    map
}

fn relations_hold(log: &Path, relations: &Path, bound_m: f64, bound_deg: f64) {
    let map = closed(log);
    let relations = io::relations::read(relations).expect("relations").value;
    let errors = relation_errors(&map.trajectory(), &relations, 0.02);
    let (m, deg) = (errors.translation_mean_m.expect("some"), errors.rotation_mean_deg.expect("some"));
    assert!(m <= bound_m && deg <= bound_deg, "all relations: {m} m, {deg}°");
    let disagree = map.automatic_factors.iter().filter(|a| a.disagrees()).count();
    assert!(50 * disagree < map.automatic_factors.len(), "{disagree} of {}", map.automatic_factors.len());
}

#[test]
fn aces_is_better_than_cartographer_without_a_stroke() {
    relations_hold(&ours("aces.clf.bz2"), &ours("aces.relations"), 0.0340, 0.31);
}

#[test]
fn a_map_alone_is_enough_when_its_scans_had_a_second_look() {
    let log = io::carmen::read(&ours("aces.clf.bz2")).expect("a log").value;
    let relations = io::relations::read(&ours("aces.relations")).expect("relations").value;
    let chain = |options: &Options| {
        front_end::build(&log, Chain::ScanMatch { progress: &|_| {} }, options).expect("a chain").0
    };
    let errors = |map: &SlamMap| {
        let errors = relation_errors(&map.trajectory(), &relations, 0.02);
        let short_deg = errors.by_span[0].rotation_mean_deg.expect("some");
        (errors.translation_mean_m.expect("some"), errors.rotation_mean_deg.expect("some"), short_deg)
    };
    let once = chain(&Options { second_look: false, ..Options::for_scan_matching() });
    let twice = chain(&Options::for_scan_matching());
    assert_eq!(once.poses, twice.poses, "only the scans between poses are looked at");
    assert!(errors(&twice).2 < 0.98 * errors(&once).2, "{:?} {:?}", errors(&once), errors(&twice));
    let mut corrector = corrector(&twice, Backend::Rust);
    reassociate(&mut corrector);
    let (m, deg, _) = errors(corrector.map());
    assert!(m <= 0.0340 && deg <= 0.31, "all relations: {m} m, {deg}°");
}

#[test]
fn intel_is_better_than_cartographer_without_a_stroke() {
    let (Some(log), Some(relations)) =
        (shared("radish_raw/intel.clf.bz2"), shared("radish_raw/intel.relations"))
    else {
        return;
    };
    relations_hold(&log, &relations, 0.0130, 0.22);
}

#[test]
fn csail_is_within_8_cm_of_its_reference() {
    let Some(log) = shared("radish_raw/mit-csail.clf.bz2") else { return };
    let Some(reference) = shared("radish_ref/mit-csail.ref.csv") else { return };
    let estimate = closed(&log).trajectory();
    let text = std::fs::read_to_string(reference).expect("a reference");
    let rows = text.lines().skip(1).map(|line| {
        let v: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        (estimate.poses[v[0] as usize].translation(), Vec2::new(v[2], v[3]))
    });
    let pairs: Vec<(Vec2, Vec2)> = rows.collect();
    let aligned = align(&pairs);
    let errors = pairs.iter().map(|(p, q)| (aligned.transform_point(*p) - q).norm_squared());
    let ate_m = (errors.sum::<f64>() / pairs.len() as f64).sqrt();
    assert!(ate_m <= 0.08, "ATE {ate_m} m");
}

#[test]
fn a_map_too_bent_to_tell_right_from_wrong_is_left_alone() {
    // Intel from its wheels: tens of degrees off within a minute. Whatever matches, contradicts itself.
    let Some(log) = shared("radish_raw/intel.clf.bz2") else { return };
    let log = io::carmen::read(&log).expect("a log").value;
    let (map, _) = front_end::build(&log, Chain::Odometry, &Options::default()).expect("a chain");
    let mut corrector = corrector(&map, Backend::Rust);
    let report = reassociate(&mut corrector);
    assert!(report.withdrawn && !report.near_passes.is_empty());
    assert!(corrector.map().automatic_factors.is_empty());
    assert!(largest_distance_m(&corrector.map().poses, &map.poses) < 1e-6);
}

/// The first part of ACES, up to where the robot has come back on itself.
fn piece() -> RawLog {
    let mut log = io::carmen::read(&ours("aces.clf.bz2")).expect("a log").value;
    log.scans.truncate(3000);
    log
}

#[test]
fn a_piece_of_a_log_is_matched_the_same_however_its_odometry_is_turned() {
    let mut log = piece();
    let upright = closed_log(&log);
    assert!(!upright.automatic_factors.is_empty(), "the piece closes a loop");
    let by = Pose2::new(3.0, -4.0, 2.1);
    for scan in &mut log.scans {
        scan.odometry_from_robot = by.compose(scan.odometry_from_robot);
    }
    let turned = closed_log(&log).trajectory();
    let back: Vec<Pose2> = turned.poses.iter().map(|p| by.inverse().compose(*p)).collect();
    let off_m = largest_distance_m(&back, &upright.trajectory().poses);
    assert!(off_m < 1e-3, "{off_m} m");
}

#[test]
fn a_piece_of_a_log_gives_the_same_bits_on_any_number_of_threads() {
    let log = piece();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| closed_log(&log))
    };
    assert!(on(1) == on(3), "chain, automatic factors and every scan");
}

#[test]
fn another_log_is_refused_by_the_second_matching() {
    let log = io::carmen::read(&ours("aces.clf.bz2")).expect("a log").value;
    let mut short = log.clone();
    short.scans.truncate(200);
    let (mut map, _) = front_end::build(&short, Chain::Odometry, &Options::default()).expect("a chain");
    let before = map.clone();
    let error = front_end::rematch(&mut map, &log, Visits::All, &Options::default(), &|_| {})
        .expect_err("another log");
    assert!(error.to_string().contains("found 7374 scans, expected"), "{error}");
    assert_eq!(map, before);
}
