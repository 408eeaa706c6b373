//! A walk: the steps of one walker as its dead reckoning (PDR) measured them.
//!
//! Frames: a step's displacement is in the walker's heading frame *before* the step, then the heading changes by
//! `turn_rad`. A track has one pose more than the walk has steps: the start.

use crate::geometry::{Pose2, Vec2};

/// From this pause on a walker is said to stand still, seconds (the paper's ground-truth points are marked so).
pub const STANDSTILL_S: f64 = 2.0;
/// Nobody takes longer steps, metres; longer ones mean that some are missing.
pub const LONGEST_STEP_M: f64 = 5.0;
/// Steps shorter than this and without a turn are no motion, metres.
const NO_MOTION_M: f64 = 1e-9;

/// One measured step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// End of the step, seconds.
    pub time_s: f64,
    /// Displacement ahead, metres.
    pub forward_m: f64,
    /// Displacement to the left, metres.
    pub left_m: f64,
    /// Change of heading after the displacement, radians.
    pub turn_rad: f64,
}

impl Step {
    /// Length of the displacement, metres.
    pub fn length_m(&self) -> f64 {
        self.forward_m.hypot(self.left_m)
    }

    /// True if nothing moved.
    pub fn is_standing(&self) -> bool {
        self.length_m() < NO_MOTION_M && self.turn_rad == 0.0
    }
}

/// A walker's steps in time order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Walk {
    /// Unique among the walks of a run.
    pub name: String,
    /// The steps.
    pub steps: Vec<Step>,
}

/// A pause of at least [`STANDSTILL_S`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standstill {
    /// When it began, seconds.
    pub from_s: f64,
    /// When it ended, seconds.
    pub to_s: f64,
    /// Steps taken before it.
    pub steps_before: usize,
}

/// Where a walker truly was.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthPoint {
    /// Name of the walker.
    pub walker: String,
    /// When, seconds.
    pub stamp_s: f64,
    /// World position, metres.
    pub position: Vec2,
}

impl Walk {
    /// Dead reckoning from `start`: the start and the pose after each step.
    pub fn track(&self, start: Pose2) -> Vec<Pose2> {
        let mut poses = vec![start];
        let mut pose = start;
        for step in &self.steps {
            pose = pose.compose(Pose2::new(step.forward_m, step.left_m, step.turn_rad));
            poses.push(pose);
        }
        poses
    }

    /// The walk with all lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Walk {
        let scale = |s: &Step| Step { forward_m: s.forward_m * factor, left_m: s.left_m * factor, ..*s };
        Walk { name: self.name.clone(), steps: self.steps.iter().map(scale).collect() }
    }

    /// The walk without a heading drift of so much per metre.
    pub fn turned_back(&self, drift_rad_per_m: f64) -> Walk {
        let turn = |s: &Step| Step { turn_rad: s.turn_rad - drift_rad_per_m * s.length_m(), ..*s };
        Walk { name: self.name.clone(), steps: self.steps.iter().map(turn).collect() }
    }

    /// Path length after each step, metres.
    pub fn lengths_m(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let add = |step: &Step| {
            sum += step.length_m();
            sum
        };
        self.steps.iter().map(add).collect()
    }

    /// How many steps it takes to have walked `length_m` (to a millimetre); all of them if the walk is shorter.
    pub fn steps_to_length(&self, length_m: f64) -> usize {
        let lengths = self.lengths_m();
        lengths.iter().position(|&l| l >= length_m - 1e-3).map_or(self.steps.len(), |k| k + 1)
    }

    /// How many steps had ended by `time_s` after the first one began.
    pub fn steps_to_time(&self, time_s: f64) -> usize {
        let Some(first) = self.steps.first() else { return 0 };
        let start_s = first.time_s - self.typical_step_s();
        self.steps.iter().take_while(|s| s.time_s <= start_s + time_s + 1e-9).count()
    }

    /// Median time from one step to the next, seconds; 0.6 where there are fewer than two steps.
    pub fn typical_step_s(&self) -> f64 {
        let mut gaps: Vec<f64> = self.steps.windows(2).map(|w| w[1].time_s - w[0].time_s).collect();
        gaps.sort_unstable_by(f64::total_cmp);
        gaps.get(gaps.len() / 2).copied().unwrap_or(0.6)
    }

    /// Median length of the steps that moved, metres; 0.7 where there is none.
    pub fn typical_length_m(&self) -> f64 {
        let mut lengths: Vec<f64> = self.steps.iter().map(Step::length_m).filter(|&l| l > 0.05).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        lengths.get(lengths.len() / 2).copied().unwrap_or(0.7)
    }

    /// Every pause of at least [`STANDSTILL_S`]: longer between two steps than a step takes, or steps without motion.
    pub fn standstills(&self) -> Vec<Standstill> {
        let typical_s = self.typical_step_s();
        let mut found: Vec<Standstill> = Vec::new();
        let mut standing_since = None;
        for (k, step) in self.steps.iter().enumerate() {
            let before_s = if k == 0 { step.time_s - typical_s } else { self.steps[k - 1].time_s };
            let since = standing_since.unwrap_or((before_s, k));
            if step.is_standing() {
                standing_since = Some(since);
                if k + 1 == self.steps.len() && step.time_s - since.0 >= STANDSTILL_S {
                    found.push(Standstill { from_s: since.0, to_s: step.time_s, steps_before: since.1 });
                }
                continue;
            }
            let to_s = step.time_s - typical_s.min(step.time_s - before_s);
            if to_s - since.0 >= STANDSTILL_S {
                found.push(Standstill { from_s: since.0, to_s, steps_before: since.1 });
            }
            standing_since = None;
        }
        found
    }

    /// Where on a track (index of a pose and share of the way to the next) the walker is at a time. A step takes the
    /// walk's typical time and ends at its stamp; in a longer gap the walker stands first.
    pub fn place_at(&self, time_s: f64) -> (usize, f64) {
        let next = self.steps.partition_point(|s| s.time_s < time_s);
        let Some(step) = self.steps.get(next) else { return (self.steps.len(), 0.0) };
        let mut takes_s = self.typical_step_s();
        if next > 0 {
            takes_s = takes_s.min(step.time_s - self.steps[next - 1].time_s);
        }
        if takes_s <= 0.0 {
            return (next + 1, 0.0);
        }
        (next, (1.0 - (step.time_s - time_s) / takes_s).max(0.0))
    }

    /// Interpolates positions of a track (one more than steps) at a time.
    pub fn position_at(&self, track: &[Vec2], time_s: f64) -> Option<Vec2> {
        let (k, share) = self.place_at(time_s);
        let here = *track.get(k.min(track.len().checked_sub(1)?))?;
        let next = track.get(k + 1).copied().unwrap_or(here);
        Some(here + (next - here) * share)
    }
}
