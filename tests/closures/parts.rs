//! The parts against naive twins.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::joint;
use hitl_slam::scan_match::{Search, Surfel, SurfelMap, Window};
use hitl_slam::solver::{Covariance, Loss, Problem};
use nalgebra::{DMatrix, Matrix3};

use crate::support::{Dice, problems};

/// JᵀJ of all terms, dense, inverted.
fn dense_inverse(problem: &joint::problem::JointProblem) -> DMatrix<f64> {
    let x = problem.blocks();
    let n = 3 * x.len();
    let mut h = DMatrix::zeros(n, n);
    for term in 0..problem.terms() {
        let mut at = hitl_slam::solver::Linearization::default();
        problem.linearize(term, &x, &mut at);
        let w = problem.loss_of(term).weight(at.residual.norm_squared());
        for (a, ja) in &at.jacobians {
            for (b, jb) in &at.jacobians {
                let mut block = h.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                block += ja.transpose() * jb * w;
            }
        }
    }
    for &held in &problem.held {
        for k in 3 * held..3 * held + 3 {
            h.row_mut(k).fill(0.0);
            h.column_mut(k).fill(0.0);
            h[(k, k)] = 1.0;
        }
    }
    let mut inverse = h.try_inverse().expect("everything is determined");
    for &held in &problem.held {
        for k in 3 * held..3 * held + 3 {
            inverse[(k, k)] = 0.0;
        }
    }
    inverse
}

#[test]
fn covariances_are_those_of_the_dense_inverse() {
    for seed in 0..5 {
        let problem = problems::solvable(seed, Loss::Cauchy(2.0), true);
        let dense = dense_inverse(&problem);
        let sparse = Covariance::new(&problem, &problem.blocks(), &problem.held);
        let sparse = sparse.expect("a pattern").expect("determined");
        let all: Vec<usize> = (0..problem.blocks().len()).collect();
        for &block in &all {
            for (&other, found) in all.iter().zip(sparse.with(block, &all)) {
                let expected: Matrix3<f64> = dense.fixed_view::<3, 3>(3 * other, 3 * block).into();
                let off = (found - expected).amax();
                assert!(off < 1e-9 * dense.amax(), "blocks {other}, {block}: {off}");
            }
        }
    }
}

/// The same search place by place, point by point.
fn naive(map: &SurfelMap, points: &[Vec2], start: Pose2, window: Window) -> (Pose2, f64, f64) {
    const CELL_M: f64 = 0.1;
    // Nearness of a cell: of the surfel whose cell is nearest, at most 3 cells away in either direction.
    let mut low = Vec2::repeat(f64::INFINITY);
    for s in map.surfels() {
        low = low.inf(&s.mean);
    }
    let corner = low.add_scalar(-0.4);
    let cell = |p: Vec2| ((p - corner) / CELL_M).map(f64::floor);
    let cells: Vec<Vec2> = map.surfels().iter().map(|s| cell(s.mean)).collect();
    let nearness = |at: Vec2| {
        let reach = cells.iter().map(|c| c - at).filter(|d| d.amax() <= 3.0);
        let near = reach.map(|d| (-0.5 * d.norm_squared() * CELL_M * CELL_M / (0.15 * 0.15)).exp() as f32);
        f64::from(near.fold(0.0, f32::max))
    };
    let steps = (window.position_m / window.position_step_m).ceil() as i32;
    let turns = (window.heading_rad / window.heading_step_rad).ceil() as i32;
    let mut tried = Vec::new();
    for turn in -turns..=turns {
        let heading = start.theta_rad + f64::from(turn) * window.heading_step_rad;
        let turned = Pose2::new(start.x_m, start.y_m, heading);
        let at: Vec<Vec2> = points.iter().map(|p| cell(turned.transform_point(*p))).collect();
        for row in -steps..=steps {
            for column in -steps..=steps {
                let (x, y) = (f64::from(column), f64::from(row));
                let shift = Vec2::new(x, y) * window.position_step_m;
                let score =
                    at.iter().map(|p| nearness(p + shift / CELL_M)).sum::<f64>() / points.len() as f64;
                let far = x.hypot(y) / f64::from(steps) + f64::from(turn.abs()) / f64::from(turns);
                let pose = Pose2::new(start.x_m + shift.x, start.y_m + shift.y, heading);
                tried.push((pose, score, score - 0.02 * far));
            }
        }
    }
    let best = tried.iter().copied().reduce(|a, b| if b.2 > a.2 { b } else { a }).expect("some");
    let is_elsewhere = |p: &Pose2| (p.translation() - best.0.translation()).norm() > 0.5;
    let second = tried.iter().filter(|t| is_elsewhere(&t.0)).map(|t| t.1).fold(0.0, f64::max);
    (best.0, best.2, second / best.2)
}

#[test]
fn the_search_finds_what_a_search_place_by_place_finds() {
    let mut dice = Dice::new(7);
    for _ in 0..10 {
        // Two walls and some clutter.
        let mut surfels = Vec::new();
        for _ in 0..60 {
            surfels
                .push(Surfel { mean: Vec2::new(dice.uniform(-4.0, 4.0), 2.0), normal: Vec2::new(0.0, -1.0) });
            surfels
                .push(Surfel { mean: Vec2::new(3.0, dice.uniform(-3.0, 2.0)), normal: Vec2::new(-1.0, 0.0) });
            let mean = Vec2::from(dice.point(4.0));
            surfels.push(Surfel { mean, normal: Vec2::new(0.0, 1.0) });
        }
        let points: Vec<Vec2> = surfels.iter().step_by(2).map(|s| s.mean).collect();
        let map = SurfelMap::new(surfels);
        let start = Pose2::new(dice.uniform(-1.0, 1.0), dice.uniform(-1.0, 1.0), dice.uniform(-0.2, 0.2));
        let window =
            Window { position_m: 1.2, heading_rad: 0.2, position_step_m: 0.2, heading_step_rad: 0.05 };
        let found = Search::new(&map).best(&points, start, window);
        let (pose, score, ambiguity) = naive(&map, &points, start, window);
        assert!((found.pose.translation() - pose.translation()).norm() < 1e-9, "{found:?} {pose:?}");
        assert!((found.score - score).abs() < 1e-4 && (found.ambiguity - ambiguity.min(1.0)).abs() < 1e-3);
    }
}
