//! Two independent implementations of one objective: analytic in Rust, automatic in C++.

use hitl_slam::crosscheck;
use hitl_slam::joint::{self, Formulation, ceres};
use hitl_slam::map::Mode;
use hitl_slam::pipeline;
use hitl_slam::solver::{self, Problem};

use crate::support::both_backends::ceres_or_skip;
use crate::support::dice::Dice;
use crate::support::{problems, public_graph, room};

#[test]
fn residuals_jacobians_and_losses_agree_for_every_kind_of_term() {
    if !ceres_or_skip() {
        return;
    }
    for kind in problems::KINDS {
        let mut dice = Dice::new(100 + kind as u64);
        for _ in 0..200 {
            let problem = problems::of_kind(kind, 4, &mut dice);
            let found = crosscheck::compare_at(&problem).unwrap();
            assert!(found.residual.0 <= 1e-9, "{kind:?}: {:?}", found.residual);
            assert!(found.jacobian.0 <= 1e-7, "{kind:?}: {:?}", found.jacobian);
            let theirs = ceres::evaluate(&problem).unwrap();
            let x = problem.blocks();
            for (term, [rho, weight]) in theirs.losses.iter().enumerate() {
                let s = problem.residual(term, &x).norm_squared();
                let loss = problem.loss_of(term);
                assert!((loss.rho(s) - rho).abs() <= 1e-9 * rho.max(1.0), "{loss:?} at {s}");
                assert!((loss.weight(s) - weight).abs() <= 1e-9, "{loss:?} at {s}");
            }
            let cost = solver::cost(&problem, &x);
            assert!((theirs.cost - cost).abs() <= 1e-9 * cost.max(1.0));
        }
    }
}

#[test]
fn corrections_of_a_map_agree_in_the_smooth_form() {
    if !ceres_or_skip() {
        return;
    }
    for (seed, modes) in [
        (1, [Mode::Colocation, Mode::Collinear, Mode::Parallel, Mode::Collinear]),
        (2, [Mode::Parallel, Mode::Colocation, Mode::Collinear, Mode::Colocation]),
    ] {
        let found =
            crosscheck::run(room::map(seed), &room::corrections(modes), &pipeline::Options::default())
                .unwrap();
        assert!(found.agree, "{found:#?}");
        assert!(found.corrections.iter().all(|c| c.rejected.is_none()), "{found:#?}");
        assert!(found.total.rust_iterations > 0 && found.total.ceres_iterations > 0);
    }
}

#[test]
fn terms_agree_in_the_paper_form_on_a_map() {
    if !ceres_or_skip() {
        return;
    }
    let mut options = pipeline::Options::default();
    options.joint.formulation = Formulation::Paper;
    let modes = [Mode::Colocation, Mode::Collinear, Mode::Parallel, Mode::Colocation];
    let found = crosscheck::run(room::map(3), &room::corrections(modes), &options).unwrap();
    assert!(found.agree, "{found:#?}");
    assert!(found.corrections.iter().all(|c| c.rejected.is_none()), "{found:#?}");
}

#[test]
fn public_graphs_agree() {
    if !ceres_or_skip() {
        return;
    }
    let options = joint::Options::default();
    for name in ["CSAIL", "FR079", "intel943", "intel1728", "M3500", "kitti_00", "kitti_05", "city10000"] {
        let Some(map) = public_graph(name) else { return };
        let start = joint::build(&map, &map.poses, &[], &options);
        let (check, _) = crosscheck::both(name, start, &options).unwrap();
        println!("{name}: {:?}", check.totals);
        assert!(check.agree, "{name}: {:?}", check.totals);
    }
}
