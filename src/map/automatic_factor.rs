//! A loop closure that the program found by itself, and what spoke for it.

use super::RelativeFactor;

/// χ², 3 degrees of freedom, from which on a factor disagrees.
const DISAGREES_CHI2: f64 = 16.0;

/// A match between two visits of one place. Never for ever: every re-association finds all of them anew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AutomaticFactor {
    /// Pose j (later) as matched from pose i (earlier), and how sure that is. Optimised under a bounded loss.
    pub factor: RelativeFactor,
    /// Share of the later visit's points that fit a wall of the earlier one, 0 to 1.
    pub inliers: f64,
    /// Score of the second-best place of the search over that of the best: near 1 the match could be elsewhere.
    pub ambiguity: f64,
    /// Direction along which the match said nothing (a corridor) and its information was taken out, radians in
    /// (−π/2, π/2], in the frame of pose i; `None`: it held all round.
    pub weak_rad: Option<f64>,
    /// eᵀΩe after the last solve: large where it disagrees with the rest of the map.
    pub chi2: f64,
}

impl AutomaticFactor {
    /// Its name: the two poses, `i-j`. No two factors of a map have the same.
    pub fn name(&self) -> String {
        format!("{}-{}", self.factor.i, self.factor.j)
    }

    /// The two poses of a name; `None`: it is none.
    pub fn poses_of(name: &str) -> Option<(usize, usize)> {
        let (i, j) = name.split_once('-')?;
        Some((i.parse().ok()?, j.parse().ok()?))
    }

    /// True if it disagrees with the rest of the map: more than four standard deviations off.
    pub fn disagrees(&self) -> bool {
        self.chi2 > DISAGREES_CHI2
    }
}
