//! Steps of a simulated hand.

use hitl_slam::inertial::{self, Mount, Options, Pdr};
use nalgebra::{UnitQuaternion, Vector3};

use super::walker::{STANDS_S, Sensor, hand_recording};
use crate::support::Dice;

fn reckon(turn_per_step: f64, swing: f64, sensor: &Sensor, seed: u64) -> Pdr {
    inertial::reckon("imu.csv", &hand_recording(60, turn_per_step, swing, sensor, seed), &Options::default())
        .unwrap()
}

#[test]
fn every_step_is_found_with_weinbergs_length_and_the_turn_about_gravity() {
    for (seed, swing) in [(1, 4.0), (2, 6.0), (3, 9.0)] {
        let sensor = Sensor { rate_bias: Vector3::new(0.002, 0.001, -0.004), ..Sensor::default() };
        let pdr = reckon(0.05, swing, &sensor, seed);
        assert_eq!(pdr.mount, Mount::Hand);
        assert!(pdr.steps.len().abs_diff(60) <= 1, "{} steps", pdr.steps.len());
        let turned: f64 = pdr.steps.iter().map(|e| e.step.turn_rad).sum();
        // The walk faces as its first four steps do, in the mean.
        assert!((turned - 57.5 * 0.05).abs() < 0.1, "turned by {turned}");
        let typical = pdr.walk("w").typical_length_m();
        let expected = Options::default().weinberg_gain * swing.powf(0.25);
        // Smoothing takes a little off the swing.
        assert!(typical < expected && typical > 0.8 * expected, "{typical} of {expected}");
        let first = pdr.steps[0].step.time_s;
        assert!((first - STANDS_S).abs() < 0.6, "{first}");
    }
}

#[test]
fn a_step_twice_as_lively_is_longer_by_its_fourth_root() {
    let length = |swing| reckon(0.0, swing, &Sensor::default(), 4).walk("w").typical_length_m();
    let ratio = length(8.0) / length(4.0);
    assert!((ratio - 2f64.powf(0.25)).abs() < 0.01, "{ratio}");
}

#[test]
fn the_phone_may_be_held_in_any_way() {
    let reference = reckon(0.03, 6.0, &Sensor::default(), 5);
    for seed in 1..=6 {
        let mut dice = Dice::new(seed);
        let q = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| dice.normal(2.0)));
        let pdr = reckon(0.03, 6.0, &Sensor { foot_from_sensor: q, ..Sensor::default() }, 5);
        let ends = [&pdr, &reference].map(|p| *p.walk("w").track(Default::default()).last().unwrap());
        assert_eq!(pdr.steps.len(), reference.steps.len());
        let apart = (ends[0].translation() - ends[1].translation()).norm();
        assert!(apart < 0.5, "held as {seed}: {apart} m of 40 m");
    }
}

#[test]
fn steps_that_a_dropout_hides_are_put_in() {
    let mut recording = hand_recording(60, 0.0, 6.0, &Sensor::default(), 6);
    let all = inertial::reckon("imu.csv", &recording, &Options::default()).unwrap();
    recording.samples.retain(|s| !(10.0..10.95).contains(&s.time_s));
    let bridged = inertial::reckon("imu.csv", &recording, &Options::default()).unwrap();
    assert_eq!(bridged.dropouts.len(), 1);
    assert_eq!(bridged.steps.len(), all.steps.len());
    let length = |p: &Pdr| p.steps.iter().map(|e| e.step.length_m()).sum::<f64>();
    assert!((length(&bridged) - length(&all)).abs() < 0.3);
}
