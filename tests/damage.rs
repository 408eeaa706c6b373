//! Damages are what they say, and nothing else is touched.

use std::path::Path;
use std::sync::OnceLock;

use hitl_slam::front_end;
use hitl_slam::geometry::{Information, Pose2, angle_diff};
use hitl_slam::io;
use hitl_slam::map::{LogScan, Observations, RawLog, RelativeFactor, SlamMap};
use hitl_slam::simulate::damage::{self, Damage, Kind, Settings};
use hitl_slam::simulate::{self, Scenario};

use crate::support::{Scratch, message};

/// The first half of the real log that ships with the project.
fn aces() -> &'static RawLog {
    static LOG: OnceLock<RawLog> = OnceLock::new();
    LOG.get_or_init(|| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/aces.clf.bz2");
        let mut log = io::carmen::read(&path).expect("the log of the demo").value;
        log.scans.truncate(3700);
        log
    })
}

fn settings(kind: Kind, seed: u64) -> Settings {
    Settings { kind, count: 1, seed }
}

fn damaged(kind: Kind, seed: u64) -> (RawLog, Damage) {
    let (log, damages) = damage::log(aces(), &settings(kind, seed)).expect("room for it");
    assert_eq!(damages.len(), 1);
    (log, damages[0])
}

fn steps(scans: &[LogScan]) -> Vec<Pose2> {
    scans.windows(2).map(|s| s[0].odometry_from_robot.between(s[1].odometry_from_robot)).collect()
}

/// Indices of the steps that are not as they were.
fn changed_steps(log: &RawLog) -> Vec<usize> {
    let (before, after) = (steps(&aces().scans), steps(&log.scans));
    let differs = |k: &usize| {
        let error = before[*k].between(after[*k]);
        error.translation().norm() > 1e-9 || error.theta_rad.abs() > 1e-9
    };
    (0..before.len()).filter(differs).collect()
}

#[test]
fn a_kick_turns_one_step_by_30_degrees_and_touches_nothing_else() {
    for seed in 1..=20 {
        let (log, d) = damaged(Kind::Kick, seed);
        assert_eq!(changed_steps(&log), [d.first]);
        let turn = steps(&aces().scans)[d.first].between(steps(&log.scans)[d.first]);
        assert!((turn.theta_rad.to_degrees() - d.heading_deg).abs() < 1e-9 && d.heading_deg.abs() == 30.0);
        for (k, (a, b)) in aces().scans.iter().zip(&log.scans).enumerate() {
            assert_eq!((a.stamp_s, &a.ranges_m), (b.stamp_s, &b.ranges_m));
            assert!(k > d.first || a == b, "scan {k} comes before the kick at {}", d.first);
        }
        // A raw log stays one: its logged poses are the odometry.
        assert!(log.scans[d.last..].iter().all(|s| s.world_from_robot == s.odometry_from_robot));
    }
    let ways: Vec<bool> = (1..=20).map(|seed| damaged(Kind::Kick, seed).1.heading_deg > 0.0).collect();
    assert!(ways.contains(&true) && ways.contains(&false), "either way");
}

#[test]
fn a_slip_bends_20_metres_by_34_degrees() {
    for seed in 1..=10 {
        let (log, d) = damaged(Kind::Slip, seed);
        let changed = changed_steps(&log);
        assert!(changed[0] == d.first && changed[changed.len() - 1] < d.last);
        assert!((20.0..21.5).contains(&d.path_m), "{d:?}");
        let (before, after) = (steps(&aces().scans), steps(&log.scans));
        let turned: f64 =
            (d.first..d.last).map(|k| angle_diff(after[k].theta_rad, before[k].theta_rad)).sum();
        assert!((turned.to_degrees() - d.heading_deg).abs() < 1e-6);
        assert!((34.0..37.5).contains(&d.heading_deg.abs()), "{d:?}");
        let longer: f64 =
            (d.first..d.last).map(|k| after[k].translation().norm() - before[k].translation().norm()).sum();
        assert!((longer - 0.0075 * d.path_m).abs() < 1e-6 && (longer - d.stretch_m).abs() < 1e-6);
    }
}

#[test]
fn a_blind_laser_sees_nothing_for_60_seconds_and_the_odometry_goes_on() {
    for seed in 1..=10 {
        let (log, d) = damaged(Kind::Blind, seed);
        let blind_s = d.to_s.expect("stamps") - d.from_s.expect("stamps");
        assert!((59.0..=60.0).contains(&blind_s) && d.path_m > 3.0, "{d:?}");
        for (k, (a, b)) in aces().scans.iter().zip(&log.scans).enumerate() {
            if (d.first..=d.last).contains(&k) {
                let mut seen = Observations::default();
                let options = front_end::Options { max_range_m: 80.0, ..Default::default() };
                front_end::observe(b, log.robot_from_laser, &options, &mut seen);
                assert!(seen.is_empty(), "scan {k} sees something");
                assert_eq!(
                    (a.odometry_from_robot, a.ranges_m.len()),
                    (b.odometry_from_robot, b.ranges_m.len())
                );
            } else {
                assert_eq!(a, b);
            }
        }
    }
}

#[test]
fn what_is_dropped_is_absent_and_the_rest_is_as_it_was() {
    for seed in 1..=10 {
        let (log, d) = damaged(Kind::Drop, seed);
        let all = &aces().scans;
        let kept: Vec<&LogScan> = all[..d.first].iter().chain(&all[d.last + 1..]).collect();
        assert_eq!(log.scans.iter().collect::<Vec<_>>(), kept);
        let gap_s = log.scans[d.first].stamp_s - log.scans[d.first - 1].stamp_s;
        assert!((59.5..61.5).contains(&gap_s), "{gap_s}");
    }
}

#[test]
fn a_drift_bends_every_step_by_its_length() {
    for seed in 1..=5 {
        let (log, d) = damaged(Kind::Drift, seed);
        let per_m = d.heading_deg / d.path_m;
        assert!((0.2..=0.5).contains(&per_m.abs()) && d.stretch_m.abs() <= 0.02 * d.path_m, "{d:?}");
        for (a, b) in steps(&aces().scans).iter().zip(steps(&log.scans)) {
            let bent = angle_diff(b.theta_rad, a.theta_rad).to_degrees();
            assert!((bent - per_m * a.translation().norm()).abs() < 1e-7);
        }
    }
}

#[test]
fn several_damages_lie_apart_and_in_order() {
    for kind in [Kind::Kick, Kind::Slip, Kind::Blind, Kind::Drop] {
        let several = Settings { kind, count: 3, seed: 5 };
        let (_, damages) = damage::log(aces(), &several).expect("room for three");
        assert_eq!(damages.len(), 3);
        assert!(damages.windows(2).all(|d| d[0].last < d[1].first), "{damages:?}");
    }
}

#[test]
fn a_damaged_log_is_read_as_it_was_written_with_the_same_bytes_for_a_seed() {
    let scratch = Scratch::new("damaged-log");
    for kind in Kind::ALL {
        let write = |name: &str, seed| {
            let (log, _) = damaged(kind, seed);
            io::carmen_log::write(&scratch.path(name), &log).expect("written");
            (log, std::fs::read(scratch.path(name)).expect("read"))
        };
        let ((log, first), (_, again), (_, other)) = (write("a", 3), write("b", 3), write("c", 4));
        assert!(first == again && first != other, "{kind}");
        let read = io::carmen::read(&scratch.path("a")).expect("a CARMEN log").value;
        assert_eq!(read.scans.len(), log.scans.len());
        for (a, b) in read.scans.iter().zip(&log.scans) {
            assert_eq!((a.stamp_s, &a.ranges_m), (b.stamp_s, &b.ranges_m));
            assert_eq!(a.odometry_from_robot, b.odometry_from_robot);
        }
    }
}

/// A loop, with a closure and a factor that is written backwards.
fn a_map() -> SlamMap {
    let mut map = simulate::run(Scenario::Loop, &simulate::Settings::default()).expect("a run").map;
    let closure = RelativeFactor {
        i: 0,
        j: 600,
        i_from_j: Pose2::new(1.0, 2.0, 3.0),
        information: Information::from_sigmas(0.1, 0.1, 0.1),
    };
    map.relative_factors.push(closure);
    let backwards = map.relative_factors[300];
    map.relative_factors[300] = RelativeFactor {
        i: backwards.j,
        j: backwards.i,
        i_from_j: backwards.i_from_j.inverse(),
        ..backwards
    };
    map
}

#[test]
fn a_damaged_map_is_chained_anew_and_its_covariance_knows_nothing() {
    let map = a_map();
    for kind in [Kind::Kick, Kind::Slip, Kind::Drift] {
        for seed in 1..=5 {
            let (bad, d) = damage::map(&map, &settings(kind, seed)).expect("room for it");
            let d = d[0];
            assert_eq!(bad.poses[..=d.first], map.poses[..=d.first]);
            assert_eq!(bad.observations, map.observations);
            assert_eq!(bad.relative_factors.last(), map.relative_factors.last(), "closures stay");
            for (a, b) in map.relative_factors.iter().zip(&bad.relative_factors) {
                assert_eq!(a.information, b.information);
                let is_within = (d.first..d.last).contains(&a.i.min(a.j)) && a.i.abs_diff(a.j) == 1;
                assert_eq!(a.i_from_j == b.i_from_j, !is_within, "{kind} {d:?}: {a:?}");
                if a.i.abs_diff(a.j) == 1 {
                    let [x, y, theta] = b.residual(bad.poses[b.i], bad.poses[b.j]);
                    assert!(x.abs() < 1e-9 && y.abs() < 1e-9 && theta.abs() < 1e-9, "chained");
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_damaged_is_refused() {
    let map = a_map();
    for kind in [Kind::Blind, Kind::Drop] {
        let text = message(damage::map(&map, &settings(kind, 1)));
        assert_eq!(text, format!("kind: found {kind}, expected kick, slip or drift: a map has no raw scans"));
    }
    let mut short = aces().clone();
    short.scans = short.scans[1000..1050].to_vec();
    for kind in [Kind::Slip, Kind::Blind, Kind::Drop] {
        assert!(message(damage::log(&short, &settings(kind, 1))).contains("found room for 0 of 1 damages"));
    }
    let too_many = Settings { kind: Kind::Slip, count: 50, seed: 1 };
    assert!(
        message(damage::log(aces(), &too_many)).contains("of 50 damages (slip), expected a longer drive")
    );
    let twice = Settings { kind: Kind::Drift, count: 2, seed: 1 };
    assert!(message(damage::log(aces(), &twice)).contains("count: found 2, expected 1"));
    for scan in &mut short.scans {
        scan.odometry_from_robot = Pose2::IDENTITY;
    }
    assert!(message(damage::log(&short, &settings(Kind::Kick, 1))).contains("a robot that does not move"));
    short.scans.truncate(1);
    assert!(message(damage::log(&short, &settings(Kind::Drift, 1))).contains("a robot that does not move"));
}
