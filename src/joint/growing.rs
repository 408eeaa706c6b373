//! A pose graph that grows, pose by pose: every new pose costs what it changes, not what is there.

use nalgebra::Vector3;

use super::build::relative_term;
use super::compiled::{Relative, turns_of};
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::RelativeFactor;
use crate::solver::{
    Block, Incremental, Laziness, Linearization, Loss, Options, PairQuadratic, Problem, Report, Solver,
};

/// The factors so far.
#[derive(Debug, Clone, Default)]
struct Factors {
    relatives: Vec<Relative>,
    /// What multiplies each one's information.
    weights: Vec<f64>,
}

/// A pose graph under way. The first pose is held.
#[derive(Debug, Clone)]
pub struct GrowingGraph {
    factors: Factors,
    solver: Incremental,
}

impl GrowingGraph {
    /// A graph of one pose.
    pub fn new(first: Pose2) -> Self {
        let mut solver = Incremental::new(Laziness::default());
        solver.add_block(first.to_array(), true);
        GrowingGraph { factors: Factors::default(), solver }
    }

    /// Number of poses.
    pub fn len(&self) -> usize {
        self.solver.len()
    }

    /// Never: there is always the first pose.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Adds the next pose with the factors that came with it, and updates the estimate. It starts where the first of them
    /// that ends in it puts it.
    ///
    /// # Errors
    /// [`Error::Input`] if a factor names a pose that is not there yet, or none ends in the new one.
    pub fn add(&mut self, factors: &[RelativeFactor]) -> Result<()> {
        let new = self.len();
        let place = |k: usize| format!("pose {new}: factor {k}");
        for (k, f) in factors.iter().enumerate() {
            if f.i.max(f.j) > new || f.i == f.j {
                let message =
                    format!("found poses {} and {}, expected two different ones up to {new}", f.i, f.j);
                return Err(Error::input(place(k), message));
            }
        }
        let start = factors.iter().find_map(|f| match (f.i, f.j) {
            (i, j) if j == new => Some(self.pose(i).compose(f.i_from_j)),
            (i, j) if i == new => Some(self.pose(j).compose(f.i_from_j.inverse())),
            _ => None,
        });
        let Some(start) = start else {
            return Err(Error::input(format!("pose {new}"), "found no factor that ends in it, expected one"));
        };
        self.solver.add_block(start.to_array(), false);
        for f in factors {
            self.factors.relatives.push(Relative::new(&relative_term(f, Loss::None)));
            self.factors.weights.push(1.0);
        }
        self.solver.update(&self.factors, &[]);
        Ok(())
    }

    /// Gives factors (by the order in which they came) another weight: a multiple of their information, 0 takes one out.
    ///
    /// # Errors
    /// [`Error::Input`] for a factor that is not there or a weight that is negative or not finite.
    pub fn reweight(&mut self, weights: &[(usize, f64)]) -> Result<()> {
        let count = self.factors.weights.len();
        for &(k, weight) in weights {
            if k >= count || !(weight >= 0.0 && weight.is_finite()) {
                let message = format!("found weight {weight}, expected one >= 0 for a factor below {count}");
                return Err(Error::input(format!("factor {k}"), message));
            }
        }
        for &(k, weight) in weights {
            self.factors.weights[k] = weight;
        }
        let changed: Vec<usize> = weights.iter().map(|w| w.0).collect();
        self.solver.update(&self.factors, &changed);
        Ok(())
    }

    /// The estimate of one pose.
    pub fn pose(&self, index: usize) -> Pose2 {
        Pose2::from_array(self.solver.block(index))
    }

    /// The estimate.
    pub fn poses(&self) -> Vec<Pose2> {
        (0..self.len()).map(|k| self.pose(k)).collect()
    }

    /// The minimum, by the batch solver from the estimate: to the last digits.
    pub fn settled(&self, options: &Options) -> (Vec<Pose2>, Report) {
        let mut x = self.solver.estimate();
        let report = Solver::new(&self.factors, x.len(), &[0]).minimize(&self.factors, &mut x, options);
        (x.into_iter().map(Pose2::from_array).collect(), report)
    }
}

impl Problem for Factors {
    fn terms(&self) -> usize {
        self.relatives.len()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        blocks.extend(self.relatives[term].blocks());
    }

    fn loss_of(&self, _term: usize) -> Loss {
        Loss::None
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        self.relatives[term].residual(x, &[]) * self.weights[term].sqrt()
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        // Solvers ask for the quadratic form.
        at.residual = self.residual(term, x);
    }

    fn turns(&self, x: &[Block], turns: &mut Vec<[f64; 2]>) {
        turns_of(x, turns);
    }

    fn pair_quadratic(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        self.relatives[term].quadratic(x, turns, at);
        at.scale(self.weights[term]);
        true
    }
}
