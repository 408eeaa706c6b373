//! Errors against hand-computed values and naive twins.

use std::f64::consts::PI;

use crate::building;
use hitl_slam::geometry::{Information, Pose2, Vec2};
use hitl_slam::map::{Observations, Relation, RelativeFactor, SlamMap, Trajectory};
use hitl_slam::metrics::{
    DEFAULT_TOLERANCE_S, Reference, align, associate, ate, evaluate, relation_errors, rpe, worst_edge,
};

fn trajectory(stamps_s: &[f64], poses: &[[f64; 3]]) -> Trajectory {
    Trajectory { stamps_s: stamps_s.to_vec(), poses: poses.iter().map(|&p| Pose2::from_array(p)).collect() }
}

/// A bent trajectory and its truth.
fn bent_and_true() -> (Trajectory, Trajectory) {
    let truth = building::true_map(200, 2);
    (building::drifted(&truth, 0.001).trajectory(), truth.trajectory())
}

fn moved(trajectory: &Trajectory, motion: Pose2) -> Trajectory {
    Trajectory { poses: trajectory.poses.iter().map(|&p| motion.compose(p)).collect(), ..trajectory.clone() }
}

#[test]
fn alignment_recovers_a_rigid_motion_also_by_half_a_turn() {
    let points = [Vec2::new(0.0, 0.0), Vec2::new(3.0, 1.0), Vec2::new(-2.0, 5.0), Vec2::new(1.0, 1.0)];
    for theta in [0.0, 0.3, PI / 2.0, PI, -PI + 1e-9, -2.0] {
        let motion = Pose2::new(10.0, -20.0, theta);
        let pairs: Vec<_> = points.iter().map(|&p| (p, motion.transform_point(p))).collect();
        let error = align(&pairs).between(motion);
        assert!(error.translation().norm() < 1e-12 && error.theta_rad.abs() < 1e-12, "{theta}: {error:?}");
    }
}

#[test]
fn alignment_is_the_best_among_many_tried() {
    let (bent, truth) = bent_and_true();
    let pairs: Vec<_> =
        bent.poses.iter().zip(&truth.poses).map(|(a, b)| (a.translation(), b.translation())).collect();
    let cost = |t: Pose2| pairs.iter().map(|&(p, q)| (t.transform_point(p) - q).norm_squared()).sum::<f64>();
    let best = align(&pairs);
    for [x, y, theta] in [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-4], [1e-3, -1e-3, 1e-4]] {
        for sign in [1.0, -1.0] {
            let other = Pose2::new(best.x_m + sign * x, best.y_m + sign * y, best.theta_rad + sign * theta);
            assert!(cost(other) > cost(best));
        }
    }
}

#[test]
fn alignment_of_a_single_place_does_not_turn() {
    let (far, there) = (Vec2::new(1e6 + 0.1, 3.0), Vec2::new(-7.0, 1e5));
    for count in [1, 2, 7] {
        let motion = align(&vec![(far, there); count]);
        assert_eq!(motion.theta_rad, 0.0);
        assert!((motion.transform_point(far) - there).norm() < 1e-9);
    }
    assert_eq!(align(&[]), Pose2::IDENTITY);
}

#[test]
fn ate_does_not_depend_on_the_frame_of_either() {
    let (bent, truth) = bent_and_true();
    let pairs = associate(&bent, &truth, DEFAULT_TOLERANCE_S);
    let plain = ate(&bent, &truth, &pairs).unwrap();
    assert!(plain.rmse_m > 0.1);
    for theta in [0.5, PI / 2.0, PI, -3.0] {
        let motion = Pose2::new(5.0, -8.0, theta);
        for (a, b) in [(moved(&bent, motion), truth.clone()), (bent.clone(), moved(&truth, motion))] {
            let turned = ate(&a, &b, &pairs).unwrap();
            assert!((turned.rmse_m - plain.rmse_m).abs() < 1e-9);
            assert!((turned.max_m - plain.max_m).abs() < 1e-9);
            assert!((turned.heading_rmse_rad - plain.heading_rmse_rad).abs() < 1e-9);
        }
    }
}

#[test]
fn ate_by_hand() {
    // Two poses 2 m apart against two 4 m apart: aligned at the middle, each is 1 m off; headings 0.1 rad off.
    let estimate = trajectory(&[0.0, 1.0], &[[0.0, 0.0, 0.1], [2.0, 0.0, -0.1]]);
    let truth = trajectory(&[0.0, 1.0], &[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    let error = ate(&estimate, &truth, &[(0, 0), (1, 1)]).unwrap();
    for (found, expected) in [(error.rmse_m, 1.0), (error.max_m, 1.0), (error.heading_rmse_rad, 0.1)] {
        assert!((found - expected).abs() < 1e-12);
    }
    assert_eq!(error.errors.len(), 2);
    assert!(ate(&estimate, &truth, &[]).is_none());
}

#[test]
fn headings_either_side_of_pi_are_close() {
    let estimate =
        trajectory(&[0.0, 1.0, 2.0], &[[0.0, 0.0, PI - 0.01], [-1.0, 0.0, -PI + 0.01], [-2.0, 0.0, PI]]);
    let truth =
        trajectory(&[0.0, 1.0, 2.0], &[[0.0, 0.0, -PI + 0.01], [-1.0, 0.0, PI - 0.01], [-2.0, 0.0, PI]]);
    let pairs = [(0, 0), (1, 1), (2, 2)];
    let absolute = ate(&estimate, &truth, &pairs).unwrap();
    assert!((absolute.heading_rmse_rad - 0.02 * (2.0f64 / 3.0).sqrt()).abs() < 1e-12);
    let relative = rpe(&estimate, &truth, &pairs).unwrap();
    assert!((relative.rotation_max_rad - 0.04).abs() < 1e-12);
}

#[test]
fn rpe_by_hand() {
    let estimate = trajectory(&[0.0, 1.0, 2.0], &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.3]]);
    let truth =
        trajectory(&[0.0, 1.0, 2.0], &[[9.0, 9.0, PI / 2.0], [9.0, 10.5, PI / 2.0], [9.0, 11.5, PI / 2.0]]);
    let error = rpe(&estimate, &truth, &[(0, 0), (1, 1), (2, 2)]).unwrap();
    assert!((error.translation_rmse_m - (0.25f64 / 2.0).sqrt()).abs() < 1e-12);
    assert!((error.translation_max_m - 0.5).abs() < 1e-12);
    assert!((error.rotation_rmse_rad - (0.09f64 / 2.0).sqrt()).abs() < 1e-12);
    assert!((error.rotation_max_rad - 0.3).abs() < 1e-12);
    assert!(rpe(&estimate, &truth, &[(0, 0)]).is_none());
}

#[test]
fn association_takes_the_nearest_once_and_equal_stamps_in_order() {
    let at = |stamps: &[f64]| trajectory(stamps, &vec![[0.0; 3]; stamps.len()]);
    let pairs = |a: &[f64], b: &[f64]| associate(&at(a), &at(b), 0.02);
    assert_eq!(pairs(&[0.1, 0.2, 0.3], &[0.105, 0.29, 5.5]), [(0, 0), (2, 1)]);
    assert_eq!(pairs(&[0.0, 0.015], &[0.01]), [(1, 0)], "the nearer of two");
    assert_eq!(pairs(&[0.5, 0.5, 1.5], &[0.5, 0.5, 1.5]), [(0, 0), (1, 1), (2, 2)], "duplicates in order");
    assert_eq!(pairs(&[0.5, 0.5, 0.5], &[0.5]), [(0, 0)], "each at most once");
    assert_eq!(pairs(&[2.5, 0.5, 1.5], &[0.5, 1.5, 2.5]), [(1, 0), (2, 1), (0, 2)], "stamps that run back");
    assert_eq!(associate(&at(&[0.0, 1.0]), &at(&[1.0, 2.0]), 1.5), [(1, 0)], "indices must be equal");
    assert!(pairs(&[], &[1.0]).is_empty());
    assert!(pairs(&[f64::NAN], &[1.0]).is_empty());
}

#[test]
fn the_worst_edge_is_found_in_metres_and_in_sigmas() {
    let factor = |i, x_m, sigma_m| RelativeFactor {
        i,
        j: i + 1,
        i_from_j: Pose2::new(x_m, 0.0, 0.0),
        information: Information::from_sigmas(sigma_m, sigma_m, 0.1),
    };
    let mut map = SlamMap {
        poses: (0..4).map(|i| Pose2::new(0.0, f64::from(i), PI / 2.0)).collect(),
        relative_factors: vec![factor(0, 1.0, 0.1), factor(1, 0.5, 1.0), factor(2, 0.8, 0.1)],
        observations: Observations::empty(4),
        ..SlamMap::default()
    };
    let worst = worst_edge(&map).unwrap();
    assert_eq!((worst.translation_factor, worst.sigma_factor), (1, 2));
    assert!((worst.translation_m - 0.5).abs() < 1e-12 && (worst.sigma - 2.0).abs() < 1e-9);
    map.relative_factors.clear();
    assert!(worst_edge(&map).is_none());
}

#[test]
fn relation_errors_by_hand() {
    let track = trajectory(
        &[0.0, 5.5, 25.0, 225.0],
        &[[0.0, 0.0, PI], [-1.0, 0.0, PI], [-1.0, 2.0, -PI + 0.1], [3.0, 3.0, 0.0]],
    );
    let relation = |stamp_1_s, stamp_2_s, pose: [f64; 3]| Relation {
        stamp_1_s,
        stamp_2_s,
        first_from_second: Pose2::from_array(pose),
    };
    let relations = [
        relation(0.0, 5.51, [1.3, 0.0, 0.0]),          // 0.3 m off, in 0–10 s
        relation(25.0, 5.5, [0.0, 0.0, 0.0]),          // 2 m and 0.1 rad off, backwards, in 10–30 s
        relation(0.0, 225.0, [-3.0, -3.0, PI - 1e-6]), // right but for 1e-6 rad, beyond 120 s
        relation(0.0, 99.0, [0.0, 0.0, 0.0]),          // no pose at 99 s
    ];
    let errors = relation_errors(&track, &relations, DEFAULT_TOLERANCE_S);
    assert_eq!((errors.count, errors.unmatched), (3, 1));
    for (e, relation) in errors.errors.iter().zip(&relations) {
        let stamps_s = e.poses.map(|k| track.stamps_s[k]);
        assert!((stamps_s[0] - relation.stamp_1_s).abs() <= DEFAULT_TOLERANCE_S, "{e:?}");
        assert!((stamps_s[1] - relation.stamp_2_s).abs() <= DEFAULT_TOLERANCE_S, "{e:?}");
    }
    let close =
        |found: Option<f64>, expected: f64| assert!((found.unwrap() - expected).abs() < 1e-5, "{found:?}");
    close(errors.translation_mean_m, 2.3 / 3.0);
    close(errors.translation_median_m, 0.3);
    close(errors.translation_worst_m, 2.0);
    let mean = 2.3 / 3.0f64;
    close(
        errors.translation_std_m,
        (((0.3 - mean).powi(2) + (2.0 - mean).powi(2) + mean * mean) / 3.0).sqrt(),
    );
    close(errors.rotation_mean_deg, (0.1f64 + 1e-6).to_degrees() / 3.0);
    let counts: Vec<usize> = errors.by_span.iter().map(|s| s.count).collect();
    assert_eq!(counts, [1, 1, 0, 1]);
    close(errors.by_span[1].rotation_mean_deg, 0.1f64.to_degrees());
    assert_eq!((errors.by_span[3].from_s, errors.by_span[3].to_s), (120.0, None));
    assert_eq!(errors.by_span[2].translation_mean_m, None);
}

#[test]
fn the_report_has_the_names_of_the_contract_and_only_what_was_asked_for() {
    let truth = building::true_map(50, 4);
    let bent = building::drifted(&truth, 0.002);
    let nothing = Reference { truth: None, relations: None, walls: None, tolerance_s: DEFAULT_TOLERANCE_S };
    let names = |reference: &Reference| {
        let value = serde_json::to_value(evaluate(&bent, reference).unwrap()).unwrap();
        value.as_object().unwrap().keys().cloned().collect::<Vec<_>>()
    };
    assert_eq!(names(&nothing), ["poses", "worst_edge_factor", "worst_edge_m", "worst_edge_sigma"]);
    let track = truth.trajectory();
    let relation = Relation { stamp_1_s: 0.0, stamp_2_s: 1.0, first_from_second: Pose2::IDENTITY };
    let all = Reference { truth: Some(&track), relations: Some(&[relation]), ..nothing };
    let found = names(&all);
    for name in [
        "ate_rmse_m",
        "ate_max_m",
        "heading_rmse_rad",
        "rpe_trans_rmse_m",
        "rpe_rot_rmse_rad",
        "worst_edge_m",
        "relations",
    ] {
        assert!(found.iter().any(|f| f == name), "{name} in {found:?}");
    }
    assert!(!found.iter().any(|f| f == "errors"));
}

#[test]
fn a_truth_without_a_common_stamp_is_bad_input() {
    let map = building::true_map(10, 4);
    let other = trajectory(&[1000.3], &[[0.0; 3]]);
    let reference =
        Reference { truth: Some(&other), relations: None, walls: None, tolerance_s: DEFAULT_TOLERANCE_S };
    let message = evaluate(&map, &reference).unwrap_err().to_string();
    assert_eq!(
        message,
        "truth: found stamps 1000.3..1000.3, expected some within 0.02 s of the map's (stamps 0..4.5)"
    );
}
