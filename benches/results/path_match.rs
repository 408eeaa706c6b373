//! How far a path is from its truth where the two have no clock in common: matched in order along the way.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::metrics::align;

/// Rounds of matching and aligning.
const ROUNDS: usize = 6;

/// A path laid on its truth.
pub struct Match {
    /// Index of the truth's pose for each of the path's.
    pub truth_of: Vec<usize>,
    /// Distance to it after the best SE(2) alignment, metres.
    pub distances_m: Vec<f64>,
}

impl Match {
    pub fn rmse_m(&self) -> f64 {
        let sum: f64 = self.distances_m.iter().map(|d| d * d).sum();
        (sum / self.distances_m.len() as f64).sqrt()
    }

    pub fn largest_m(&self) -> f64 {
        self.distances_m.iter().copied().fold(0.0, f64::max)
    }
}

/// Matches both paths from start to end so that the sum of squared distances is least, no step going back (dynamic time
/// warping), and aligns them, in turns.
pub fn path_match(path: &[Pose2], truth: &[Pose2]) -> Match {
    let positions = |poses: &[Pose2]| -> Vec<Vec2> { poses.iter().map(|p| p.translation()).collect() };
    let (path, truth) = (positions(path), positions(truth));
    let mut truth_of = by_length(&path, &truth);
    let mut distances_m = Vec::new();
    for round in 0..ROUNDS {
        let pairs: Vec<(Vec2, Vec2)> = path.iter().zip(&truth_of).map(|(p, &t)| (*p, truth[t])).collect();
        let aligned = align(&pairs);
        let moved: Vec<Vec2> = path.iter().map(|p| aligned.transform_point(*p)).collect();
        if round + 1 < ROUNDS {
            truth_of = warped(&moved, &truth);
        }
        distances_m = moved.iter().zip(&truth_of).map(|(p, &t)| (p - truth[t]).norm()).collect();
    }
    Match { truth_of, distances_m }
}

/// The same share of the whole way.
fn by_length(path: &[Vec2], truth: &[Vec2]) -> Vec<usize> {
    let shares = |points: &[Vec2]| -> Vec<f64> {
        let mut way = vec![0.0];
        for pair in points.windows(2) {
            way.push(way[way.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let whole = way[way.len() - 1];
        way.iter().map(|w| w / whole).collect()
    };
    let of_truth = shares(truth);
    let place = |share: f64| of_truth.partition_point(|&t| t < share).min(truth.len() - 1);
    shares(path).into_iter().map(place).collect()
}

/// For each point of the path the nearest of those that the best warping gives it.
fn warped(path: &[Vec2], truth: &[Vec2]) -> Vec<usize> {
    let columns = truth.len();
    let distance = |row: usize, column: usize| (path[row] - truth[column]).norm_squared();
    // Where the best way to a cell comes from: 0 left, 1 above, 2 both.
    let mut from = vec![0_u8; path.len() * columns];
    let mut above = vec![f64::INFINITY; columns];
    for row in 0..path.len() {
        let mut here = vec![0.0; columns];
        for column in 0..columns {
            let left = if column > 0 { here[column - 1] } else { f64::INFINITY };
            let diagonal = if column > 0 { above[column - 1] } else { f64::INFINITY };
            let (best, direction) = [(left, 0), (above[column], 1), (diagonal, 2)]
                .into_iter()
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap_or((0.0, 0));
            here[column] = distance(row, column) + if row + column == 0 { 0.0 } else { best };
            from[row * columns + column] = direction;
        }
        above = here;
    }
    let mut nearest = vec![0; path.len()];
    let (mut row, mut column) = (path.len() - 1, columns - 1);
    nearest[row] = column;
    while row + column > 0 {
        match from[row * columns + column] {
            0 => column -= 1,
            1 => row -= 1,
            _ => (row, column) = (row - 1, column - 1),
        }
        if nearest[row] == 0 || distance(row, column) < distance(row, nearest[row]) {
            nearest[row] = column;
        }
    }
    nearest
}
