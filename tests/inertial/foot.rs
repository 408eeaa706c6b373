//! Steps of a simulated foot: against the truth, and what must not matter.

use hitl_slam::geometry::{Vec2, angle_diff};
use hitl_slam::inertial::filter::Nominal;
use hitl_slam::inertial::{self, Mount, Options, Pdr, Recording, Sample};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::walker::{FootWalk, GRAVITY, STANDS_S, Sensor};
use crate::support::Dice;

const STRIDES: usize = 40;

fn reckon(recording: &Recording, options: &Options) -> Pdr {
    inertial::reckon("imu.csv", recording, options).unwrap()
}

fn path(pdr: &Pdr) -> Vec<Vec2> {
    pdr.walk("w").track(Default::default()).iter().map(|p| p.translation()).collect()
}

fn turned(seed: u64) -> UnitQuaternion<f64> {
    let mut dice = Dice::new(seed);
    UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| dice.normal(2.0)))
}

/// Biases of a usual sensor: 17°/min.
fn biased() -> Sensor {
    Sensor {
        rate_bias: Vector3::new(0.003, -0.002, 0.005),
        force_bias: Vector3::new(0.05, -0.04, 0.03),
        ..Sensor::default()
    }
}

#[test]
fn every_stride_is_found_and_the_path_is_true() {
    for seed in 1..=6 {
        let walk = FootWalk::random(STRIDES, seed);
        let pdr = reckon(&walk.recording(&biased(), seed), &Options::default());
        assert_eq!((pdr.mount, pdr.steps.len()), (Mount::Foot, STRIDES), "seed {seed}");
        let errors: Vec<f64> =
            path(&pdr).iter().zip(walk.positions()).map(|(p, t)| (*p - t).norm()).collect();
        // The frame begins with the mean walking direction, which is not known better than a degree.
        let worst = errors.iter().copied().fold(0.0, f64::max);
        assert!(worst < 0.02 * 1.3 * STRIDES as f64, "seed {seed}: {worst} m");
        for (k, event) in pdr.steps.iter().enumerate() {
            let between = walk.stances[k].between(walk.stances[k + 1]);
            let length = between.translation().norm();
            assert!((event.step.length_m() - length).abs() < 0.02, "seed {seed}, stride {k}");
            assert!(
                angle_diff(event.step.turn_rad, between.theta_rad).abs() < 0.01,
                "seed {seed}, stride {k}"
            );
            assert!((event.step.time_s - walk.lands_s(k + 1)).abs() < 0.1, "seed {seed}, stride {k}");
            assert!(event.rests_until_s > event.step.time_s + 0.3);
        }
        assert!((pdr.starts_s - STANDS_S).abs() < 0.15, "{}", pdr.starts_s);
    }
}

#[test]
fn a_still_start_takes_off_the_heading_drift_that_a_bias_makes() {
    let walk = FootWalk::random(STRIDES, 2);
    let recording = walk.recording(&biased(), 9);
    let heading_error = |options: &Options| {
        let turned: f64 = reckon(&recording, options).steps.iter().map(|e| e.step.turn_rad).sum();
        let truth = walk.stances[0].between(walk.stances[STRIDES]).theta_rad;
        angle_diff(turned, truth).abs().to_degrees()
    };
    let with = heading_error(&Options::default());
    let without = heading_error(&Options { still_bias: false, ..Options::default() });
    // 0.005 rad/s over 42 s are 12°.
    assert!(with < 1.0 && without > 8.0, "{with}° and {without}°");
    let pdr = reckon(&recording, &Options::default());
    let bias = Vector3::from(pdr.gyro_bias_radps.unwrap());
    assert!((bias - biased().rate_bias).norm() < 1e-3, "{bias}");
}

#[test]
fn the_sensor_may_be_mounted_in_any_way() {
    let walk = FootWalk::random(STRIDES, 3);
    let straight = walk.recording(&biased(), 5);
    let reference = path(&reckon(&straight, &Options::default()));
    for seed in 1..=8 {
        let q = turned(seed);
        let turn = |s: &Sample| Sample { force_mps2: q * s.force_mps2, rate_radps: q * s.rate_radps, ..*s };
        let recording = Recording { samples: straight.samples.iter().map(turn).collect() };
        let pdr = reckon(&recording, &Options::default());
        let worst = path(&pdr).iter().zip(&reference).map(|(a, b)| (*a - *b).norm()).fold(0.0, f64::max);
        assert!(pdr.steps.len() == STRIDES && worst < 0.02, "rotation {seed}: {worst} m");
    }
}

#[test]
fn a_sensor_exactly_upside_down_is_levelled() {
    let up = Vector3::new(0.0, 0.0, -9.9);
    let state = Nominal::at_rest(up, Vector3::zeros(), GRAVITY);
    let felt = state.n_from_b * (up - state.force_bias_mps2);
    assert!((felt - Vector3::z() * GRAVITY).norm() < 1e-12, "{felt}");
}

#[test]
fn the_sampling_rate_does_not_matter() {
    let walk = FootWalk::random(20, 6);
    for rate_hz in [100.0, 250.0, 400.0] {
        let pdr = reckon(&walk.recording(&Sensor { rate_hz, ..Sensor::default() }, 7), &Options::default());
        let end = *path(&pdr).last().unwrap();
        assert_eq!(pdr.steps.len(), 20, "{rate_hz} Hz");
        assert!((end - *walk.positions().last().unwrap()).norm() < 0.5, "{rate_hz} Hz: {end:?}");
    }
}

#[test]
fn covariances_are_valid_and_cover_the_errors() {
    let (mut within, mut all) = (0, 0);
    for seed in 1..=6 {
        let walk = FootWalk::random(STRIDES, seed);
        let pdr = reckon(&walk.recording(&biased(), seed + 50), &Options::default());
        for (k, event) in pdr.steps.iter().enumerate() {
            let c: Matrix3<f64> = event.covariance;
            assert!((c - c.transpose()).amax() < 1e-15 && c.symmetric_eigenvalues().min() > 0.0);
            let truth = walk.stances[k].between(walk.stances[k + 1]);
            let error = event.step.length_m() - truth.translation().norm();
            all += 1;
            within += usize::from(error.abs() < 2.0 * c[(0, 0)].sqrt());
        }
    }
    assert!(within as f64 > 0.9 * f64::from(all), "{within} of {all} strides are within two sigma");
}

#[test]
fn standing_still_emits_nothing_and_is_a_standstill_of_the_walk() {
    let walk = FootWalk::random(6, 8);
    let one = walk.recording(&Sensor::default(), 1);
    let standing = FootWalk { stances: vec![Default::default()] }.recording(&Sensor::default(), 2);
    let mut samples = one.samples.clone();
    for part in [&standing, &one] {
        let from_s = samples.last().unwrap().time_s + 0.005;
        samples.extend(part.samples.iter().map(|s| Sample { time_s: s.time_s + from_s, ..*s }));
    }
    let pdr = reckon(&Recording { samples }, &Options::default());
    assert_eq!(pdr.steps.len(), 12);
    let pauses = pdr.walk("w").standstills();
    assert_eq!(pauses.len(), 1, "{pauses:?}");
    assert_eq!(pauses[0].steps_before, 6);
}

#[test]
fn a_dropout_within_a_walk_is_bridged_and_reported() {
    for (seed, from_s, lasts_s) in [(1, 12.1, 0.1), (2, 12.3, 0.3), (3, 15.0, 0.6), (4, 20.2, 0.9)] {
        let walk = FootWalk::random(STRIDES, seed);
        let mut recording = walk.recording(&biased(), seed);
        recording.samples.retain(|s| s.time_s < from_s || s.time_s > from_s + lasts_s);
        let pdr = reckon(&recording, &Options::default());
        assert_eq!(pdr.dropouts.len(), 1);
        let found = &pdr.dropouts[0];
        assert!((found.from_s - from_s).abs() < 0.01 && (found.to_s - from_s - lasts_s).abs() < 0.01);
        // Of the 50 m nothing is lost but what a typical stride may differ from this one.
        let length: f64 = pdr.steps.iter().map(|e| e.step.length_m()).sum();
        let truth: f64 = walk.stances.windows(2).map(|w| w[0].between(w[1]).translation().norm()).sum();
        assert!((length - truth).abs() < 0.6, "{lasts_s} s lost: {length} m of {truth}");
        assert!(pdr.steps.len() + 1 >= STRIDES, "{lasts_s} s lost: {} steps", pdr.steps.len());
    }
}

#[test]
fn a_stuck_sensor_is_a_dropout_too() {
    let walk = FootWalk::random(STRIDES, 5);
    let mut recording = walk.recording(&biased(), 5);
    let frozen = recording.samples[2_000].rate_radps;
    recording.samples[2_000..2_050].iter_mut().for_each(|s| s.rate_radps = frozen);
    let pdr = reckon(&recording, &Options::default());
    assert_eq!(pdr.dropouts.len(), 1);
    assert_eq!(pdr.dropouts[0].what, "a sensor was stuck");
    let end = *path(&pdr).last().unwrap();
    assert!((end - *walk.positions().last().unwrap()).norm() < 2.5, "{end:?}");
}
