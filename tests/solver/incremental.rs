//! A problem that grows against the same problem solved as a whole.

use hitl_slam::geometry::{Pose2, angle_diff};
use hitl_slam::joint::{self, GrowingGraph, Options};
use hitl_slam::map::{Observations, RelativeFactor, SlamMap};
use hitl_slam::solver::{Block, Incremental, Laziness};
use nalgebra::{Matrix3, Vector3};

use super::linear::{Linear, dense};
use crate::support::{Dice, public_graph};

fn assert_is_batch(incremental: &Incremental, problem: &Linear, held: &[usize], round: &str) {
    let x: Vec<Block> = vec![[0.0; 3]; incremental.len()];
    let (h, g) = dense(problem, &x, held);
    let expected = h.cholesky().unwrap().solve(&-g);
    for (block, found) in incremental.estimate().iter().enumerate() {
        for k in 0..3 {
            let expected = expected[3 * block + k];
            assert!(
                (found[k] - expected).abs() < 1e-9 * expected.abs().max(1.0),
                "{round}: {found:?} {expected}"
            );
        }
    }
}

#[test]
fn every_update_of_a_linear_problem_is_the_batch_solution() {
    for seed in 0..12 {
        let dice = &mut Dice::new(seed);
        let matrix = |dice: &mut Dice| Matrix3::from_fn(|_, _| dice.normal(1.0));
        let mut problem = Linear { terms: Vec::new() };
        let mut incremental = Incremental::new(Laziness::NONE);
        let mut held = Vec::new();
        for block in 0..60 {
            let is_held = block > 0 && dice.index(12) == 0;
            if is_held {
                held.push(block);
            }
            incremental.add_block([0.0; 3], is_held);
            let b = Vector3::from_fn(|_, _| dice.normal(1.0));
            problem.terms.push((vec![(block, matrix(dice))], b));
            for _ in 0..dice.index(4).min(block) {
                // Mostly near, sometimes far back, sometimes between old ones.
                let other = if dice.index(3) > 0 { block - 1 } else { dice.index(block) };
                let from = if dice.index(6) == 0 { dice.index(block) } else { block };
                if from != other {
                    let parts = vec![(from, matrix(dice)), (other, matrix(dice))];
                    problem.terms.push((parts, Vector3::from_fn(|_, _| dice.normal(1.0))));
                }
            }
            incremental.update(&problem, &[]);
            assert_is_batch(&incremental, &problem, &held, &format!("seed {seed}, block {block}"));
            if dice.index(5) == 0 {
                let altered: Vec<usize> = (0..3).map(|_| dice.index(problem.terms.len())).collect();
                for &k in &altered {
                    problem.terms[k].1 *= -2.0;
                    for (_, a) in &mut problem.terms[k].0 {
                        *a *= 1.5;
                    }
                }
                incremental.update(&problem, &altered);
                assert_is_batch(&incremental, &problem, &held, &format!("seed {seed}, altered at {block}"));
            }
        }
    }
}

/// A square driven three times with closures to earlier rounds, Ω far from diagonal.
fn rounds(seed: u64) -> SlamMap {
    let dice = &mut Dice::new(seed);
    let mut map = SlamMap { poses: vec![Pose2::new(0.0, 0.0, 3.1)], ..Default::default() };
    let factor = |i: usize, j: usize, z: [f64; 3], dice: &mut Dice| RelativeFactor {
        i,
        j,
        i_from_j: Pose2::from_array(z),
        information: dice.information(),
    };
    for i in 1..120 {
        let turn = if i % 10 == 0 { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        let z = [1.0 + dice.normal(0.02), dice.normal(0.02), turn + dice.normal(0.01)];
        map.poses.push(map.poses[i - 1].compose(Pose2::from_array(z)));
        map.relative_factors.push(factor(i - 1, i, z, dice));
        if i >= 40 && dice.index(3) == 0 {
            let z = [dice.normal(0.02), dice.normal(0.02), dice.normal(0.01)];
            let closure = factor(i - 40, i, z, dice);
            map.relative_factors.push(closure);
        }
    }
    map.observations = Observations::empty(map.poses.len());
    map
}

fn grown(map: &SlamMap) -> GrowingGraph {
    let mut graph = GrowingGraph::new(map.poses[0]);
    for k in 1..map.poses.len() {
        let new: Vec<_> = map.relative_factors.iter().filter(|f| f.i.max(f.j) == k).copied().collect();
        graph.add(&new).unwrap();
    }
    graph
}

fn largest_gap(a: &[Pose2], b: &[Pose2]) -> f64 {
    let gap = |(a, b): (&Pose2, &Pose2)| {
        (a.translation() - b.translation()).norm().max(angle_diff(a.theta_rad, b.theta_rad).abs())
    };
    a.iter().zip(b).map(gap).fold(0.0, f64::max)
}

#[test]
fn a_graph_grown_pose_by_pose_settles_where_batch_does() {
    for seed in 0..5 {
        let mut map = rounds(seed);
        let graph = grown(&map);
        joint::optimize_graph(&mut map, &Options::default()).unwrap();
        assert!(largest_gap(&graph.poses(), &map.poses) < 0.2, "the estimate on the way");
        let (settled, report) = graph.settled(&Options::default().solver);
        assert!(report.termination.converged());
        let gap = largest_gap(&settled, &map.poses);
        assert!(gap < 1e-9, "seed {seed}: {gap}");
    }
}

#[test]
fn a_factor_of_weight_zero_is_gone_and_comes_back_with_weight_one() {
    let mut map = rounds(9);
    let mut graph = grown(&map);
    let closure = map.relative_factors.iter().position(|f| f.j - f.i > 1).unwrap();
    // The graph took its factors in this very order.
    graph.reweight(&[(closure, 0.0)]).unwrap();
    let (without, _) = graph.settled(&Options::default().solver);
    graph.reweight(&[(closure, 1.0)]).unwrap();
    let (with, _) = graph.settled(&Options::default().solver);
    let mut less = map.clone();
    less.relative_factors.remove(closure);
    joint::optimize_graph(&mut map, &Options::default()).unwrap();
    joint::optimize_graph(&mut less, &Options::default()).unwrap();
    assert!(largest_gap(&without, &less.poses) < 1e-9, "{}", largest_gap(&without, &less.poses));
    assert!(largest_gap(&with, &map.poses) < 1e-9, "{}", largest_gap(&with, &map.poses));
    assert!(largest_gap(&with, &without) > 1e-6);
    assert!(graph.reweight(&[(9999, 1.0)]).is_err() && graph.reweight(&[(0, -1.0)]).is_err());
}

#[test]
fn a_pose_that_nothing_leads_to_is_refused() {
    let mut graph = GrowingGraph::new(Pose2::new(0.0, 0.0, 0.0));
    let factor = rounds(1).relative_factors[0];
    assert!(graph.add(&[]).is_err());
    assert!(graph.add(&[RelativeFactor { j: 2, ..factor }]).is_err());
    assert_eq!(graph.len(), 1);
    assert!(graph.add(&[factor]).is_ok());
}

#[test]
fn a_public_graph_grown_pose_by_pose_has_the_chi2_of_batch() {
    for (name, best) in [("M3500", 137.912951), ("INTEL", 215.831117), ("intel943", 546.461112)] {
        let Some(map) = public_graph(name) else { return };
        let (settled, _) = grown(&map).settled(&Options::default().solver);
        let chi2: f64 = map.relative_factors.iter().map(|f| f.chi2(settled[f.i], settled[f.j])).sum();
        assert!((chi2 - best).abs() < 1e-6 * best, "{name}: {chi2}");
    }
}
