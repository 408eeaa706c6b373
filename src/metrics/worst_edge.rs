//! The relative factor that a map disagrees with most: shows a tear that an average would hide.

use crate::map::SlamMap;

/// The largest residuals among a map's relative factors; each may be of another factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstEdge {
    /// Largest translation residual, metres.
    pub translation_m: f64,
    /// Index of its factor.
    pub translation_factor: usize,
    /// Largest √(eᵀΩe), in standard deviations.
    pub sigma: f64,
    /// Index of its factor.
    pub sigma_factor: usize,
}

/// The worst of the map's relative factors at its poses; `None` if it has no factor.
pub fn worst_edge(map: &SlamMap) -> Option<WorstEdge> {
    let mut worst: Option<WorstEdge> = None;
    for (index, factor) in map.relative_factors.iter().enumerate() {
        let (world_from_i, world_from_j) = (map.poses[factor.i], map.poses[factor.j]);
        let [x, y, _] = factor.residual(world_from_i, world_from_j);
        let (translation_m, sigma) = (x.hypot(y), factor.chi2(world_from_i, world_from_j).max(0.0).sqrt());
        let first = WorstEdge { translation_m, translation_factor: index, sigma, sigma_factor: index };
        let so_far = worst.get_or_insert(first);
        if translation_m > so_far.translation_m {
            (so_far.translation_m, so_far.translation_factor) = (translation_m, index);
        }
        if sigma > so_far.sigma {
            (so_far.sigma, so_far.sigma_factor) = (sigma, index);
        }
    }
    worst
}
