//! A building made of a seed: corridors that cross at uneven distances, some of them closed, some rooms with a door.

use crate::geometry::{Segment, Vec2};
use crate::pedestrian::random::Key;

/// Corridors in each direction.
const CORRIDORS: [usize; 2] = [5, 3];
/// From the middle of a corridor to the next one's: least, and the range of chance, metres.
const APART_M: [f64; 2] = [9.0, 9.0];
const HALF_WIDTH_M: f64 = 1.2;
const DOOR_M: f64 = 1.4;
/// Solid blocks are hatched so closely, metres.
const SOLID_M: f64 = 0.7;
/// Share of the corridors' pieces that are closed, and of the blocks that are rooms.
const CLOSED: f64 = 0.3;
const ROOMS: f64 = 0.4;

/// The walls; the same key gives the same ones.
pub(super) fn walls(key: Key) -> Vec<Segment> {
    let lines = |axis: usize| {
        let key = key.named("lines").with(axis as u64);
        let mut at_m = vec![0.0];
        for k in 1..CORRIDORS[axis] {
            at_m.push(at_m[k - 1] + APART_M[0] + APART_M[1] * key.uniform(k as u64));
        }
        at_m
    };
    let (x, y) = (lines(0), lines(1));
    let w = HALF_WIDTH_M;
    let mut walls = Vec::new();
    let mut line = |points: &[[f64; 2]]| {
        walls.extend(points.windows(2).map(|p| {
            let [a, b] = [p[0], p[1]].map(|[x, y]| Vec2::new(x, y));
            Segment::from_ends(a, b)
        }));
    };
    let (right, top) = (x[x.len() - 1] + w, y[y.len() - 1] + w);
    line(&[[-w, -w], [right, -w], [right, top], [-w, top], [-w, -w]]);
    for i in 0..x.len() - 1 {
        for j in 0..y.len() - 1 {
            let (l, r, b, t) = (x[i] + w, x[i + 1] - w, y[j] + w, y[j + 1] - w);
            let key = key.named("block").with((i * y.len() + j) as u64);
            let middle = (l + r) / 2.0 + (key.uniform(1) - 0.5) * (r - l - 2.0 * DOOR_M);
            if key.uniform(0) < ROOMS {
                let [from, to] = [middle - DOOR_M / 2.0, middle + DOOR_M / 2.0];
                line(&[[from, b], [l, b], [l, t], [r, t], [r, b], [to, b]]);
            } else {
                line(&[[l, b], [r, b], [r, t], [l, t], [l, b]]);
                // Solid: nobody is to walk inside.
                for k in 1..((t - b) / SOLID_M).ceil() as usize {
                    line(&[[l, b + SOLID_M * k as f64], [r, b + SOLID_M * k as f64]]);
                }
            }
        }
    }
    // A closed piece of corridor is shut in its middle; the lowest corridor stays open, so that all hang together.
    for (j, &at) in y.iter().enumerate().skip(1) {
        for i in 0..x.len() - 1 {
            if key.named("shut").with((i * y.len() + j) as u64).uniform(0) < CLOSED {
                let middle = (x[i] + x[i + 1]) / 2.0;
                line(&[[middle, at - w], [middle, at + w]]);
            }
        }
    }
    walls
}
