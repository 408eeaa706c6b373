//! How certain poses are: an ellipse around each, as far as there is room.

use super::map_layers::Spacing;
use super::scene::{Anchor, Colour, Item, PixelPoint};
use super::text::text_width_px;
use super::viewport::Viewport;
use crate::map::SlamMap;

/// Half-axes in standard deviations.
const SIGMAS: f64 = 1.0;
const COLOUR: Colour = Colour::rgb(0x7A3FB5);
/// Corners of an ellipse.
const CORNERS: u32 = 48;

/// One ellipse per pose (`position_covariances`: xx, xy, yy, m², world axes), thinned out where they are dense. Where
/// one would be smaller than a dot there is none.
pub fn ellipses(map: &SlamMap, position_covariances: &[[f64; 3]], view: &Viewport, unit: f32) -> Vec<Item> {
    let mut spacing = Spacing::new(view.frame, 20.0 * unit);
    let mut items = Vec::new();
    for (pose, &[xx, xy, yy]) in map.poses.iter().zip(position_covariances) {
        let centre = view.pixel(pose.translation());
        // Half-axes: the roots of the eigenvalues; the first along `angle`.
        let (middle, radius) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
        let angle = (2.0 * xy).atan2(xx - yy) / 2.0;
        let half_axis = |variance: f64| (SIGMAS * variance.max(0.0).sqrt() * view.scale) as f32;
        let (a, b) = (half_axis(middle + radius), half_axis(middle - radius));
        let seen = a >= 0.75 && a.is_finite();
        if !seen || !spacing.take(centre) {
            continue;
        }
        let (s, c) = (angle.sin() as f32, angle.cos() as f32);
        let corner = |k: u32| -> PixelPoint {
            let (y, x) = (k as f32 * std::f32::consts::TAU / CORNERS as f32).sin_cos();
            let (x, y) = (a * x, b * y);
            [centre[0] + c * x - s * y, centre[1] - s * x - c * y]
        };
        items.push(Item::line((0..=CORNERS).map(corner).collect(), (1.1 * unit).max(0.8), COLOUR));
    }
    items
}

/// What they mean, right-aligned on a base line, with the numbers that a picture cannot give.
pub fn legend(position_covariances: &[[f64; 3]], right: f32, base: f32, unit: f32) -> Vec<Item> {
    let mut sigmas: Vec<f64> = position_covariances
        .iter()
        .map(|&[xx, xy, yy]| ((xx + yy) / 2.0 + ((xx - yy) / 2.0).hypot(xy)).max(0.0).sqrt())
        .collect();
    sigmas.sort_by(f64::total_cmp);
    let (Some(worst), size) = (sigmas.last(), 14.0 * unit) else { return Vec::new() };
    let text =
        format!("1σ of a pose's position: median {:.3} m, worst {worst:.3} m", sigmas[sigmas.len() / 2]);
    let left = right - text_width_px(&text, size);
    let at = [left - 14.0 * unit, base - 5.0 * unit];
    let ring = (0..=CORNERS).map(|k| {
        let (y, x) = (k as f32 * std::f32::consts::TAU / CORNERS as f32).sin_cos();
        [at[0] + 8.0 * unit * x, at[1] + 5.0 * unit * y]
    });
    vec![
        Item::line(ring.collect(), (1.1 * unit).max(0.8), COLOUR),
        Item::text([left, base], text, size, Anchor::Start, Colour::GREY),
    ]
}
