//! The paper's residuals to the letter, on both back ends.

use hitl_slam::joint::problem::{FitSighting, FitTerm, JointProblem, RelationTerm};
use hitl_slam::joint::{Backend, Formulation, Options};
use hitl_slam::map::Mode;
use hitl_slam::pipeline::{self, Corrector};
use hitl_slam::solver::{Loss, Problem};

use crate::support::room;

fn paper(backend: Backend) -> pipeline::Options {
    let joint = Options { formulation: Formulation::Paper, backend, ..Options::default() };
    pipeline::Options { joint, ..Default::default() }
}

/// One pose at the origin that sees three points, one of them beyond an end of the segment from (0, 0) to (2, 0).
fn three_points() -> JointProblem {
    let points = vec![[0.5, 0.3], [1.5, -0.4], [2.6, 0.8]];
    JointProblem {
        poses: vec![[0.0; 3]],
        held: vec![0],
        ends: vec![[[0.0, 0.0], [2.0, 0.0]], [[0.0, 1.0], [2.0, 1.5]]],
        fits: vec![FitTerm { segment: 0, sightings: vec![FitSighting { pose: 0, points }], scale: 20.0 }],
        ..Default::default()
    }
}

#[test]
fn the_fit_is_the_root_of_the_mean_squared_distance_to_the_segment_ends_included() {
    let problem = three_points();
    let mean = (0.3f64.powi(2) + 0.4f64.powi(2) + 0.6f64.powi(2) + 0.8f64.powi(2)) / 3.0;
    let r = problem.residual(0, &problem.blocks())[0];
    assert!((r - 20.0 * mean.sqrt()).abs() < 1e-7, "{r}");
}

#[test]
fn the_relation_adds_offset_and_angle_as_the_paper_does() {
    let mut problem = three_points();
    problem.fits.clear();
    // c_b − c_a = (0, 1.25), n̂_a = (0, 1), cos Δφ = 2/√4.25.
    let cosine = 2.0 / 4.25f64.sqrt();
    let (k1, k2) = (50.0, 100.0);
    for (mode, expected) in [
        (Mode::Colocation, k1 * 1.25 + k2 * (1.0 - cosine)),
        (Mode::Collinear, k1 * 1.25 + k2 * (1.0 - cosine)),
        (Mode::Parallel, k2 * (1.0 - cosine)),
        (Mode::Perpendicular, k2 * cosine),
    ] {
        problem.paper_relations =
            vec![RelationTerm { mode, a: 0, b: 1, offset_scale: k1, angle_scale: k2, loss: Loss::None }];
        let r = problem.residual(0, &problem.blocks())[0];
        assert!((r - expected).abs() < 1e-6, "{mode:?}: {r}, expected {expected}");
    }
}

both_backends! {
    fn corrections_lower_the_cost_and_keep_segments_alive(backend: Backend) {
        let options = paper(backend);
        let mut corrector = Corrector::new(room::map(5), options).unwrap();
        let before: Vec<_> = corrector.map().poses.clone();
        let modes = [Mode::Collinear, Mode::Colocation, Mode::Parallel, Mode::Collinear];
        for correction in room::corrections(modes) {
            let report = corrector.apply(&correction).unwrap();
            assert!(report.accepted(), "{:?}", report.rejection);
            let solve = report.solve.unwrap();
            assert!(solve.final_cost <= solve.initial_cost);
        }
        let map = corrector.map();
        map.validate("result").unwrap();
        assert_ne!(map.poses, before);
        let lengths: Vec<f64> = map.human_factors.iter().map(|f| f.a.segment.half_length_m).collect();
        assert!(lengths.iter().all(|l| *l > 0.0), "{lengths:?}");
    }

    fn free_ends_take_over_the_segment_s_length(backend: Backend) {
        let options = paper(backend);
        let mut corrector = Corrector::new(room::map(6), options).unwrap();
        let drawn = 1.0;
        corrector.apply(&room::corrections([Mode::Colocation; 4])[1]).unwrap();
        let factor = &corrector.map().human_factors[0];
        let lengths = [factor.a.segment.half_length_m, factor.b.segment.half_length_m];
        assert!(lengths.iter().any(|l| (l - drawn).abs() > 1e-6), "{lengths:?}");
    }

    fn a_held_pose_among_the_sightings_is_no_trouble(backend: Backend) {
        let mut problem = three_points();
        problem.poses.push([0.1, 0.05, 0.02]);
        let points = vec![[0.4, 1.1], [1.5, 1.3]];
        let sightings = vec![
            FitSighting { pose: 0, points: points.clone() },
            FitSighting { pose: 1, points },
        ];
        problem.fits.push(FitTerm { segment: 1, sightings, scale: 20.0 });
        problem.paper_relations.push(RelationTerm {
            mode: Mode::Parallel, a: 0, b: 1, offset_scale: 50.0, angle_scale: 100.0, loss: Loss::Huber(2.0),
        });
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert!(report.final_cost < report.initial_cost);
        assert_eq!(problem.poses[0], [0.0; 3]);
        assert!(problem.blocks().iter().flatten().all(|v| v.is_finite()));
    }
}
