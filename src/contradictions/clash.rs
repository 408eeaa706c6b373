//! Whether two visits can have seen the same place: returns of one in space that the other saw free.
//!
//! Seen from pose i, a return of pose j is compared with i's own returns in its direction. Nearer than they by more
//! than a margin: i looked through it, they clash. As far: they agree. Farther, or in a direction from which i has no
//! return: i cannot tell. A correction that lays two different walls on one another brings two visits together that
//! disagree about everything else around them.

use crate::geometry::{Pose2, Vec2};
use crate::map::{Feature, HumanFactor, Mode, SlamMap};

/// A return nearer than the other pose's by less than this, or farther by less than this, agrees, metres.
const MARGIN_M: f64 = 0.25;
/// … and so does one this close to any return in about the same direction, metres.
const NEAR_M: f64 = 0.4;
/// So many returns to either side count as the same direction.
const AROUND: usize = 20;
/// Poses farther apart than this are not compared, metres.
const MOST_APART_M: f64 = 3.0;
/// Poses of each feature that are looked at.
const MOST_POSES: usize = 8;
/// Neighbouring returns of a scan more than this apart in direction leave a gap that shows nothing, radians.
const MOST_GAP_RAD: f64 = 0.03;
/// Fewer comparisons than this say nothing.
const LEAST_RETURNS: usize = 200;

/// The share of comparable returns of a factor's two visits that clash with `poses`, beyond what they would clash if
/// each were compared with itself (twice that is taken off: wheels slip within a visit, people walk through it),
/// 0..=1; `None` if hardly any can be compared, or the factor is no colocation.
pub fn share(map: &SlamMap, factor: &HumanFactor, poses: &[Pose2]) -> Option<f64> {
    // Only a colocation says where the visits lie to each other; a collinear leaves them free to slide along their wall.
    if factor.mode != Mode::Colocation {
        return None;
    }
    let [a, b] = [&factor.a, &factor.b].map(tied);
    let between = compared(map, &a, &b, poses)?;
    let within: Vec<f64> = [&a, &b].iter().filter_map(|v| compared(map, v, v, poses)).collect();
    let usual = within.iter().sum::<f64>() / within.len().max(1) as f64;
    Some((between - 2.0 * usual).max(0.0))
}

/// The share of comparable returns of two lists of poses that clash.
fn compared(map: &SlamMap, a: &[usize], b: &[usize], poses: &[Pose2]) -> Option<f64> {
    let (mut clash, mut agree) = (0, 0);
    for (&i, &j) in a.iter().flat_map(|i| b.iter().map(move |j| (i, j))) {
        if i == j || (poses[i].translation() - poses[j].translation()).norm() > MOST_APART_M {
            continue;
        }
        for (from, to) in [(i, j), (j, i)] {
            let [c, g] = compare(map, from, to, poses);
            (clash, agree) = (clash + c, agree + g);
        }
    }
    (clash + agree >= LEAST_RETURNS).then(|| clash as f64 / (clash + agree) as f64)
}

/// Poses that tie the feature, evenly thinned.
fn tied(feature: &Feature) -> Vec<usize> {
    let all: Vec<usize> = feature.sightings.iter().filter(|s| s.tied).map(|s| s.pose).collect();
    all.iter().copied().step_by(all.len().div_ceil(MOST_POSES).max(1)).collect()
}

/// How many returns of `other` clash and agree with what `pose` saw.
fn compare(map: &SlamMap, pose: usize, other: usize, poses: &[Pose2]) -> [usize; 2] {
    let laser_from_world = poses[pose].compose(map.robot_from_laser).inverse();
    let laser_from_robot = map.robot_from_laser.inverse();
    let polar = |p: Vec2| (p.y.atan2(p.x), p.norm());
    let mut own: Vec<(f64, f64)> = map
        .observations
        .range(pose)
        .map(|k| polar(laser_from_robot.transform_point(map.observations.point(k))))
        .collect();
    own.sort_by(|a, b| a.0.total_cmp(&b.0));
    let laser_from_other = laser_from_world.compose(poses[other]);
    let [mut clash, mut agree] = [0, 0];
    for k in map.observations.range(other) {
        let (bearing, range) = polar(laser_from_other.transform_point(map.observations.point(k)));
        let next = own.partition_point(|o| o.0 < bearing);
        let (Some(left), Some(right)) = (next.checked_sub(1).and_then(|l| own.get(l)), own.get(next)) else {
            continue;
        };
        if right.0 - left.0 > MOST_GAP_RAD {
            continue;
        }
        let (near, far) = (left.1.min(right.1), left.1.max(right.1));
        if range < near - MARGIN_M {
            // A wall seen at a grazing angle is near all the same.
            let around = &own[next.saturating_sub(AROUND)..(next + AROUND).min(own.len())];
            let to = |o: &(f64, f64)| {
                (range * range + o.1 * o.1 - 2.0 * range * o.1 * (bearing - o.0).cos()).max(0.0).sqrt()
            };
            let beside = around.iter().any(|o| to(o) < NEAR_M);
            [clash, agree] = if beside { [clash, agree + 1] } else { [clash + 1, agree] };
        } else if range < far + MARGIN_M {
            agree += 1;
        }
    }
    [clash, agree]
}
