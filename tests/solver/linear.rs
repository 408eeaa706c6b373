//! The block factorisation against a dense one: one Gauss–Newton step of a linear problem is its solution.

use hitl_slam::solver::{self, Block, Linearization, Loss, Problem, Solver, Termination};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::support::Dice;

/// (block k, Aₖ) of one term, and its b.
type Term = (Vec<(usize, Matrix3<f64>)>, Vector3<f64>);

/// r = Σ Aₖ·(block k) − b for every term.
pub struct Linear {
    pub terms: Vec<Term>,
}

impl Problem for Linear {
    fn terms(&self) -> usize {
        self.terms.len()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        blocks.extend(self.terms[term].0.iter().map(|t| t.0));
    }

    fn loss_of(&self, _term: usize) -> Loss {
        Loss::None
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        let (parts, b) = &self.terms[term];
        parts.iter().map(|(k, a)| a * Vector3::from(x[*k])).sum::<Vector3<f64>>() - b
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        at.residual = self.residual(term, x);
        at.jacobians.extend(self.terms[term].0.iter().copied());
    }
}

/// Terms on pairs, triples and quadruples of blocks; a block in five knows fewer than three numbers.
pub fn random(blocks: usize, terms: usize, dice: &mut Dice) -> Linear {
    let dimensions: Vec<usize> =
        (0..blocks).map(|_| if dice.index(5) == 0 { 1 + dice.index(2) } else { 3 }).collect();
    let matrix = |block: usize, dice: &mut Dice| {
        Matrix3::from_fn(|_, c| if c < dimensions[block] { dice.normal(1.0) } else { 0.0 })
    };
    let mut problem = Linear { terms: Vec::new() };
    for block in 0..blocks {
        let parts = vec![(block, matrix(block, dice))];
        problem.terms.push((parts, Vector3::from_fn(|_, _| dice.normal(1.0))));
    }
    for _ in 0..terms {
        let mut touched: Vec<usize> = (0..2 + dice.index(3)).map(|_| dice.index(blocks)).collect();
        touched.sort_unstable();
        touched.dedup();
        if dice.index(2) == 0 {
            touched.reverse();
        }
        let parts = touched.into_iter().map(|b| (b, matrix(b, dice))).collect();
        problem.terms.push((parts, Vector3::from_fn(|_, _| dice.normal(1.0))));
    }
    problem
}

/// H and g of the free scalars, dense, in block order; padding has a one on its diagonal.
pub fn dense(problem: &dyn Problem, x: &[Block], held: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
    let n = 3 * x.len();
    let (mut h, mut g) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for term in 0..problem.terms() {
        let mut at = Linearization::default();
        problem.linearize(term, x, &mut at);
        let w = problem.loss_of(term).weight(at.residual.norm_squared());
        for (a, ja) in &at.jacobians {
            let mut part = g.fixed_rows_mut::<3>(3 * a);
            part += ja.transpose() * at.residual * w;
            for (b, jb) in &at.jacobians {
                let mut block = h.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                block += ja.transpose() * jb * w;
            }
        }
    }
    for k in 0..n {
        if held.contains(&(k / 3)) {
            h.row_mut(k).fill(0.0);
            h.column_mut(k).fill(0.0);
            g[k] = 0.0;
        }
        if h[(k, k)] == 0.0 {
            h[(k, k)] = 1.0;
        }
    }
    (h, g)
}

#[test]
fn a_step_is_that_of_a_dense_cholesky() {
    let dice = &mut Dice::new(1);
    for round in 0..200 {
        let blocks = 1 + dice.index(60);
        let terms = dice.index(3 * blocks);
        let problem = random(blocks, terms, dice);
        let x: Vec<Block> = (0..blocks).map(|_| [0; 3].map(|_| dice.normal(1.0))).collect();
        let held: Vec<usize> = (0..blocks).filter(|_| dice.index(8) == 0).collect();
        let (h, g) = dense(&problem, &x, &held);
        let expected = h.cholesky().unwrap().solve(&-g);
        let moved = Solver::new(&problem, blocks, &held).gauss_newton_step(&problem, &x).unwrap();
        for (k, expected) in expected.iter().enumerate() {
            let step = moved[k / 3][k % 3] - x[k / 3][k % 3];
            assert!(
                (step - expected).abs() < 1e-9 * expected.abs().max(1.0),
                "round {round}: {step} {expected}"
            );
        }
    }
}

#[test]
fn what_a_solver_solved_before_leaves_no_trace() {
    let dice = &mut Dice::new(5);
    let mut reused = Solver::default();
    for round in 0..50 {
        let blocks = 1 + dice.index(80);
        let problem = random(blocks, dice.index(3 * blocks), dice);
        let held: Vec<usize> = (0..blocks).filter(|_| dice.index(8) == 0).collect();
        let start: Vec<Block> = (0..blocks).map(|_| [0; 3].map(|_| dice.normal(1.0))).collect();
        let (mut fresh, mut again) = (start.clone(), start);
        let expected =
            Solver::new(&problem, blocks, &held).minimize(&problem, &mut fresh, &Default::default());
        reused.analyse(&problem, blocks, &held);
        let report = reused.minimize(&problem, &mut again, &Default::default());
        assert_eq!(fresh, again, "round {round}");
        assert_eq!(expected.iterations, report.iterations, "round {round}");
    }
}

#[test]
fn a_linear_problem_is_solved_in_one_step() {
    let dice = &mut Dice::new(2);
    let problem = random(40, 80, dice);
    let mut x = vec![[0.0; 3]; 40];
    let report = solver::minimize(&problem, &mut x, &[], &Default::default());
    assert!(report.termination.converged());
    assert_eq!(report.accepted_steps(), 1, "{report:#?}");
}

/// A grid, a chain, a star and a clique: the patterns that orderings are good and bad at. And what chains make of each other:
/// rings, a ring with a tail, a string of rings, two chains between the same two blocks and back to one, a comb.
#[test]
fn every_shape_of_graph_is_solved_exactly() {
    let grid = |k: usize| {
        let right = (0..k * k).filter(move |i| i % k + 1 < k).map(|i| (i, i + 1));
        right.chain((0..k * (k - 1)).map(move |i| (i, i + k))).collect::<Vec<_>>()
    };
    let star: Vec<_> = (1..3000).map(|i| (0, i)).collect();
    let clique: Vec<_> = (0..40).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
    let chain: Vec<_> = (1..5000).map(|i| (i - 1, i)).collect();
    let path = |from: usize, to: usize| (from + 1..=to).map(|i| (i - 1, i)).collect::<Vec<_>>();
    let ring = |from: usize, to: usize| [path(from, to), vec![(to, from)]].concat();
    let rings = [ring(0, 2), path(5, 6), ring(10, 40)].concat();
    let tail = [ring(0, 30), path(30, 60)].concat();
    let string = (0..20).flat_map(|k| [ring(10 * k, 10 * k + 6), path(10 * k + 6, 10 * k + 10)].concat());
    let twice = [ring(0, 30), vec![(0, 31), (31, 32), (32, 9)], vec![(0, 40), (40, 41), (41, 0)]].concat();
    let comb = (1..50).flat_map(|k| [(5 * k - 5, 5 * k), (5 * k, 5 * k + 1), (5 * k + 1, 5 * k + 2)]);
    for (name, edges) in [
        ("grid", grid(40)),
        ("star", star),
        ("clique", clique),
        ("chain", chain),
        ("rings", rings),
        ("tail", tail),
        ("string", string.collect()),
        ("twice", twice),
        ("comb", comb.collect()),
    ] {
        let blocks = 1 + edges.iter().map(|e| e.0.max(e.1)).max().unwrap();
        let dice = &mut Dice::new(3);
        let mut problem = random(blocks, 0, dice);
        for (a, b) in edges {
            let parts = [a, b].map(|k| (k, Matrix3::from_fn(|_, _| dice.normal(1.0))));
            problem.terms.push((parts.to_vec(), Vector3::zeros()));
        }
        let moved =
            Solver::new(&problem, blocks, &[]).gauss_newton_step(&problem, &vec![[0.0; 3]; blocks]).unwrap();
        // At the minimum the gradient vanishes.
        let mut gradient = vec![Vector3::zeros(); blocks];
        for term in 0..problem.terms() {
            let mut at = Linearization::default();
            problem.linearize(term, &moved, &mut at);
            for (block, j) in &at.jacobians {
                gradient[*block] += j.transpose() * at.residual;
            }
        }
        let largest = gradient.iter().map(|g| g.amax()).fold(0.0, f64::max);
        assert!(largest < 1e-8, "{name}: {largest}");
        if blocks <= 250 {
            let (h, g) = dense(&problem, &vec![[0.0; 3]; blocks], &[]);
            let expected = h.cholesky().unwrap().solve(&-g);
            let off = (DVector::from_vec(moved.concat()) - expected).amax();
            assert!(off < 1e-8, "{name}: {off} from the dense one");
        }
    }
}

#[test]
fn the_order_of_terms_and_the_names_of_blocks_do_not_matter() {
    let dice = &mut Dice::new(4);
    let (blocks, terms) = (50, 120);
    let problem = random(blocks, terms, dice);
    let mut names: Vec<usize> = (0..blocks).collect();
    for k in (1..blocks).rev() {
        names.swap(k, dice.index(k + 1));
    }
    let mut renamed = Linear { terms: problem.terms.clone() };
    renamed.terms.reverse();
    for (parts, _) in &mut renamed.terms {
        for (block, _) in parts {
            *block = names[*block];
        }
    }
    let start = vec![[0.0; 3]; blocks];
    let solve = |p: &Linear| Solver::new(p, blocks, &[]).gauss_newton_step(p, &start).unwrap();
    let (plain, other) = (solve(&problem), solve(&renamed));
    for block in 0..blocks {
        for k in 0..3 {
            assert!((plain[block][k] - other[names[block]][k]).abs() < 1e-9);
        }
    }
}

#[test]
fn what_no_term_determines_is_named_and_left_where_it_is() {
    // Block 2 is only known relative to block 3.
    let one = Matrix3::identity();
    let problem = Linear {
        terms: vec![
            (vec![(0, one)], Vector3::new(1.0, 2.0, 3.0)),
            (vec![(0, -one), (1, one)], Vector3::new(1.0, 0.0, 0.0)),
            (vec![(2, -one), (3, one)], Vector3::new(0.0, 1.0, 0.0)),
        ],
    };
    let mut x = vec![[0.5; 3]; 4];
    let report = solver::minimize(&problem, &mut x, &[], &Default::default());
    assert!(report.termination.converged() && report.final_cost < 1e-20, "{report:#?}");
    assert_eq!(report.undetermined.len(), 1, "{report:#?}");
    assert!([2, 3].contains(&report.undetermined[0]));
    assert!((x[1][0] - 2.0).abs() < 1e-12 && (x[3][1] - x[2][1] - 1.0).abs() < 1e-12);
    assert!(x[2].iter().chain(&x[3]).all(|v| (v - 0.5).abs() < 1.1), "{x:?}");
}

#[test]
fn nothing_but_held_blocks_is_nothing_to_do() {
    let problem = random(3, 2, &mut Dice::new(5));
    let mut x = vec![[1.0; 3]; 3];
    let report = solver::minimize(&problem, &mut x, &[0, 1, 2], &Default::default());
    assert_eq!(report.termination, Termination::NothingToOptimize);
    assert_eq!(x, vec![[1.0; 3]; 3]);
}
