//! The rigid motion that takes one set of points onto another with least squares: SE(2), no scale.
//!
//! Umeyama, "Least-squares estimation of transformation parameters between two point patterns", PAMI 1991, eqs.
//! 40–41 with scale 1. In the plane its SVD has a closed form: with centred points p, q the sum Σ‖q − R(θ)p‖² is
//! least at θ = atan2(Σ p × q, Σ p · q); the translation takes one centroid to the other.

use crate::geometry::{Pose2, Vec2};

/// `to_from_from`: minimises Σ‖to_k − T·from_k‖² over the pairs. Where the pairs don't fix a rotation (one pair, or
/// all points in one place) the rotation is zero; without any pair it is the identity.
pub fn align(pairs: &[(Vec2, Vec2)]) -> Pose2 {
    if pairs.is_empty() {
        return Pose2::IDENTITY;
    }
    let n = pairs.len() as f64;
    let from_mean = pairs.iter().map(|(p, _)| p).sum::<Vec2>() / n;
    let to_mean = pairs.iter().map(|(_, q)| q).sum::<Vec2>() / n;
    let (mut dot, mut cross) = (0.0, 0.0);
    let (mut from_spread, mut to_spread) = (0.0, 0.0);
    for (from, to) in pairs {
        let (p, q) = (from - from_mean, to - to_mean);
        dot += p.dot(&q);
        cross += p.perp(&q);
        from_spread += p.norm_squared();
        to_spread += q.norm_squared();
    }
    // Centred coordinates carry rounding errors of about ε × the centroid's size: below that there is no direction.
    let noise = |mean: Vec2, spread: f64| spread <= n * (16.0 * f64::EPSILON * mean.norm()).powi(2);
    let undetermined = noise(from_mean, from_spread) || noise(to_mean, to_spread);
    let theta_rad = if undetermined { 0.0 } else { cross.atan2(dot) };
    let rotation = Pose2::new(0.0, 0.0, theta_rad);
    let translation = to_mean - rotation.rotate(from_mean);
    Pose2::new(translation.x, translation.y, theta_rad)
}
