//! A start for graphs with loops that does not depend on how the odometry bent: headings first, then positions, each by
//! linear least squares on the factorisation that the optimisation will use.
//!
//! Headings: the unit vectors u = (cos θ, sin θ) without their length constraint, min Σ Ω_θθ‖u_j − R(θ_z)·u_i‖²
//! (chordal relaxation: no angle is ever unwrapped; Martinec & Pajdla, CVPR 2007; Carlone et al., ICRA 2015). Positions: R1
//! with the headings as they are.

use nalgebra::Vector3;

use super::compiled::Compiled;
use crate::geometry::cos_sin;
use crate::solver::{self, Block, Linearization, Loss, PairQuadratic, Problem, Solver};

/// Where an optimisation began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Initialisation {
    /// At the poses as they stood.
    #[default]
    AsGiven,
    /// At the linear estimate, whose cost was lower.
    Linear,
}

/// Moves x, the poses of a problem of relative factors, to the linear estimate if that lowers the cost. `solver` is one
/// made for the problem's structure.
pub(super) fn initialise(graph: &Compiled, x: &mut Vec<Block>, solver: &mut Solver) -> Initialisation {
    let Some(estimate) = estimate(graph, x, solver) else { return Initialisation::AsGiven };
    // Also false if it is not a number.
    if solver::cost(graph, &estimate) < solver::cost(graph, x) {
        *x = estimate;
        return Initialisation::Linear;
    }
    Initialisation::AsGiven
}

fn estimate(graph: &Compiled, start: &[Block], solver: &mut Solver) -> Option<Vec<Block>> {
    let unit = |x: &Block| {
        let [c, s] = cos_sin(x[2]);
        [c, s, 0.0]
    };
    let units: Vec<Block> = start.iter().map(unit).collect();
    let units = solver.gauss_newton_step(&Stage { graph, kind: Kind::Units }, &units)?;
    let mut x = start.to_vec();
    for (x, u) in x.iter_mut().zip(&units) {
        if u[0] != 0.0 || u[1] != 0.0 {
            x[2] = u[1].atan2(u[0]);
        }
    }
    for &held in &graph.problem().held {
        x[held] = start[held];
    }
    solver.gauss_newton_step(&Stage { graph, kind: Kind::Poses }, &x)
}

#[derive(Clone, Copy)]
enum Kind {
    Units,
    Poses,
}

/// One of the linear problems, on the structure of the whole.
struct Stage<'a> {
    graph: &'a Compiled<'a>,
    kind: Kind,
}

impl Stage<'_> {
    fn quadratic(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) {
        if let Kind::Poses = self.kind {
            self.graph.as_measured(term, x, turns, at);
            return;
        }
        let (blocks, turn, w) = self.graph.heading(term);
        *at = PairQuadratic { blocks, ..PairQuadratic::default() };
        let [a, b] = blocks.map(|b| x[b]);
        let [c, s] = cos_sin(turn);
        let e = [b[0] - c * a[0] + s * a[1], b[1] - s * a[0] - c * a[1]];
        at.gradient[0] = [-w * (c * e[0] + s * e[1]), -w * (c * e[1] - s * e[0]), 0.0];
        at.gradient[1] = [w * e[0], w * e[1], 0.0];
        at.own = [[w, 0.0, 0.0, w, 0.0, 0.0]; 2];
        // −w·Rᵀ, column-major.
        at.cross = [-w * c, w * s, 0.0, -w * s, -w * c, 0.0, 0.0, 0.0, 0.0];
    }
}

impl Problem for Stage<'_> {
    fn terms(&self) -> usize {
        self.graph.terms()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        self.graph.blocks_of(term, blocks);
    }

    fn loss_of(&self, _term: usize) -> Loss {
        Loss::None
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        self.graph.residual(term, x)
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        self.graph.linearize(term, x, at);
    }

    fn turns(&self, x: &[Block], turns: &mut Vec<[f64; 2]>) {
        if let Kind::Poses = self.kind {
            self.graph.turns(x, turns);
        }
    }

    fn pair_quadratic(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        self.quadratic(term, x, turns, at);
        true
    }
}
