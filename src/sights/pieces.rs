//! The straight pieces of wall that one scan shows, as an eye would pick them out.
//!
//! Returns of neighbouring beams are split where they jump and where they bend (Douglas–Peucker), and what is left is
//! fitted by total least squares. Robot frame.

use crate::geometry::{Scatter, Segment, Vec2, principal_direction};
use crate::map::Observations;

/// Neighbouring returns farther apart than this are not on one wall: metres, and metres per metre of range.
const JUMP_M: (f64, f64) = (0.2, 0.06);
/// A return this far from the line between the ends bends it, metres: three times an old laser's noise.
const BEND_M: f64 = 0.08;
/// Shorter pieces are furniture, metres.
const SHORTEST_M: f64 = 1.0;
/// Fewer returns say too little.
const FEWEST_RETURNS: usize = 10;
/// Nobody draws on something farther from the robot, metres.
const FARTHEST_M: f64 = 8.0;

/// The pieces that pose `pose` shows, longest first.
pub(super) fn of_pose(observations: &Observations, pose: usize) -> Vec<Segment> {
    let near = observations.range(pose).filter(|&k| f64::from(observations.ranges_m[k]) <= FARTHEST_M);
    let points: Vec<Vec2> = near.map(|k| observations.point(k)).collect();
    let joined = |p: &Vec2, q: &Vec2| (q - p).norm() <= JUMP_M.0 + JUMP_M.1 * p.norm();
    let mut pieces = Vec::new();
    points.chunk_by(joined).for_each(|run| split(run, &mut pieces));
    pieces.sort_by(|a: &Segment, b| b.half_length_m.total_cmp(&a.half_length_m));
    pieces
}

/// Splits at the return farthest from the line between the ends until none is far.
fn split(run: &[Vec2], pieces: &mut Vec<Segment>) {
    let [first, .., last] = run else { return };
    if run.len() < FEWEST_RETURNS || run.iter().all(|p| (p - first).norm() < SHORTEST_M) {
        return;
    }
    let chord = Segment::from_ends(*first, *last);
    let off = |k: &usize| {
        let d = if first == last { (run[*k] - first).norm() } else { chord.along_across(run[*k]).1.abs() };
        (d * 1e9) as u64
    };
    let Some(farthest) = (1..run.len() - 1).max_by_key(off) else { return };
    if off(&farthest) as f64 > BEND_M * 1e9 {
        split(&run[..=farthest], pieces);
        split(&run[farthest..], pieces);
        return;
    }
    let scatter = Scatter::of(run.iter().copied());
    let direction_rad = principal_direction(scatter.second_moments());
    let line = Segment { centre: scatter.mean, direction_rad, half_length_m: 0.0 };
    let on_line = |p: &Vec2| line.centre + line.direction() * line.along_across(*p).0;
    let piece = Segment::from_ends(on_line(first), on_line(last));
    if 2.0 * piece.half_length_m >= SHORTEST_M {
        pieces.push(piece);
    }
}
