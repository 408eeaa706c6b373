//! R2 and R3 made ready for our solver: their quadratic forms, without the Jacobians of [`super::factors`].
//!
//! With v the segment's normal (R2) or direction (R3), both have a row r with ∂r/∂pose = a and ∂r/∂segment = −(a_x, a_y, b).
//! The other two rows of R2 depend on the two headings alone, one slope for the pose and its opposite for the segment.

use super::problem::{SightingTerm, TieTerm};
use crate::geometry::{Vec2, cos_sin};
use crate::solver::{Block, PairQuadratic};

/// A pose and a segment, and where the pose's points lie, in the world frame.
struct Visit {
    /// Unit vectors of the robot: ahead and to its left.
    ahead: Vec2,
    left: Vec2,
    /// Unit vectors of the segment: û and n̂.
    along: Vec2,
    normal: Vec2,
    /// From the robot to the mean of the points, turned by 90°.
    turned_arm: Vec2,
    /// From the segment's centre to the mean of the points.
    offset: Vec2,
}

impl Visit {
    fn new([pose, segment]: [usize; 2], mean: [f64; 2], x: &[Block], turns: &[[f64; 2]]) -> Self {
        let axes = |block: usize| {
            let [c, s] = turns.get(block).copied().unwrap_or_else(|| cos_sin(x[block][2]));
            (Vec2::new(c, s), Vec2::new(-s, c))
        };
        let ((ahead, left), (along, normal)) = (axes(pose), axes(segment));
        let arm = ahead * mean[0] + left * mean[1];
        let offset = arm + Vec2::new(x[pose][0] - x[segment][0], x[pose][1] - x[segment][1]);
        Visit { ahead, left, along, normal, turned_arm: Vec2::new(-arm.y, arm.x), offset }
    }
}

/// R2 at x on a pose and a segment.
pub(super) fn sighting(
    term: &SightingTerm,
    blocks: [usize; 2],
    x: &[Block],
    turns: &[[f64; 2]],
    at: &mut PairQuadratic,
) {
    let visit = Visit::new(blocks, term.mean, x, turns);
    let [w11, w12, w22] = term.scatter_root.map(|w| w * term.scale);
    let shape = |v: Vec2| {
        let (along, across) = (visit.ahead.dot(&v), visit.left.dot(&v));
        [w11 * along + w12 * across, w22 * across]
    };
    let ([r0, r1], [d0, d1]) = (shape(visit.normal), shape(visit.along));
    let root = term.count.sqrt() * term.scale;
    let axis = visit.normal * root;
    let row = Row {
        residual: axis.dot(&visit.offset),
        axis,
        by_pose: axis.dot(&visit.turned_arm),
        by_segment: root * visit.along.dot(&visit.offset),
    };
    row.fill(blocks, at);
    at.squared_norm += r0 * r0 + r1 * r1;
    let (slope, curvature) = (d0 * r0 + d1 * r1, d0 * d0 + d1 * d1);
    at.gradient[0][2] += slope;
    at.gradient[1][2] -= slope;
    at.own[0][5] += curvature;
    at.own[1][5] += curvature;
    at.cross[8] -= curvature;
}

/// R3 at x on a pose and a segment.
pub(super) fn tie(
    term: &TieTerm,
    blocks: [usize; 2],
    x: &[Block],
    turns: &[[f64; 2]],
    at: &mut PairQuadratic,
) {
    let visit = Visit::new(blocks, term.mean, x, turns);
    let axis = visit.along * term.scale;
    let row = Row {
        residual: axis.dot(&visit.offset) - term.scale * term.along,
        axis,
        by_pose: axis.dot(&visit.turned_arm),
        by_segment: -term.scale * visit.normal.dot(&visit.offset),
    };
    row.fill(blocks, at);
}

/// One row: r, (a_x, a_y), a_θ and b.
struct Row {
    residual: f64,
    axis: Vec2,
    by_pose: f64,
    by_segment: f64,
}

impl Row {
    fn fill(&self, blocks: [usize; 2], at: &mut PairQuadratic) {
        let Row { residual: r, axis, by_pose: p, by_segment: s } = *self;
        let (a, b) = (axis.x, axis.y);
        at.blocks = blocks;
        at.squared_norm = r * r;
        at.gradient = [[a * r, b * r, p * r], [-a * r, -b * r, -s * r]];
        at.own = [[a * a, a * b, a * p, b * b, b * p, p * p], [a * a, a * b, a * s, b * b, b * s, s * s]];
        at.cross = [-a * a, -b * a, -p * a, -a * b, -b * b, -p * b, -a * s, -b * s, -p * s];
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::joint::factors::{self, Pair};

    const BLOCKS: [usize; 2] = [0, 1];

    /// Poses and segments, headings near ±π among them.
    fn places() -> impl Iterator<Item = [Block; 2]> {
        let headings = [0.0, 0.7, -1.9, PI - 1e-6, 1e-6 - PI, 40.0];
        headings.into_iter().flat_map(move |pose| {
            headings.map(|segment| [[1.0, -2.0 * pose, pose], [0.3 * segment - 4.0, 2.5, segment]])
        })
    }

    fn assert_is(at: &PairQuadratic, pair: &Pair) {
        let same = |found: &[f64], expected: &[f64]| {
            let size = expected.iter().fold(1.0, |m: f64, e| m.max(e.abs()));
            for (f, e) in found.iter().zip(expected) {
                assert!((f - e).abs() < 1e-12 * size, "{at:?} is not that of {pair:?}");
            }
        };
        let upper = |h: Matrix3<f64>| [h[(0, 0)], h[(0, 1)], h[(0, 2)], h[(1, 1)], h[(1, 2)], h[(2, 2)]];
        let gradient = |j: Matrix3<f64>| -> Vector3<f64> { j.transpose() * pair.residual };
        assert_eq!(at.blocks, BLOCKS);
        same(&[at.squared_norm], &[pair.residual.norm_squared()]);
        same(&at.gradient[0], gradient(pair.j_first).as_slice());
        same(&at.gradient[1], gradient(pair.j_second).as_slice());
        same(&at.own[0], &upper(pair.j_first.transpose() * pair.j_first));
        same(&at.own[1], &upper(pair.j_second.transpose() * pair.j_second));
        same(&at.cross, (pair.j_first.transpose() * pair.j_second).as_slice());
    }

    #[test]
    fn a_sighting_made_ready_is_the_product_of_its_jacobians() {
        let term = SightingTerm {
            pose: 0,
            segment: 0,
            mean: [3.0, -0.4],
            scatter_root: [2.0, -0.3, 0.02],
            count: 37.0,
            scale: 20.0,
        };
        for x in places() {
            let mut at = PairQuadratic::default();
            sighting(&term, BLOCKS, &x, &[], &mut at);
            assert_is(&at, &factors::sighting(&term, &x[0], &x[1]));
        }
    }

    #[test]
    fn a_tie_made_ready_is_the_product_of_its_jacobians() {
        let term = TieTerm { pose: 0, segment: 0, mean: [-1.0, 5.0], along: 0.8, scale: 30.0 };
        for x in places() {
            let mut at = PairQuadratic::default();
            tie(&term, BLOCKS, &x, &[], &mut at);
            assert_is(&at, &factors::tie(&term, &x[0], &x[1]));
        }
    }
}
