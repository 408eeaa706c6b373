//! Where visits come near each other and nothing matched: where the next stroke may be needed.

use super::SHORTEST_LOOP_M;
use super::candidates::Candidate;
use super::matching::Outcome;
use super::report::NearPass;
use crate::map::SlamMap;
use crate::scan_match::reach_m;

/// Pairs that were compared in vain, nearest first as the map now stands, without those beside a good match or a nearer pass.
pub(super) fn find(map: &SlamMap, compared: &[(Candidate, Outcome)]) -> Vec<NearPass> {
    let path_m = map.path_lengths_m();
    let beside = |(i, j): (usize, usize), (k, l): (usize, usize)| {
        (path_m[i] - path_m[k]).abs() < SHORTEST_LOOP_M && (path_m[j] - path_m[l]).abs() < SHORTEST_LOOP_M
    };
    let agreeing = map.automatic_factors.iter().filter(|a| !a.disagrees());
    let mut taken: Vec<(usize, usize)> = agreeing.map(|a| (a.factor.i, a.factor.j)).collect();
    let mut open: Vec<(f64, &Candidate, f64)> = compared
        .iter()
        .filter_map(|(c, outcome)| match outcome {
            Outcome::TooFewInliers(inliers) => Some((reach_m(map.poses[c.i], map.poses[c.j]), c, *inliers)),
            Outcome::Accepted(_) => None,
        })
        .collect();
    open.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1.j, a.1.i).cmp(&(b.1.j, b.1.i))));
    let mut passes = Vec::new();
    for (_, &Candidate { i, j, .. }, inliers) in open {
        if taken.iter().any(|&t| beside((i, j), t)) {
            continue;
        }
        taken.push((i, j));
        let distance_m = (map.poses[j].translation() - map.poses[i].translation()).norm();
        passes.push(NearPass { i, j, distance_m, inliers });
    }
    passes
}
