//! Which stamps of one clock mean the same moment.
//!
//! Two stamps match if each is the other's nearest and they are no further apart than half the log's median scan period,
//! at most 50 ms: half a period because beyond it a neighbouring scan is meant, 50 ms because a robot at 1 m/s
//! and 1 rad/s is 5 cm and 3° away by then.

/// Bound of the tolerance, seconds.
const LARGEST_TOLERANCE_S: f64 = 0.05;

/// For every stamp of `wanted` the index of the log's scan that it means.
pub(super) fn scans_at(wanted_s: &[f64], log_s: &[f64]) -> Vec<Option<usize>> {
    // One stamp per scan, in the log's order: also right where stamps repeat.
    if wanted_s == log_s {
        return (0..log_s.len()).map(Some).collect();
    }
    let tolerance_s = tolerance_s(log_s);
    let (log, wanted) = (sorted(log_s), sorted(wanted_s));
    wanted_s
        .iter()
        .enumerate()
        .map(|(k, &stamp_s)| {
            let scan = nearest(&log, stamp_s)?;
            let is_close = (log_s[scan] - stamp_s).abs() <= tolerance_s;
            (is_close && nearest(&wanted, log_s[scan]) == Some(k)).then_some(scan)
        })
        .collect()
}

/// Half the median time between scans, at most 50 ms.
pub(super) fn tolerance_s(log_s: &[f64]) -> f64 {
    let sorted = sorted(log_s);
    let mut periods: Vec<f64> =
        sorted.windows(2).map(|w| w[1].0 - w[0].0).filter(|&period| period > 0.0).collect();
    if periods.is_empty() {
        return LARGEST_TOLERANCE_S;
    }
    let middle = periods.len() / 2;
    (*periods.select_nth_unstable_by(middle, f64::total_cmp).1 / 2.0).min(LARGEST_TOLERANCE_S)
}

fn sorted(stamps_s: &[f64]) -> Vec<(f64, usize)> {
    let mut sorted: Vec<(f64, usize)> = stamps_s.iter().copied().zip(0..).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    sorted
}

/// Index of the nearest stamp; of equal ones the first in the file.
fn nearest(sorted: &[(f64, usize)], stamp_s: f64) -> Option<usize> {
    let after = sorted.partition_point(|&(s, _)| s < stamp_s);
    let before = after.checked_sub(1).map(|last| {
        let value = sorted[last].0;
        sorted[sorted.partition_point(|&(s, _)| s < value)]
    });
    match (before, sorted.get(after)) {
        (Some(b), Some(a)) if stamp_s - b.0 <= a.0 - stamp_s => Some(b.1),
        (_, Some(a)) => Some(a.1),
        (b, None) => b.map(|b| b.1),
    }
}
