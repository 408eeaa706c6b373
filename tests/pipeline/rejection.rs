//! What cannot be applied is rejected with its reason; what makes no sense is an error.

use hitl_slam::geometry::Vec2;
use hitl_slam::interpret;
use hitl_slam::map::{Correction, Mode, Observations, Stroke};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::Scenario;

use super::{corrected, simulated};

#[test]
fn an_ambiguous_correction_is_rejected_and_leaves_the_map_as_it_was() {
    let s = simulated(Scenario::Loop, 21, 0.0);
    // The scenario's parallel walls called perpendicular, and the other way round.
    for c in &s.corrections {
        let mode = match c.mode {
            Mode::Parallel => Mode::Perpendicular,
            Mode::Perpendicular => Mode::Parallel,
            _ => continue,
        };
        let wrong = Correction { mode, ..c.clone() };
        let (straight, _) = corrected(&s.map, &s.corrections[..1]);
        let (map, reports) = corrected(&straight, &[wrong]);
        assert!(
            reports[0].rejection.as_ref().expect("rejected").starts_with("ambiguous"),
            "{:?}",
            reports[0].rejection
        );
        assert_eq!(map, straight);
    }
}

#[test]
fn a_disabled_correction_is_listed_and_skipped() {
    let s = simulated(Scenario::Loop, 22, 0.02);
    let off = Correction { enabled: false, ..s.corrections[0].clone() };
    let (map, reports) = corrected(&s.map, &[off]);
    assert_eq!(reports[0].rejection.as_deref(), Some("disabled"));
    assert_eq!(map, s.map);
}

#[test]
fn a_preview_says_what_would_be_caught_and_changes_nothing() {
    let s = simulated(Scenario::Loop, 23, 0.02);
    let corrector = Corrector::new(s.map.clone(), Options::default()).expect("a map");
    let preview = corrector.preview(&s.corrections[0]).expect("strokes on the map");
    assert!(preview.accepted() && preview.solve.is_none());
    let (_, reports) = corrected(&s.map, &s.corrections[..1]);
    assert_eq!(preview.observations, reports[0].observations);
    assert_eq!(preview.offset_m[0], reports[0].offset_m[0]);
    assert_eq!(corrector.map(), &s.map);
}

#[test]
fn poses_and_stamps_out_of_range_are_errors_that_name_the_correction() {
    let s = simulated(Scenario::Loop, 24, 0.0);
    let points = [Vec2::new(0.0, 0.0), Vec2::new(1.0, 0.0)];
    let check = |a: Stroke| {
        let c = Correction { a, ..s.corrections[0].clone() };
        interpret::check(&s.map, &[c]).expect_err("out of range").to_string()
    };
    let id = &s.corrections[0].id;
    assert_eq!(
        check(Stroke::Pose { pose: 650, points }),
        format!("correction {id}: a: found pose 650, expected one below 650")
    );
    let message = check(Stroke::Stamp { stamp_s: 1e9, points });
    assert!(
        message.starts_with(&format!("correction {id}: a: found stamp 1000000000, expected")),
        "{message}"
    );
}

#[test]
fn a_stamp_between_two_scans_is_interpolated_along_the_chain() {
    let s = simulated(Scenario::Loop, 25, 0.0);
    let stamps = s.map.stamps_s.clone().expect("stamps");
    let points = [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
    let half_way = Stroke::Stamp { stamp_s: (stamps[7] + stamps[8]) / 2.0, points };
    let ends = interpret::in_world(&s.map, &s.map.poses, &half_way).expect("inside the log");
    let expected = s.map.poses[7].interpolate(s.map.poses[8], 0.5);
    for (end, p) in ends.iter().zip(points) {
        assert!((end - expected.transform_point(p)).norm() < 1e-12);
    }
}

#[test]
fn a_map_without_points_and_options_out_of_range_are_errors() {
    let s = simulated(Scenario::Loop, 26, 0.0);
    let mut empty = s.map.clone();
    empty.observations = Observations::empty(empty.poses.len());
    assert!(
        Corrector::new(empty, Options::default())
            .expect_err("no points")
            .to_string()
            .contains("points: found none")
    );
    let mut options = Options::default();
    options.joint.offset_sigma_m = -1.0;
    assert!(
        Corrector::new(s.map, options).expect_err("σ < 0").to_string().contains("offset sigma: found -1")
    );
}
