//! Whether the strokes of a correction caught the walls that they were drawn on.

use super::{CorrectionReport, Stroke};
use crate::geometry::{Segment, wrap_angle};
use crate::map;

/// A stroke was understood if it was snapped no farther than this: metres, radians.
const SNAPPED: (f64, f64) = (0.15, 0.2);
/// … and caught the pose that it was drawn from, or one so near in the chain.
const NEAR_POSES: usize = 2;
/// … and, where the chain is torn, no more than this share of poses from the other side of the tear.
const STRAY: f64 = 0.1;

impl CorrectionReport {
    /// True if both strokes of `correction`, of which this is the preview, were taken for the walls that they were drawn on. Where a
    /// map is torn its walls cross, and a stroke may snap to the wall of the other side; whoever sees which
    /// poses light up draws elsewhere. A correction with more than usual weight is taken for one across a tear. False for strokes
    /// that do not hang on poses.
    pub fn is_understood(&self, correction: &map::Correction) -> bool {
        let (map::Stroke::Pose { pose: i, .. }, map::Stroke::Pose { pose: j, .. }) =
            (correction.a, correction.b)
        else {
            return false;
        };
        let is_torn = correction.weight > 1.0;
        let meant = |stroke: &Stroke, own: usize, other: usize| {
            let Some(caught) = &stroke.caught else { return false };
            let drawn = Segment::from_ends(stroke.drawn[0], stroke.drawn[1]);
            let turn_rad = wrap_angle(2.0 * (caught.fit.segment.direction_rad - drawn.direction_rad)) / 2.0;
            let across_m = caught.fit.segment.along_across(drawn.centre).1;
            let beyond = |pose: usize| if own < other { pose >= other } else { pose <= other };
            let stray = caught.poses.iter().filter(|p| beyond(p.0)).count() as f64;
            across_m.abs() <= SNAPPED.0
                && turn_rad.abs() <= SNAPPED.1
                && caught.poses.iter().any(|p| p.0.abs_diff(own) <= NEAR_POSES)
                && (!is_torn || stray <= STRAY * caught.poses.len() as f64)
        };
        let [a, b] = &self.strokes[..] else { return false };
        meant(a, i, j) && meant(b, j, i)
    }
}
