//! R6, the paper's R_p: one residual, offset and angle added. With d = c_b − c_a and |s| read as √(s² + ε²):
//!
//! colocation K₁|d| + K₂(1 − n̂_a·n̂_b) · collinear K₁|d·n̂_a| + K₂(1 − n̂_a·n̂_b) · parallel K₂(1 − n̂_a·n̂_b) ·
//! perpendicular K₂(n̂_a·n̂_b). K₁ = 1/σ_offset, K₂ = 1/σ_angle. Blocks: start and end of a, start and end of b.

use super::{PAPER_EPSILON_M, quarter_turn, single_row};
use crate::geometry::Vec2;
use crate::joint::problem::RelationTerm;
use crate::map::Mode;
use crate::solver::{Block, Linearization};

/// A segment by its ends: w from start to end, û = w/√(w² + ε²).
struct Ends {
    centre: Vec2,
    along: Vec2,
    length: f64,
}

impl Ends {
    fn new(start: &Block, end: &Block) -> Self {
        let (start, end) = (Vec2::new(start[0], start[1]), Vec2::new(end[0], end[1]));
        let length = guarded(end - start);
        Ends { centre: (start + end) / 2.0, along: (end - start) / length, length }
    }

    /// The gradient by w of v·û.
    fn gradient_of_along(&self, v: Vec2) -> Vec2 {
        (v - self.along * self.along.dot(&v)) / self.length
    }
}

/// R6 at four end points; `blocks` are their indices in `x`.
pub fn paper_relation(term: &RelationTerm, x: &[Block], blocks: [usize; 4], at: &mut Linearization) {
    let [a, b] = [[0, 1], [2, 3]].map(|[s, e]| Ends::new(&x[blocks[s]], &x[blocks[e]]));
    let d = b.centre - a.centre;
    // Gradients by d, by w_a and by w_b.
    let mut by_d = Vec2::zeros();
    let cosine = a.along.dot(&b.along);
    let sign = if term.mode == Mode::Perpendicular { 1.0 } else { -1.0 };
    let slope = sign * term.angle_scale;
    let mut by_a = a.gradient_of_along(b.along) * slope;
    let by_b = b.gradient_of_along(a.along) * slope;
    let angle = if term.mode == Mode::Perpendicular { cosine } else { 1.0 - cosine };
    let mut residual = term.angle_scale * angle;
    let k = term.offset_scale;
    match term.mode {
        Mode::Colocation => {
            let distance = guarded(d);
            residual += k * distance;
            by_d += d * (k / distance);
        }
        Mode::Collinear => {
            let normal = quarter_turn(a.along);
            let offset = d.dot(&normal);
            let distance = offset.hypot(PAPER_EPSILON_M);
            residual += k * distance;
            let slope = k * offset / distance;
            by_d += normal * slope;
            // d·n̂ = −(quarter turn of d)·û.
            by_a -= a.gradient_of_along(quarter_turn(d)) * slope;
        }
        Mode::Parallel | Mode::Perpendicular => {}
    }
    at.residual[0] = residual;
    let rows = [-by_d / 2.0 - by_a, -by_d / 2.0 + by_a, by_d / 2.0 - by_b, by_d / 2.0 + by_b];
    at.jacobians.extend(blocks.into_iter().zip(rows).map(|(block, g)| (block, single_row([g.x, g.y, 0.0]))));
}

/// √(v² + ε²).
fn guarded(v: Vec2) -> f64 {
    (v.norm_squared() + PAPER_EPSILON_M * PAPER_EPSILON_M).sqrt()
}
