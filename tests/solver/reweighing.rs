//! Human factors reweighted, taken out and put back against the same problem solved as a whole.

use std::f64::consts::TAU;

use hitl_slam::geometry::{Pose2, Scatter, Vec2};
use hitl_slam::joint::problem::{JointProblem, RelationTerm, RelativeTerm, SightingTerm, TieTerm};
use hitl_slam::joint::{Backend, Options, Reweighing};
use hitl_slam::map::Mode;
use hitl_slam::solver::{self, Loss};

use crate::support::Dice;

const LAP: usize = 40;
const MODES: [Mode; 4] = [Mode::Colocation, Mode::Collinear, Mode::Perpendicular, Mode::Parallel];

/// Laps on a circle, once through ±π each, with information far from diagonal; a factor says that walls seen by five
/// poses of one lap and of the next are related. They start where the odometry, a little wrong, has them.
fn laps(laps: usize, factors: usize, seed: u64) -> JointProblem {
    let dice = &mut Dice::new(seed);
    let truth: Vec<Pose2> = (0..laps * LAP)
        .map(|i| {
            let around = TAU * (i % LAP) as f64 / LAP as f64;
            Pose2::new(6.0 * around.cos(), 6.0 * around.sin(), around + TAU / 4.0)
        })
        .collect();
    let mut problem = JointProblem { held: vec![0], ..JointProblem::default() };
    let mut poses = vec![truth[0]];
    for j in 1..truth.len() {
        let [x, y, theta] = truth[j - 1].between(truth[j]).to_array();
        let measured = [x + dice.normal(0.01), y + dice.normal(0.01), theta + dice.normal(0.003)];
        let u = dice.information().sqrt();
        problem.relatives.push(RelativeTerm {
            i: j - 1,
            j,
            measured,
            sqrt_information: std::array::from_fn(|k| u[(k / 3, k % 3)]),
            loss: Loss::None,
        });
        poses.push(poses[j - 1].compose(Pose2::from_array(measured)));
    }
    problem.poses = poses.iter().map(|p| p.to_array()).collect();
    for k in 0..factors {
        let at = k * (truth.len() - LAP - 10) / factors;
        for first in [at, at + LAP] {
            let wall = poses[first + 2].compose(Pose2::new(0.0, 3.0, 0.0));
            let segment = problem.segments.len();
            problem.segments.push(wall.to_array());
            for (pose, world_from_robot) in poses.iter().enumerate().skip(first).take(5) {
                let robot_from_wall = world_from_robot.between(wall);
                let points: Vec<Vec2> =
                    (0..9).map(|p| Vec2::new(0.1 * f64::from(p) - 0.4, dice.normal(0.01))).collect();
                let scatter = Scatter::of(points.iter().map(|&p| robot_from_wall.transform_point(p)));
                let along = wall.inverse().transform_point(world_from_robot.transform_point(scatter.mean)).x;
                let (mean, count, scatter_root) = (scatter.mean.into(), scatter.count as f64, scatter.root);
                let scale = 20.0;
                problem.sightings.push(SightingTerm { pose, segment, mean, scatter_root, count, scale });
                problem.ties.push(TieTerm { pose, segment, mean, along, scale: 6.0 });
            }
        }
        problem.relations.push(RelationTerm {
            mode: MODES[(k + seed as usize) % 2],
            a: 2 * k,
            b: 2 * k + 1,
            offset_scale: 50.0,
            angle_scale: 100.0,
            loss: if k % 2 == 1 { Loss::Cauchy(5.0) } else { Loss::None },
        });
    }
    problem
}

/// The same with these weights in its terms; those of weight 0 are not there.
fn weighted(problem: &JointProblem, weights: &[f64]) -> JointProblem {
    let root = |segment: usize| weights[segment / 2].sqrt();
    let mut all = problem.clone();
    all.sightings.retain(|t| root(t.segment) > 0.0);
    all.ties.retain(|t| root(t.segment) > 0.0);
    all.relations.retain(|t| root(t.a) > 0.0);
    all.sightings.iter_mut().for_each(|t| t.scale *= root(t.segment));
    all.ties.iter_mut().for_each(|t| t.scale *= root(t.segment));
    for t in &mut all.relations {
        t.offset_scale *= root(t.a);
        t.angle_scale *= root(t.a);
    }
    all
}

fn precise() -> Options {
    let solver = solver::Options { step: 1e-11, ..solver::Options::default() };
    Options { solver, ..Options::default() }
}

fn assert_is_batch(all: &Reweighing, what: &str) {
    let mut batch = weighted(all.problem(), all.weights());
    let report = Backend::Rust.solve(&mut batch, &precise()).unwrap();
    assert!(report.termination.converged(), "{what}: {report:#?}");
    // Of a factor that was taken out nothing holds the segments: only poses count.
    for (k, (a, b)) in all.problem().poses.iter().zip(&batch.poses).enumerate() {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < 1e-9, "{what}: pose {k}: {a} {b}");
        }
    }
}

#[test]
fn any_sequence_of_weights_ends_where_batch_does() {
    for seed in 0..6 {
        let dice = &mut Dice::new(100 + seed);
        let problem = laps(5, 4, seed);
        let (mut all, report) = Reweighing::new(problem, &precise().solver).unwrap();
        assert!(report.termination.converged());
        assert_is_batch(&all, &format!("seed {seed}: first"));
        for change in 0..12 {
            let mut weights = vec![(dice.index(4), [0.0, 0.2, 1.0, 1.05, 9.0][dice.index(5)])];
            if dice.index(3) == 0 {
                weights.push((dice.index(4), dice.uniform(0.5, 2.0)));
            }
            let report = all.reweigh(&weights).unwrap();
            assert!(report.termination.converged());
            assert!(report.final_cost <= report.initial_cost * (1.0 + 1e-9));
            assert_is_batch(&all, &format!("seed {seed}, change {change}: {weights:?}"));
        }
    }
}

#[test]
fn a_factor_more_is_a_problem_more_in_the_same_memory() {
    let (mut all, _) = Reweighing::new(laps(5, 2, 1), &precise().solver).unwrap();
    all.reweigh(&[(0, 3.0)]).unwrap();
    let more = laps(5, 3, 1);
    let (fresh, _) = Reweighing::new(more.clone(), &precise().solver).unwrap();
    let report = all.replace(more).unwrap();
    assert!(report.termination.converged());
    assert_eq!(all.problem(), fresh.problem(), "what was solved before leaves no trace");
    assert_eq!(all.weights(), [1.0; 3]);
    all.reweigh(&[(2, 0.0)]).unwrap();
    assert_is_batch(&all, "without the third again");
}

#[test]
fn a_small_change_leaves_part_of_the_factorisation_alone() {
    let (mut all, _) = Reweighing::new(laps(30, 6, 2), &precise().solver).unwrap();
    let mut shares = Vec::new();
    for factor in 0..6 {
        all.reweigh(&[(factor, 1.000_001)]).unwrap();
        let (anew, there) = all.refactored();
        assert!(0 < anew && anew < there, "factor {factor}: {anew} of {there}");
        shares.push(anew as f64 / there as f64);
        assert_is_batch(&all, &format!("factor {factor}"));
    }
    // How far it is to the root of the elimination tree depends on where the factor lies.
    assert!(shares.iter().any(|&s| s < 0.4), "{shares:?}");
}

#[test]
fn a_weight_that_is_none_is_refused_and_nothing_changes() {
    let (mut all, _) = Reweighing::new(laps(3, 1, 3), &precise().solver).unwrap();
    let before = all.problem().clone();
    for (k, weight) in [(1, 1.0), (0, -1.0), (0, f64::NAN), (0, f64::INFINITY)] {
        let message = all.reweigh(&[(0, 2.0), (k, weight)]).unwrap_err().to_string();
        assert!(message.contains(&format!("human factor {k}")), "{message}");
    }
    assert_eq!(all.problem(), &before);
    assert_eq!(all.weights(), [1.0]);
}
