//! Covariances against the dense inverse.

use hitl_slam::joint::{self, Backend, Options};
use hitl_slam::solver::{Block, Covariance, Loss, Problem, Solver};
use nalgebra::DMatrix;

use super::linear::{dense, random};
use crate::support::{Dice, problems};

fn inverse(problem: &dyn Problem, x: &[Block], held: &[usize]) -> DMatrix<f64> {
    dense(problem, x, held).0.cholesky().unwrap().inverse()
}

fn close(found: f64, expected: f64, scale: f64) {
    assert!((found - expected).abs() < 1e-9 * scale.max(1e-3), "{found} {expected}");
}

#[test]
fn marginals_are_the_diagonal_blocks_of_the_dense_inverse() {
    let dice = &mut Dice::new(11);
    for _ in 0..60 {
        let blocks = 1 + dice.index(50);
        let terms = dice.index(3 * blocks);
        let problem = random(blocks, terms, dice);
        let x = vec![[0.0; 3]; blocks];
        let held: Vec<usize> = (0..blocks).filter(|_| dice.index(9) == 0).collect();
        let expected = inverse(&problem, &x, &held);
        let found = Solver::new(&problem, blocks, &held).marginal_covariances(&problem, &x);
        for (block, found) in found.iter().enumerate() {
            if held.contains(&block) {
                assert_eq!(found.amax(), 0.0);
                continue;
            }
            let expected = expected.fixed_view::<3, 3>(3 * block, 3 * block);
            for (found, expected_entry) in found.iter().zip(expected.iter()) {
                close(*found, *expected_entry, expected.amax());
            }
        }
    }
}

#[test]
fn poses_of_a_joint_problem_have_the_covariances_of_the_dense_inverse() {
    for seed in 0..10 {
        let mut problem = problems::solvable(seed, Loss::Huber(1.5), true);
        Backend::Rust.solve(&mut problem, &Options::default()).unwrap();
        let x = problem.blocks();
        let expected = inverse(&problem, &x, &problem.held);
        let marginals = joint::marginal_covariances(&problem).unwrap();
        assert_eq!(marginals.len(), problem.poses.len());
        let mut covariance = Covariance::new(&problem, &x, &problem.held).unwrap();
        for (a, b) in [(3, 9), (9, 3), (0, 5), (7, 7)] {
            let [of_a, of_b] = [a, b].map(|block| covariance.with(block, &[a, b]));
            let (aa, ab, bb) = (of_a[0], of_b[0], of_b[1]);
            for (found, (row, column)) in [(aa, (a, a)), (ab, (a, b)), (bb, (b, b))] {
                for (r, c) in (0..9).map(|k| (k % 3, k / 3)) {
                    let held = problem.held.contains(&row) || problem.held.contains(&column);
                    let expected = if held { 0.0 } else { expected[(3 * row + r, 3 * column + c)] };
                    close(found[(r, c)], expected, 1.0);
                }
            }
            for (r, c) in (0..9).map(|k| (k % 3, k / 3)) {
                close(marginals[b][(r, c)], bb[(r, c)], 1.0);
            }
        }
    }
}

/// A chain without loops: the position variances of the poses add up, computed by hand.
#[test]
fn uncertainty_grows_along_a_chain_as_it_must() {
    let mut problem = problems::solvable(1, Loss::None, true);
    let n = problem.poses.len();
    problem.poses = (0..n).map(|i| [i as f64, 0.0, 0.0]).collect();
    problem.relatives.truncate(n - 1);
    for (i, t) in problem.relatives.iter_mut().enumerate() {
        (t.i, t.j, t.measured) = (i, i + 1, [1.0, 0.0, 0.0]);
        t.sqrt_information = [10.0, 0.0, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 100.0];
    }
    problem.segments.clear();
    problem.sightings.clear();
    problem.ties.clear();
    problem.relations.clear();
    let marginals = joint::marginal_covariances(&problem).unwrap();
    for (k, m) in marginals.iter().enumerate() {
        let steps = k as f64;
        // The turn of step i moves pose k across by its distance k − i.
        let levers: f64 = (1..=k).map(|i| (k - i) as f64).map(|d| d * d).sum();
        close(m[(0, 0)], 0.01 * steps, 1.0);
        close(m[(1, 1)], 0.0025 * steps + 1e-4 * levers, 1.0);
        close(m[(2, 2)], 1e-4 * steps, 1.0);
    }
}
