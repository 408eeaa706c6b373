//! Minima, on both back ends.

use hitl_slam::crosscheck;
use hitl_slam::geometry::{Pose2, angle_diff};
use hitl_slam::joint::problem::JointProblem;
use hitl_slam::joint::{Backend, Formulation, Options, ceres};
use hitl_slam::map::Mode;
use hitl_slam::solver::{self, Loss};

use crate::support::both_backends::ceres_or_skip;
use crate::support::dice::Dice;
use crate::support::problems;

fn distance(a: &JointProblem, b: &JointProblem) -> f64 {
    let gap = |(p, q): (&[f64; 3], &[f64; 3])| {
        (p[0] - q[0]).abs().max((p[1] - q[1]).abs()).max(angle_diff(p[2], q[2]).abs())
    };
    a.poses.iter().zip(&b.poses).map(gap).fold(0.0, f64::max)
}

#[test]
fn both_reach_the_same_minimum_of_random_graphs_with_human_factors() {
    if !ceres_or_skip() {
        return;
    }
    let options = Options::default();
    for seed in 0..60 {
        let loss =
            [Loss::None, Loss::Huber(1.5), Loss::Cauchy(2.0), Loss::GemanMcClure(4.0)][seed as usize % 4];
        let (check, _) = crosscheck::both("random", problems::solvable(seed, loss, true), &options).unwrap();
        assert!(check.totals.agree(Formulation::Smooth), "seed {seed}: {check:#?}");
        assert!(check.rust.unwrap().termination.converged());
        assert!(check.ceres.unwrap().termination.converged());
    }
}

#[test]
fn every_strategy_and_linear_solver_of_ceres_reaches_the_same_minimum() {
    if !ceres_or_skip() {
        return;
    }
    use ceres::{LinearSolver, TrustRegion};
    let start = problems::solvable(5, Loss::None, true);
    let mut reference = start.clone();
    Backend::Rust.solve(&mut reference, &Options::default()).unwrap();
    for trust_region in [TrustRegion::LevenbergMarquardt, TrustRegion::Dogleg, TrustRegion::SubspaceDogleg] {
        for linear_solver in [
            LinearSolver::SparseNormalCholesky,
            LinearSolver::SparseNormalCholeskyEigen,
            LinearSolver::DenseNormalCholesky,
            LinearSolver::DenseQr,
        ] {
            let chosen = ceres::Options { trust_region, linear_solver };
            let options = Options { ceres: chosen, ..Options::default() };
            let mut problem = start.clone();
            let report = Backend::Ceres.solve(&mut problem, &options).unwrap();
            assert!(report.termination.converged(), "{trust_region:?} {linear_solver:?}: {report:?}");
            assert!(distance(&problem, &reference) < 1e-6, "{trust_region:?} {linear_solver:?}");
        }
    }
}

both_backends! {
    fn a_minimum_stays_where_it_is(backend: Backend) {
        let mut problem = problems::solvable(7, Loss::Huber(2.0), true);
        let options = Options::default();
        backend.solve(&mut problem, &options).unwrap();
        let minimum = problem.clone();
        let report = backend.solve(&mut problem, &options).unwrap();
        assert!(report.termination.converged());
        assert!(distance(&problem, &minimum) < 1e-7);
    }

    fn the_moment_form_has_the_minimum_of_the_point_form(backend: Backend) {
        for seed in 0..10 {
            let mut moments = problems::solvable(seed, Loss::None, true);
            let mut points = problems::solvable(seed, Loss::None, false);
            let start = [&moments, &points].map(|p| solver::cost(p, &p.blocks()));
            assert!((start[0] - start[1]).abs() <= 1e-11 * start[0], "{start:?}");
            let by_moments = backend.solve(&mut moments, &Options::default()).unwrap();
            let by_points = backend.solve(&mut points, &Options::default()).unwrap();
            assert!(distance(&moments, &points) < 1e-6);
            assert!((by_moments.final_cost - by_points.final_cost).abs() <= 1e-8 * by_points.final_cost);
        }
    }

    fn held_poses_stay_to_the_bit(backend: Backend) {
        let mut problem = problems::solvable(3, Loss::None, true);
        problem.held = vec![0, 4, 5, 9];
        let before = problem.clone();
        backend.solve(&mut problem, &Options::default()).unwrap();
        for &held in &before.held {
            assert_eq!(problem.poses[held], before.poses[held]);
        }
        assert_ne!(problem.poses[6], before.poses[6]);
    }

    fn segments_are_fitted_to_a_map_that_is_held_whole(backend: Backend) {
        let mut problem = problems::solvable(41, Loss::None, true);
        problem.held = (0..problem.poses.len()).collect();
        let before = problem.clone();
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert!(report.termination.converged() && report.final_cost < report.initial_cost);
        assert_eq!(problem.poses, before.poses);
        // The relative factors cannot move, but count.
        let cost = solver::cost(&problem, &problem.blocks());
        assert!((report.final_cost - cost).abs() <= 1e-12 * cost);
        // A segment that nobody saw and nobody relates: nothing to move it.
        problem.sightings.clear();
        problem.ties.clear();
        problem.relations.clear();
        let before = problem.clone();
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert!(report.termination.converged(), "{report:?}");
        assert_eq!(problem, before);
    }

    fn nothing_to_optimise_is_said(backend: Backend) {
        let mut problem = problems::solvable(3, Loss::None, true);
        problem.held = (0..problem.poses.len()).collect();
        problem.segments.clear();
        problem.sightings.clear();
        problem.ties.clear();
        problem.relations.clear();
        let before = problem.clone();
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert_eq!(report.termination, solver::Termination::NothingToOptimize);
        assert_eq!(problem, before);
    }

    fn the_limit_of_iterations_is_kept_and_is_not_called_convergence(backend: Backend) {
        let mut problem = problems::solvable(11, Loss::None, true);
        let mut options = Options::default();
        options.solver.max_iterations = 1;
        let report = backend.solve(&mut problem, &options).unwrap();
        assert_eq!(report.accepted_steps(), 1);
        assert_eq!(report.termination, solver::Termination::MaxIterations);
        assert!(report.final_cost < report.initial_cost);
    }

    fn the_report_s_costs_are_those_of_the_problem(backend: Backend) {
        let mut problem = problems::solvable(13, Loss::Cauchy(1.0), true);
        let before = solver::cost(&problem, &problem.blocks());
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        let after = solver::cost(&problem, &problem.blocks());
        assert!((report.initial_cost - before).abs() <= 1e-12 * before);
        assert!((report.final_cost - after).abs() <= 1e-12 * after);
        assert_eq!(report.iterations.last().unwrap().cost, report.final_cost);
        assert!(report.timings.total_ms >= report.timings.iterate_ms);
    }

    fn a_cost_that_is_not_finite_is_said_and_nothing_moves(backend: Backend) {
        let mut problem = problems::solvable(17, Loss::None, true);
        problem.poses[5][0] = 1e200;
        let before = problem.clone();
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert_eq!(report.termination, solver::Termination::NotFinite);
        assert_eq!(problem, before);
    }

    /// Two runs of a robot that only angles connect: where the second lies is nobody's business.
    fn what_nothing_determines_stays_near_its_start(backend: Backend) {
        let mut problem = problems::solvable(29, Loss::None, true);
        let n = problem.poses.len();
        problem.relatives.retain(|t| (t.i < n / 2) == (t.j < n / 2));
        for relation in problem.relations.iter_mut().filter(|r| r.mode != Mode::Perpendicular) {
            relation.mode = Mode::Parallel;
        }
        let start = problem.clone();
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert!(report.termination.converged(), "{report:?}");
        assert!(distance(&problem, &start) < 1.0, "{}", distance(&problem, &start));
    }

    fn a_graph_without_contradiction_stays(backend: Backend) {
        let mut problem = problems::solvable(31, Loss::None, true);
        problem.relatives.truncate(problem.poses.len() - 1);
        problem.segments.clear();
        problem.sightings.clear();
        problem.ties.clear();
        problem.relations.clear();
        for t in &mut problem.relatives {
            let [i, j] = [t.i, t.j].map(|k| Pose2::from_array(problem.poses[k]));
            t.measured = i.between(j).to_array();
        }
        let before = problem.clone();
        let report = backend.solve(&mut problem, &Options::default()).unwrap();
        assert!(report.termination.converged(), "{report:?}");
        assert!(distance(&problem, &before) < 1e-9);
    }

    fn results_are_the_same_every_time(backend: Backend) {
        let solve = || {
            let mut problem = problems::solvable(19, Loss::Huber(1.0), true);
            backend.solve(&mut problem, &Options::default()).unwrap();
            problem
        };
        assert_eq!(solve(), solve());
    }
}

#[test]
fn solves_on_many_threads_do_not_disturb_each_other() {
    if !ceres_or_skip() {
        return;
    }
    let solve = |seed| {
        let mut problem = problems::solvable(seed, Loss::Huber(1.0), true);
        let report = Backend::Ceres.solve(&mut problem, &Options::default()).unwrap();
        (problem, report.warnings)
    };
    let alone: Vec<_> = (0..8).map(solve).collect();
    let solve = &solve;
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|seed| scope.spawn(move || solve(seed))).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    assert_eq!(alone, together);
}

#[test]
fn moments_and_points_are_the_same_sum_anywhere() {
    let mut dice = Dice::new(23);
    for seed in 0..50 {
        let moments = problems::solvable(seed, Loss::None, true);
        let points = problems::solvable(seed, Loss::None, false);
        let mut x = moments.blocks();
        for number in x.iter_mut().flatten() {
            *number += dice.normal(0.3);
        }
        let costs = [&moments, &points].map(|p| solver::cost(p, &x));
        assert!((costs[0] - costs[1]).abs() <= 1e-11 * costs[0], "{costs:?}");
    }
}
