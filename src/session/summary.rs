//! What a person wants to know at the end: how much was done, and in how much time.

use super::{Solved, State};

/// Longer pauses are not work.
const LONGEST_PAUSE_S: u64 = 300;

/// A session in numbers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Summary {
    /// Corrections that are applied.
    pub corrections: usize,
    /// Corrections that are switched off or cannot be applied.
    pub idle: usize,
    /// Events in the file.
    pub events: usize,
    /// Time from the first event to the last, pauses of more than five minutes left out.
    pub minutes: f64,
    /// The largest offset that is left, metres.
    pub worst_offset_m: Option<f64>,
    /// How far the pose that moved most has moved, metres.
    pub moved_m: f64,
}

impl Summary {
    pub(super) fn new(times_s: &[u64], state: &State, solved: &Solved) -> Summary {
        let gaps =
            times_s.windows(2).map(|w| w[1].saturating_sub(w[0])).filter(|&gap| gap <= LONGEST_PAUSE_S);
        let corrections = solved.reports().filter(|r| r.accepted()).count();
        let standings = solved.corrector().standings();
        let moved = solved.source().poses.iter().zip(&solved.corrector().map().poses);
        Summary {
            corrections,
            idle: state.corrections.len() - corrections,
            events: times_s.len(),
            minutes: gaps.sum::<u64>() as f64 / 60.0,
            worst_offset_m: standings.iter().filter_map(|s| s.offset_m).max_by(f64::total_cmp),
            moved_m: moved.map(|(p, q)| (p.translation() - q.translation()).norm()).fold(0.0, f64::max),
        }
    }
}
