//! Stage 2: the paper wants every pose of X_a before every pose of X_b. Real selections overlap and interleave, so the
//! two sets are split at the chain index that keeps the most support for "one before the other".

use super::Caught;

/// Where the chain is cut between two features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// True if the stroke drawn second comes first along the chain.
    pub swapped: bool,
    /// Last pose of the earlier feature that is before the cut, if any.
    pub last_of_a: Option<usize>,
    /// First pose of the later feature that is after the cut, if any.
    pub first_of_b: Option<usize>,
}

/// Splits two features. The result does not depend on which of them is called `a`.
pub fn split(a: &Caught, b: &Caught) -> Split {
    let (forward, forward_cut) = best_cut(&a.poses, &b.poses);
    let (backward, backward_cut) = best_cut(&b.poses, &a.poses);
    // Equal support both ways (say, the same poses under both strokes): by content, never by order of drawing.
    let tie_break = || mean_pose(a).total_cmp(&mean_pose(b)).then_with(|| a.points.cmp(&b.points)).is_gt();
    let swapped = backward > forward || (backward == forward && tie_break());
    let (first, second, cut) = if swapped { (b, a, backward_cut) } else { (a, b, forward_cut) };
    Split {
        swapped,
        last_of_a: first.poses.iter().map(|p| p.0).filter(|&p| p < cut).max(),
        first_of_b: second.poses.iter().map(|p| p.0).filter(|&p| p >= cut).min(),
    }
}

/// The cut k that keeps the most points of `first` before k and of `second` at or after it: (support, k).
fn best_cut(first: &[(usize, usize)], second: &[(usize, usize)]) -> (usize, usize) {
    let mut changes: Vec<(usize, i64)> = Vec::with_capacity(first.len() + second.len());
    changes.extend(first.iter().map(|&(pose, count)| (pose, count as i64)));
    changes.extend(second.iter().map(|&(pose, count)| (pose, -(count as i64))));
    changes.sort_unstable();
    let mut support: i64 = second.iter().map(|p| p.1 as i64).sum();
    let mut best = (support, 0);
    for group in changes.chunk_by(|x, y| x.0 == y.0) {
        support += group.iter().map(|c| c.1).sum::<i64>();
        if support > best.0 {
            best = (support, group[0].0 + 1);
        }
    }
    (best.0.max(0) as usize, best.1)
}

fn mean_pose(caught: &Caught) -> f64 {
    let total: usize = caught.poses.iter().map(|p| p.1).sum();
    caught.poses.iter().map(|&(pose, count)| (pose * count) as f64).sum::<f64>() / total.max(1) as f64
}
