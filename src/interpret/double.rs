//! Does a stroke lie on two walls at once? Then its segment lies between them, and is nobody's wall.

/// Share of the variance that the split into two must explain: 0.64 for one Gaussian wall, 0.75 for a uniform band.
const EXPLAINED: f64 = 0.83;
/// Walls closer than this are one, metres: less than what a laser's noise makes of one wall.
const NEAREST_M: f64 = 0.04;
/// Each of the two has at least this share of the points.
const SMALLER_SHARE: f64 = 0.15;

/// How far two walls are apart, if a stroke's points are of two rather than of one (Otsu's criterion, 1979).
/// `across_m`: the points' distances from the segment, signed.
pub fn two_walls(across_m: &[f64]) -> Option<f64> {
    let mut sorted = across_m.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / n;
    let total = sorted.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n;
    let mut below = 0.0;
    let mut best = (0.0, 0.0);
    for (k, d) in sorted.iter().enumerate() {
        let share = k as f64 / n;
        if (SMALLER_SHARE..=1.0 - SMALLER_SHARE).contains(&share) {
            let apart = (mean * n - below) / (n - k as f64) - below / k as f64;
            let between = share * (1.0 - share) * apart * apart;
            if between > best.0 {
                best = (between, apart);
            }
        }
        below += d;
    }
    (best.0 > EXPLAINED * total && best.1 >= NEAREST_M).then_some(best.1)
}
