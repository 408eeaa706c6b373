//! What re-association did, as data.

/// What one round did.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Round {
    /// Pairs of places compared.
    pub pairs: usize,
    /// Of those, accepted as factors.
    pub accepted: usize,
    /// Of those, in disagreement with the map afterwards.
    pub disagreeing: usize,
    /// Largest move of a pose, metres.
    pub moved_m: f64,
    /// Largest half-width of a search, metres: three standard deviations of what the chain knew.
    pub widest_m: f64,
}

/// Two visits that come near each other and were not matched.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct NearPass {
    /// Pose of the earlier visit.
    pub i: usize,
    /// Pose of the later visit.
    pub j: usize,
    /// Distance of the two poses as the map now stands, metres.
    pub distance_m: f64,
    /// Largest share of points that any place of the search could explain; too small for a match. They may show different
    /// rooms, or the same one too far off.
    pub inliers: f64,
}

/// What re-association did. The factors themselves are in the map.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Report {
    /// Every round.
    pub rounds: Vec<Round>,
    /// Where visits pass each other unmatched, nearest first; one for each pair of visits.
    pub near_passes: Vec<NearPass>,
    /// True: so many of the matches contradicted each other that none was kept.
    pub withdrawn: bool,
    /// True: the map is one of walks, whose footprints are no walls, so nothing was compared.
    pub footprints: bool,
}
