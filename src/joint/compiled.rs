//! The joint problem made ready for our solver: relative factors with their constants worked out, what poses saw of
//! segments as in [`super::visits`], everything else as it is in [`super::terms`].
//!
//! With W = U·diag(Rzᵀ, 1), d = tj − ti the residual of R1 is r = W·[Riᵀd − tz; wrap(θj − θi − θz)].
//! Its Jacobians are ∂r/∂j = W·diag(Riᵀ, 1) and ∂r/∂i = −∂r/∂j·T, T = [I q; 0 1], q = (−d_y, d_x): so J_jᵀJ_j is one
//! rotation of WᵀW, and the other two blocks follow from it by T.

use std::borrow::Cow;

use nalgebra::{Matrix3, Vector3};

use super::problem::{JointProblem, RelativeTerm};
use super::visits;
use crate::geometry::{cos_sin, cos_sin_of, wrap_angle};
use crate::solver::{Block, Linearization, Loss, PairQuadratic, Problem};
use crate::solver::{make_room, wide};

/// R1 with its constants.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relative {
    blocks: [u32; 2],
    measured: [f64; 3],
    /// W: its rows; the last has only its last entry.
    w: [f64; 7],
    loss: Loss,
}

impl Relative {
    pub fn new(term: &RelativeTerm) -> Self {
        let u = Matrix3::from_row_slice(&term.sqrt_information);
        let [c, s] = cos_sin(term.measured[2]);
        let w = u * Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
        Relative {
            blocks: [term.i as u32, term.j as u32],
            measured: term.measured,
            w: [w[(0, 0)], w[(0, 1)], w[(0, 2)], w[(1, 0)], w[(1, 1)], w[(1, 2)], w[(2, 2)]],
            loss: term.loss,
        }
    }

    /// r; (cos, sin) of the first pose's heading; d.
    #[inline(always)]
    fn at(&self, x: &[Block], turns: &[[f64; 2]]) -> ([f64; 3], [f64; 2], [f64; 2]) {
        let [i, j] = self.blocks();
        let [[xi, yi, ti], [xj, yj, tj]] = [x[i], x[j]];
        let [c, s] = turns.get(i).copied().unwrap_or_else(|| cos_sin(ti));
        let (dx, dy) = (xj - xi, yj - yi);
        let [zx, zy, zt] = self.measured;
        let e = [c * dx + s * dy - zx, c * dy - s * dx - zy, wrap_angle(tj - ti - zt)];
        let [w00, w01, w02, w10, w11, w12, w22] = self.w;
        let r = [w00 * e[0] + w01 * e[1] + w02 * e[2], w10 * e[0] + w11 * e[1] + w12 * e[2], w22 * e[2]];
        (r, [c, s], [dx, dy])
    }

    pub fn residual(&self, x: &[Block], turns: &[[f64; 2]]) -> Vector3<f64> {
        self.at(x, turns).0.into()
    }

    /// WᵀW: upper triangle, row by row. Cheaper to make than to fetch.
    #[inline(always)]
    fn information(&self) -> [f64; 6] {
        let [a, b, c, d, e, f, g] = self.w;
        [a * a + d * d, a * b + d * e, a * c + d * f, b * b + e * e, b * c + e * f, c * c + f * f + g * g]
    }

    pub fn blocks(&self) -> [usize; 2] {
        self.blocks.map(|b| b as usize)
    }

    /// Everything but JᵀJ.
    pub fn gradient(&self, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) {
        let (r, turn, d) = self.at(x, turns);
        self.gradient_of(r, turn, d, at);
    }

    pub fn quadratic(&self, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) {
        let (r, turn, d) = self.at(x, turns);
        self.quadratic_of(r, turn, d, at);
    }

    /// The same with slopes that do not depend on where the poses are: d as measured in place of d as it is.
    pub fn quadratic_as_measured(&self, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) {
        let (r, [c, s], _) = self.at(x, turns);
        let [zx, zy, _] = self.measured;
        self.quadratic_of(r, [c, s], [c * zx - s * zy, s * zx + c * zy], at);
    }

    #[inline(always)]
    fn gradient_of(&self, r: [f64; 3], [c, s]: [f64; 2], [dx, dy]: [f64; 2], at: &mut PairQuadratic) {
        let [w00, w01, w02, w10, w11, w12, w22] = self.w;
        let v = [w00 * r[0] + w10 * r[1], w01 * r[0] + w11 * r[1], w02 * r[0] + w12 * r[1] + w22 * r[2]];
        let gj = [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
        at.blocks = self.blocks();
        at.squared_norm = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
        at.gradient = [[-gj[0], -gj[1], -(-dy * gj[0] + dx * gj[1] + gj[2])], gj];
    }

    #[inline(always)]
    fn quadratic_of(&self, r: [f64; 3], [c, s]: [f64; 2], [dx, dy]: [f64; 2], at: &mut PairQuadratic) {
        self.gradient_of(r, [c, s], [dx, dy], at);
        let [o00, o01, o02, o11, o12, o22] = self.information();
        // diag(R, 1)·WᵀW·diag(R, 1)ᵀ.
        let (a00, a01) = (c * o00 - s * o01, c * o01 - s * o11);
        let (a10, a11) = (s * o00 + c * o01, s * o01 + c * o11);
        let (h00, h01, h11) = (a00 * c - a01 * s, a00 * s + a01 * c, a10 * s + a11 * c);
        let (h02, h12) = (c * o02 - s * o12, s * o02 + c * o12);
        // The last column of H·T, and the last entry of Tᵀ·H·T.
        let (q0, q1) = (-dy, dx);
        let (m02, m12) = (h00 * q0 + h01 * q1 + h02, h01 * q0 + h11 * q1 + h12);
        let m22 = h02 * q0 + h12 * q1 + o22;
        at.own = [[h00, h01, m02, h11, m12, q0 * m02 + q1 * m12 + m22], [h00, h01, h02, h11, h12, o22]];
        // J_iᵀJ_j = −TᵀH: its last row is the last column of H·T.
        at.cross = [-h00, -h01, -m02, -h01, -h11, -m12, -h02, -h12, -m22];
    }
}

/// (cos, sin) of the headings of blocks.
pub(super) fn turns_of(x: &[Block], turns: &mut Vec<[f64; 2]>) {
    turns.resize(x.len(), [1.0, 0.0]);
    fill_turns(x, turns);
}

wide! {
    fn fill_turns(x: &[Block], turns: &mut [[f64; 2]]) {
        let (fours, rest) = x.as_chunks::<4>();
        let (turned, turned_rest) = turns.as_chunks_mut::<4>();
        for (x, turns) in fours.iter().zip(turned) {
            match cos_sin_of([x[0][2], x[1][2], x[2][2], x[3][2]]) {
                Some([cos, sin]) => {
                    for k in 0..4 {
                        turns[k] = [cos[k], sin[k]];
                    }
                }
                None => *turns = [cos_sin(x[0][2]), cos_sin(x[1][2]), cos_sin(x[2][2]), cos_sin(x[3][2])],
            }
        }
        for (x, turn) in rest.iter().zip(turned_rest) {
            *turn = cos_sin(x[2]);
        }
    }
}

/// A joint problem for [`crate::solver`].
pub(super) struct Compiled<'a> {
    problem: &'a JointProblem,
    relatives: Cow<'a, [Relative]>,
}

impl<'a> Compiled<'a> {
    pub fn new(problem: &'a JointProblem) -> Self {
        Compiled { problem, relatives: Cow::Owned(Self::relatives(problem, Vec::new())) }
    }

    /// With what [`Compiled::relatives`] gave before.
    pub fn again(problem: &'a JointProblem, relatives: &'a [Relative]) -> Self {
        Compiled { problem, relatives: Cow::Borrowed(relatives) }
    }

    /// In the memory of other ones.
    pub fn new_in(problem: &'a JointProblem, relatives: &'a mut Vec<Relative>) -> Self {
        *relatives = Self::relatives(problem, std::mem::take(relatives));
        Compiled::again(problem, relatives)
    }

    /// The relative factors of a problem, made ready, in the memory of other ones if that is enough.
    pub fn relatives(problem: &JointProblem, mut memory: Vec<Relative>) -> Vec<Relative> {
        memory.clear();
        make_room(&mut memory, problem.relatives.len());
        memory.extend(problem.relatives.iter().map(Relative::new));
        memory
    }

    /// What was made ready.
    pub fn problem(&self) -> &JointProblem {
        self.problem
    }

    /// Σ‖r‖² of all terms at x: no ½, no loss.
    pub fn chi2(&self, x: &[Block]) -> f64 {
        let mut turns = Vec::new();
        self.turns(x, &mut turns);
        let relatives = self.relatives.iter().map(|relative| relative.residual(x, &turns).norm_squared());
        let others = self.relatives.len()..self.terms();
        relatives.sum::<f64>() + others.map(|k| self.residual(k, x).norm_squared()).sum::<f64>()
    }

    /// [`Relative::quadratic_as_measured`] of a relative factor.
    pub fn as_measured(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) {
        self.relatives[term].quadratic_as_measured(x, turns, at);
    }

    /// What a pose saw of a segment, R2 or R3, by its number after the relative factors; false if the term is neither.
    fn visit(&self, k: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        let JointProblem { poses, sightings, points, ties, .. } = self.problem;
        if let Some(term) = sightings.get(k) {
            visits::sighting(term, [term.pose, poses.len() + term.segment], x, turns, at);
            return true;
        }
        let tie = k.checked_sub(sightings.len() + points.len()).and_then(|k| ties.get(k));
        if let Some(term) = tie {
            visits::tie(term, [term.pose, poses.len() + term.segment], x, turns, at);
        }
        tie.is_some()
    }

    /// Of a relative factor: its poses, the measured turn, and the information of that turn.
    pub fn heading(&self, term: usize) -> ([usize; 2], f64, f64) {
        let relative = &self.relatives[term];
        (relative.blocks(), relative.measured[2], relative.information()[5])
    }
}

impl Problem for Compiled<'_> {
    fn terms(&self) -> usize {
        self.problem.terms()
    }

    fn blocks_of(&self, term: usize, blocks: &mut Vec<usize>) {
        self.problem.blocks_of(term, blocks);
    }

    fn loss_of(&self, term: usize) -> Loss {
        self.relatives.get(term).map_or_else(|| self.problem.loss_of(term), |relative| relative.loss)
    }

    fn residual(&self, term: usize, x: &[Block]) -> Vector3<f64> {
        match self.relatives.get(term) {
            Some(relative) => relative.residual(x, &[]),
            None => self.problem.residual(term, x),
        }
    }

    fn linearize(&self, term: usize, x: &[Block], at: &mut Linearization) {
        self.problem.linearize(term, x, at);
    }

    fn turns(&self, x: &[Block], turns: &mut Vec<[f64; 2]>) {
        turns_of(&x[..self.problem.poses.len() + self.problem.segments.len()], turns);
    }

    fn pair_quadratic(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        if let Some(relative) = self.relatives.get(term) {
            relative.quadratic(x, turns, at);
            return true;
        }
        self.visit(term - self.relatives.len(), x, turns, at)
    }

    fn pair_gradient(&self, term: usize, x: &[Block], turns: &[[f64; 2]], at: &mut PairQuadratic) -> bool {
        if let Some(relative) = self.relatives.get(term) {
            relative.gradient(x, turns, at);
            return true;
        }
        self.visit(term - self.relatives.len(), x, turns, at)
    }
}
