//! Stage 2: the paper wants every pose of X_a before every pose of X_b. Real selections overlap and interleave, so the
//! two sets are split at the chain index that keeps the most support for "one before the other".

use super::Caught;
use super::feature::VISIT_GAP;

/// Supports closer than this share are as good as equal: the edges of a visit come and go with single points.
const UNDECIDED_SHARE: f64 = 0.9;

/// Where the chain is cut between two features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// True if the stroke drawn second comes first along the chain.
    pub swapped: bool,
    /// The cut: the earlier feature's own side is `..cut`, the later one's `cut..`.
    pub cut: usize,
    /// Last pose of the earlier feature that is before the cut, if any.
    pub last_of_a: Option<usize>,
    /// First pose of the later feature that is after the cut, if any.
    pub first_of_b: Option<usize>,
}

/// Splits two features. The result does not depend on which of them is called `a`. `anchors` are the poses that the
/// strokes were drawn from, where known: they decide where the points do not (the same visits lie under both strokes,
/// because their walls coincide across and are displaced along).
pub fn split(a: &Caught, b: &Caught, anchors: [Option<usize>; 2]) -> Split {
    let forward = best_cut(&a.poses, &b.poses);
    let backward = best_cut(&b.poses, &a.poses);
    let undecided = forward.support.min(backward.support) as f64
        >= UNDECIDED_SHARE * forward.support.max(backward.support) as f64;
    let swapped = match anchors {
        [Some(of_a), Some(of_b)] if undecided && of_a != of_b => of_a > of_b,
        _ if forward.support != backward.support => backward.support > forward.support,
        // By content, never by order of drawing.
        _ => mean_pose(a).total_cmp(&mean_pose(b)).then_with(|| a.points.cmp(&b.points)).is_gt(),
    };
    let (first, second, cut) = if swapped { (b, a, backward.cut) } else { (a, b, forward.cut) };
    Split {
        swapped,
        cut,
        last_of_a: first.poses.iter().map(|p| p.0).filter(|&p| p < cut).max(),
        first_of_b: second.poses.iter().map(|p| p.0).filter(|&p| p >= cut).min(),
    }
}

/// A cut of the chain, and how many points it keeps.
#[derive(Debug, Clone, Copy, Default)]
struct Cut {
    support: usize,
    cut: usize,
    /// Poses without any sighting around the cut; counts only between visits.
    gap: usize,
}

/// The cut k that keeps the most points of `first` before k and of `second` at or after it; of those that keep
/// nearly as many, the one in the widest gap between visits.
fn best_cut(first: &[(usize, usize)], second: &[(usize, usize)]) -> Cut {
    let mut changes: Vec<(usize, i64)> = Vec::with_capacity(first.len() + second.len());
    changes.extend(first.iter().map(|&(pose, count)| (pose, count as i64)));
    changes.extend(second.iter().map(|&(pose, count)| (pose, -(count as i64))));
    changes.sort_unstable();
    let mut support: i64 = second.iter().map(|p| p.1 as i64).sum();
    let mut cuts = vec![Cut { support: support.max(0) as usize, ..Cut::default() }];
    let groups: Vec<_> = changes.chunk_by(|x, y| x.0 == y.0).collect();
    for (k, group) in groups.iter().enumerate() {
        support += group.iter().map(|c| c.1).sum::<i64>();
        let gap = groups.get(k + 1).map_or(0, |next| next[0].0 - group[0].0);
        let gap = if gap > VISIT_GAP { gap } else { 0 };
        cuts.push(Cut { support: support.max(0) as usize, cut: group[0].0 + 1, gap });
    }
    let most = cuts.iter().map(|c| c.support).max().unwrap_or(0) as f64;
    let good = cuts.into_iter().filter(|c| c.support as f64 >= UNDECIDED_SHARE * most);
    good.max_by_key(|c| (c.gap, c.support, std::cmp::Reverse(c.cut))).unwrap_or_default()
}

fn mean_pose(caught: &Caught) -> f64 {
    let total: usize = caught.poses.iter().map(|p| p.1).sum();
    caught.poses.iter().map(|&(pose, count)| (pose * count) as f64).sum::<f64>() / total.max(1) as f64
}
