//! Suggestions as data, and their reasons in words.

use super::faults::Fault;
use crate::geometry::Segment;
use crate::map::{Correction, SlamMap};
use crate::sights::{Look, Sight, line_angle};

/// Two pieces closer than this across, metres, and in direction, radians, that lie side by side look like one wall twice.
const DOUBLED: (f64, f64) = (1.5, 0.2);

/// What is wrong at a place, as it looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Kind {
    /// The chain is torn or bent: its own scans contradict it beyond its covariance.
    Break,
    /// One wall stands there twice, nearly parallel.
    DoubledWall,
    /// Two visits of one place lie apart.
    Visits,
}

impl Kind {
    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Break => "break",
            Kind::DoubledWall => "doubled-wall",
            Kind::Visits => "visits",
        }
    }
}

/// A place where a correction would help.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Suggestion {
    /// From 1: the most helpful.
    pub rank: usize,
    /// What is wrong.
    pub kind: Kind,
    /// Why, for a person.
    pub reason: String,
    /// The two poses that the strokes hang on.
    pub poses: [usize; 2],
    /// The two pieces of wall where they lie once the suggestions before this one are applied: ends in the world, metres.
    pub walls: [[[f64; 2]; 2]; 2],
    /// How far they are apart there, metres.
    pub apart_m: f64,
    /// The same in standard deviations of the chain between the two.
    pub sigmas: f64,
    /// Share of the later visit's points that fit as matched, 0 to 1.
    pub inliers: f64,
    /// Mean distance of all compared places from their matches before (each counts for 1 m at most), metres …
    pub misfit_before_m: f64,
    /// … and with this correction.
    pub misfit_after_m: f64,
    /// Compared places that are visibly apart before and not any more with this correction …
    pub brings_together: usize,
    /// … of so many.
    pub of_apart: usize,
    /// The strokes and their mode, ready to be applied: a line of a corrections file.
    pub correction: Correction,
}

/// What a person would call it.
pub(super) fn kind(sight: &Sight, map: &SlamMap) -> Kind {
    let [a, b] = [sight.a, sight.b].map(|look| placed(&look, map));
    let (along_m, across_m) = a.along_across(b.centre);
    let turn_rad = line_angle(b.direction_rad - a.direction_rad);
    let is_beside = along_m.abs() < a.half_length_m + b.half_length_m;
    let is_doubled = is_beside && across_m.abs() < DOUBLED.0 && turn_rad.abs() < DOUBLED.1;
    if is_doubled { Kind::DoubledWall } else { Kind::Visits }
}

fn placed(look: &Look, map: &SlamMap) -> Segment {
    let [p, q] = look.ends.map(|p| map.poses[look.pose].transform_point(p));
    Segment::from_ends(p, q)
}

/// Why a fault of the chain is one.
pub(super) fn of_fault(fault: &Fault, map: &SlamMap) -> String {
    let Fault { i, j, sigmas, inliers, .. } = *fault;
    let off = fault.i_from_j().between(map.poses[i].between(map.poses[j]));
    let (m, degrees) = (off.translation().norm(), off.theta_rad.to_degrees().abs());
    let [matched, standing] = inliers.map(|share| 100.0 * share);
    let what = if j - i == 1 { "torn between" } else { "bent from" };
    let path_m: f64 =
        map.poses[i..=j].windows(2).map(|w| (w[1].translation() - w[0].translation()).norm()).sum();
    let way = if j - i == 1 { String::new() } else { format!(" over {path_m:.1} m") };
    format!(
        "the chain is {what} poses {i} and {j}{way}: its own scans put them {degrees:.1}° and {m:.2} m elsewhere, {sigmas:.0} σ \
         ({matched:.0} % of the points fit there, {standing:.0} % as it stands)"
    )
}

/// Why two visits should be related.
pub(super) fn of_visits(kind: Kind, sight: &Sight, apart_m: f64, sigmas: f64, map: &SlamMap) -> String {
    let [i, j] = [sight.a.pose, sight.b.pose];
    let later = match &map.stamps_s {
        Some(stamps) => format!("{:.0} s later", (stamps[j] - stamps[i]).abs()),
        None => format!("{} poses later", j.abs_diff(i)),
    };
    let [a, b] = [sight.a, sight.b].map(|look| placed(&look, map));
    let degrees = line_angle(b.direction_rad - a.direction_rad).to_degrees().abs();
    let what = match kind {
        Kind::DoubledWall => "one wall stands there twice",
        _ => "two visits of one place lie apart",
    };
    format!(
        "{what}: pose {i}, and pose {j} {later}; {apart_m:.2} m and {degrees:.1}° apart, {sigmas:.1} σ of the chain between"
    )
}
