//! What can be drawn: two looks at one wall, given where one of the two poses really lies seen from the other.
//!
//! Nothing here depends on how the map is bent: strokes hang on poses, and where pose j really is seen from pose i is
//! somebody's word (a reference's, a scan match's). How far the two looks are apart on the map as it stands is [`Sight::disagreement`].

mod chain;
mod pieces;

pub use chain::Chain;

use crate::geometry::{Pose2, Segment, Vec2, angle_diff, wrap_angle};
use crate::map::{Correction, Mode, Observations, SlamMap, Stroke};

/// Two pieces are one wall within this: radians, and metres across.
const SAME_WALL: (f64, f64) = (0.07, 0.12);
/// … if they have at least this in common, metres.
const SHORTEST_M: f64 = 1.0;
/// Ends this close to each other are the same corner, metres.
const SAME_END_M: f64 = 0.15;
/// Walls of a building that differ by less than this are parallel, radians.
const PARALLEL_RAD: f64 = 0.03;
/// Pieces turned by more than this would be turned the wrong way, radians (80°).
const FARTHEST_TURN_RAD: f64 = 1.4;
/// A wall that can be taken for another: as parallel as this, radians …
const ALIKE_RAD: f64 = 0.35;
/// … and at least so far beside it, metres.
const BESIDE_M: f64 = 0.3;

/// A stroke without noise: the robot frame of a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Index of the pose.
    pub pose: usize,
    /// End points.
    pub ends: [Vec2; 2],
}

/// Two looks and how they relate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Colocation where both looks show the same corner, collinear on a plain wall, parallel where they share no wall.
    pub mode: Mode,
    /// Seen from pose i.
    pub a: Look,
    /// Seen from pose j.
    pub b: Look,
    /// How pose b is truly turned against pose a, radians.
    pub heading_rad: f64,
    /// A piece near `b`, seen from the same pose, that is another wall.
    pub wrong_b: Option<Look>,
}

impl Sight {
    /// The same as a correction without noise, under a name.
    pub fn correction(&self, id: String, weight: f64) -> Correction {
        let [a, b] = [self.a, self.b].map(|look| Stroke::Pose { pose: look.pose, points: look.ends });
        Correction { id, mode: self.mode, a, b, weight, enabled: true }
    }

    /// How far the two looks are displaced along their wall on the map, metres.
    pub fn along_m(&self, map: &SlamMap) -> f64 {
        let place = |look: &Look| look.ends.map(|p| map.poses[look.pose].transform_point(p));
        let [[p, q], [r, s]] = [&self.a, &self.b].map(place);
        Segment::from_ends(p, q).along_across((r + s) / 2.0).0.abs()
    }

    /// How far the two looks are apart on the map, metres, and the square of that in standard deviations: the chain's own and
    /// those of what is `known` of where they lie (metres, radians). `None`: they are turned so far against each other (80°) that
    /// a correction would turn them the wrong way: a line has no direction.
    pub fn disagreement(&self, map: &SlamMap, chain: &Chain, known: (f64, f64)) -> Option<(f64, f64)> {
        let [i, j] = [self.a.pose, self.b.pose].map(|pose| map.poses[pose].theta_rad);
        if angle_diff(angle_diff(j, i), self.heading_rad).abs() > FARTHEST_TURN_RAD {
            return None;
        }
        let place = |look: &Look| look.ends.map(|p| map.poses[look.pose].transform_point(p));
        let (a, b) = (place(&self.a), place(&self.b));
        let [line_a, line_b] = [a, b].map(|[p, q]| Segment::from_ends(p, q));
        let turn_rad = line_angle(line_b.direction_rad - line_a.direction_rad);
        let (_, across_m) = line_a.along_across(line_b.centre);
        let (offset_m, apart_m) = match self.mode {
            Mode::Colocation => {
                let gaps = [(b[0] - a[0]).norm(), (b[1] - a[1]).norm()];
                ((line_b.centre - line_a.centre).norm(), gaps[0].max(gaps[1]))
            }
            Mode::Collinear => {
                let gaps = b.map(|end| line_a.along_across(end).1.abs());
                (across_m.abs(), gaps[0].max(gaps[1]))
            }
            Mode::Parallel | Mode::Perpendicular => (0.0, turn_rad.sin().abs() * line_b.half_length_m),
        };
        let (position, heading) = chain.variances(self.a.pose, self.b.pose, line_b.centre);
        let surprise =
            offset_m.powi(2) / (position + known.0.powi(2)) + turn_rad.powi(2) / (heading + known.1.powi(2));
        Some((apart_m, surprise))
    }
}

/// Pieces of wall by pose, found when first asked for.
pub struct Pieces<'a> {
    observations: &'a Observations,
    by_pose: Vec<Option<Vec<Segment>>>,
}

impl<'a> Pieces<'a> {
    /// Of a map.
    pub fn new(observations: &'a Observations) -> Self {
        let poses = observations.starts.len().saturating_sub(1);
        Pieces { observations, by_pose: vec![None; poses] }
    }

    fn of(&mut self, pose: usize) -> Vec<Segment> {
        let observations = self.observations;
        self.by_pose[pose].get_or_insert_with(|| pieces::of_pose(observations, pose)).clone()
    }

    /// What poses i and j show of the same wall: at most one sight of each mode, the longest; a parallel one only where
    /// they share no wall.
    pub fn sights(&mut self, (i, j): (usize, usize), i_from_j: Pose2) -> Vec<Sight> {
        let (of_i, of_j, heading_rad) = (self.of(i), self.of(j), i_from_j.theta_rad);
        let mut best: [Option<(f64, Sight)>; 2] = [None; 2];
        for a in &of_i {
            for b in &of_j {
                let Some((mode, length_m, ends)) = common(a, b, i_from_j) else { continue };
                let slot = &mut best[usize::from(mode == Mode::Collinear)];
                if slot.is_none_or(|(longest_m, _)| length_m > longest_m) {
                    let wrong = of_j.iter().filter(|w| is_beside(b, w));
                    let nearest = wrong.min_by(|v, w| gap_m(b, v).total_cmp(&gap_m(b, w)));
                    let wrong_b = nearest.map(|w| Look { pose: j, ends: w.ends() });
                    let (a, b) = (Look { pose: i, ends: ends[0] }, Look { pose: j, ends: ends[1] });
                    *slot = Some((length_m, Sight { mode, a, b, heading_rad, wrong_b }));
                }
            }
        }
        let found: Vec<Sight> = best.into_iter().flatten().map(|(_, sight)| sight).collect();
        if !found.is_empty() {
            return found;
        }
        let (Some(a), Some(b)) = (of_i.first(), of_j.first()) else { return found };
        let turn_rad = a.direction_rad - (b.direction_rad + heading_rad);
        if line_angle(turn_rad).abs() > PARALLEL_RAD {
            return found;
        }
        let (a, b) = (Look { pose: i, ends: a.ends() }, Look { pose: j, ends: b.ends() });
        vec![Sight { mode: Mode::Parallel, a, b, heading_rad, wrong_b: None }]
    }
}

/// What two pieces have in common, if they are the same face of one wall: mode, length and the ends in either frame.
fn common(a: &Segment, b_in_j: &Segment, i_from_j: Pose2) -> Option<(Mode, f64, [[Vec2; 2]; 2])> {
    let b = b_in_j.transformed(i_from_j);
    if line_angle(a.direction_rad - b.direction_rad).abs() > SAME_WALL.0 {
        return None;
    }
    let [p, q] = b.ends().map(|end| a.along_across(end));
    let (low, high) = if p.0 <= q.0 { (p, q) } else { (q, p) };
    let from_m = low.0.max(-a.half_length_m);
    let to_m = high.0.min(a.half_length_m);
    let same_side = a.along_across(Vec2::zeros()).1 * a.along_across(i_from_j.translation()).1 > 0.0;
    // Across where they overlap, not at the far end of the longer one.
    let at = |along_m: f64| low.1 + (high.1 - low.1) * (along_m - low.0) / (high.0 - low.0);
    let apart_m = at(from_m).abs().max(at(to_m).abs());
    if !same_side || to_m - from_m < SHORTEST_M || apart_m > SAME_WALL.1 {
        return None;
    }
    let shared_corner =
        (low.0 + a.half_length_m).abs() <= SAME_END_M || (high.0 - a.half_length_m).abs() <= SAME_END_M;
    let mode = if shared_corner { Mode::Colocation } else { Mode::Collinear };
    let on_a = [from_m, to_m].map(|along_m| a.centre + a.direction() * along_m);
    let j_from_i = i_from_j.inverse();
    let on_b = on_a.map(|p| {
        let (along_m, _) = b_in_j.along_across(j_from_i.transform_point(p));
        b_in_j.centre + b_in_j.direction() * along_m
    });
    Some((mode, to_m - from_m, [on_a, on_b]))
}

/// True if `other` could be taken for `wall` and is not it.
fn is_beside(wall: &Segment, other: &Segment) -> bool {
    let across_m = wall.along_across(other.centre).1.abs().min(other.along_across(wall.centre).1.abs());
    line_angle(wall.direction_rad - other.direction_rad).abs() <= ALIKE_RAD && across_m >= BESIDE_M
}

fn gap_m(wall: &Segment, other: &Segment) -> f64 {
    (wall.centre - other.centre).norm()
}

/// An angle between lines: in (−π/2, π/2].
pub fn line_angle(angle_rad: f64) -> f64 {
    wrap_angle(2.0 * angle_rad) / 2.0
}
