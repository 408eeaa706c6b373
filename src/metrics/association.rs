//! Which pose of one trajectory belongs to which of another: by stamp.

use crate::map::Trajectory;

/// Stamps closer than this are the same moment, unless told otherwise, seconds.
pub const DEFAULT_TOLERANCE_S: f64 = 0.02;

/// Pairs (index in `a`, index in `b`) whose stamps differ by at most `tolerance_s`, in the order of time. Each pose is
/// used at most once; of several candidates the nearest in time wins; equal stamps are matched in order. Stamps may
/// come in any order. Where all stamps of both are whole numbers they are taken for indices and must be equal.
pub fn associate(a: &Trajectory, b: &Trajectory, tolerance_s: f64) -> Vec<(usize, usize)> {
    let is_indexed = |t: &Trajectory| t.stamps_s.iter().all(|s| s.fract() == 0.0);
    let tolerance_s = if is_indexed(a) && is_indexed(b) { 0.0 } else { tolerance_s };
    let (a_order, b_order) = (a.order_by_stamp(), b.order_by_stamp());
    let gap = |i: usize, j: usize| match (a_order.get(i), b_order.get(j)) {
        (Some(&i), Some(&j)) => b.stamps_s[j] - a.stamps_s[i],
        _ => f64::INFINITY,
    };
    let mut pairs = Vec::new();
    let (mut i, mut j) = (0, 0);
    while i < a_order.len() && j < b_order.len() {
        let here = gap(i, j);
        if gap(i + 1, j).abs() < here.abs() {
            i += 1;
        } else if gap(i, j + 1).abs() < here.abs() {
            j += 1;
        } else if here.abs() <= tolerance_s {
            pairs.push((a_order[i], b_order[j]));
            (i, j) = (i + 1, j + 1);
        } else if here > 0.0 {
            i += 1;
        } else {
            j += 1;
        }
    }
    pairs
}
