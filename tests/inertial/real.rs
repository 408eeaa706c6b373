//! Real recordings, where they are.

use hitl_slam::inertial::{self, Mount, Options};
use hitl_slam::io::imu;

use crate::support::shared;

#[test]
fn a_measured_walk_has_a_step_for_every_stride_and_ends_where_it_was_measured() {
    // Strides, distance from the first to the last measured footfall.
    for (walk, strides, end_m) in
        [(32, 61, 1.225f64.hypot(0.031)), (42, 102, 3.837f64.hypot(3.32)), (44, 65, 12.859f64.hypot(3.886))]
    {
        let Some(path) = shared(&format!("foot_ktu/imu_csv/SensorConnectData_{walk}.csv.xz")) else { return };
        let pdr = inertial::reckon("walk", &imu::read(&path).unwrap().value, &Options::default()).unwrap();
        assert_eq!((pdr.mount, pdr.steps.len()), (Mount::Foot, strides), "walk {walk}");
        let end = pdr.walk("w").track(Default::default()).last().unwrap().translation();
        assert!((end.norm() - end_m).abs() < 1.0, "walk {walk}: {} m, measured {end_m}", end.norm());
    }
}

#[test]
fn a_walk_that_ends_where_it_began_does_so() {
    for (name, bound_m) in [("short_walk", 0.2), ("long_walk", 0.6)] {
        let Some(path) = shared(&format!("foot_xio/{name}.csv.xz")) else { return };
        let pdr = inertial::reckon("walk", &imu::read(&path).unwrap().value, &Options::default()).unwrap();
        let end = pdr.walk("w").track(Default::default()).last().unwrap().translation();
        assert!(end.norm() < bound_m, "{name}: {} m", end.norm());
    }
}

#[test]
fn a_phones_two_files_are_a_walk_in_a_hand() {
    let Some(folder) = shared("humolire/imus/1/square_2x") else { return };
    let pdr = inertial::reckon("walk", &imu::read(&folder).unwrap().value, &Options::default()).unwrap();
    assert_eq!(pdr.mount, Mount::Hand);
    let end = pdr.walk("w").track(Default::default()).last().unwrap().translation();
    assert!(end.norm() < 3.0, "{} m after two rounds of a square", end.norm());
}
