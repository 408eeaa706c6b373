//! Jacobians against central differences: the analytic ones, and those that Ceres makes automatically.

use hitl_slam::joint::ceres;
use hitl_slam::joint::problem::TermKind;
use hitl_slam::solver::{Linearization, Problem};

use crate::support::both_backends::ceres_or_skip;
use crate::support::dice::Dice;
use crate::support::problems;

/// Central differences err by h²/6 of a third derivative (residuals are up to 1e4 here) and by rounding over h.
const STEP: f64 = 1e-5;
const TOLERANCE: f64 = 1e-5;

fn check(kind: TermKind) {
    let mut dice = Dice::new(kind as u64);
    for _ in 0..200 {
        let problem = problems::of_kind(kind, 3, &mut dice);
        let x = problem.blocks();
        for term in 0..problem.terms() {
            let mut at = Linearization::default();
            problem.linearize(term, &x, &mut at);
            assert!((at.residual - problem.residual(term, &x)).amax() < 1e-12);
            let mut blocks = Vec::new();
            problem.blocks_of(term, &mut blocks);
            assert_eq!(blocks, at.jacobians.iter().map(|j| j.0).collect::<Vec<_>>());
            let size = at.residual.amax();
            for (block, j) in &at.jacobians {
                for column in 0..3 {
                    let moved = |by: f64| {
                        let mut x = x.clone();
                        x[*block][column] += by;
                        problem.residual(term, &x)
                    };
                    let numeric = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                    let error = (numeric - j.column(column)).amax();
                    let scale = j.amax().max(size).max(1.0);
                    assert!(error < TOLERANCE * scale, "{kind:?} column {column}: {numeric} against {j}");
                }
            }
        }
    }
}

#[test]
fn relative_jacobians_are_the_derivatives() {
    check(TermKind::Relative);
}

#[test]
fn sighting_jacobians_are_the_derivatives() {
    check(TermKind::Sighting);
}

#[test]
fn point_jacobians_are_the_derivatives() {
    check(TermKind::Point);
}

#[test]
fn tie_jacobians_are_the_derivatives() {
    check(TermKind::Tie);
}

#[test]
fn relation_jacobians_are_the_derivatives() {
    check(TermKind::Relation);
}

#[test]
fn paper_fit_jacobians_are_the_derivatives() {
    check(TermKind::Fit);
}

#[test]
fn paper_relation_jacobians_are_the_derivatives() {
    check(TermKind::PaperRelation);
}

#[test]
fn automatic_jacobians_are_the_derivatives_of_what_ceres_evaluates() {
    if !ceres_or_skip() {
        return;
    }
    for kind in problems::KINDS {
        let mut dice = Dice::new(50 + kind as u64);
        for _ in 0..20 {
            let problem = problems::of_kind(kind, 3, &mut dice);
            let x = problem.blocks();
            let here = ceres::evaluate(&problem).unwrap();
            // Residuals of every term with one number of one block moved.
            let moved = |block: usize, column: usize, by: f64| {
                let (mut problem, mut x) = (problem.clone(), x.clone());
                x[block][column] += by;
                problem.set_blocks(&x);
                ceres::evaluate(&problem).unwrap().residuals
            };
            let mut jacobians = here.jacobians.chunks_exact(9);
            for term in 0..problem.terms() {
                let mut blocks = Vec::new();
                problem.blocks_of(term, &mut blocks);
                let rows = 3 * term..3 * term + 3;
                let size = here.residuals[rows.clone()].iter().fold(1.0_f64, |m, r| m.max(r.abs()));
                for block in blocks {
                    let j = jacobians.next().unwrap();
                    let scale = j.iter().fold(size, |m, v| m.max(v.abs()));
                    for column in 0..3 {
                        let (up, down) = (moved(block, column, STEP), moved(block, column, -STEP));
                        for (row, k) in rows.clone().enumerate() {
                            let numeric = (up[k] - down[k]) / (2.0 * STEP);
                            let error = (numeric - j[3 * row + column]).abs();
                            assert!(
                                error < TOLERANCE * scale,
                                "{kind:?} term {term} column {column}: {error}"
                            );
                        }
                    }
                }
            }
        }
    }
}
