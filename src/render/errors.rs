//! Errors along a trajectory: dots coloured by size, large ones on top.

use super::scene::{Anchor, Colour, Item, PixelPoint, PixelRect};
use super::text::text_width_px;
use super::viewport::Viewport;
use crate::geometry::Vec2;

/// Errors of places on a map.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlacedErrors {
    /// What they are errors of: begins the legend.
    pub what: String,
    /// Where, world frame, and how large, metres.
    pub errors: Vec<(Vec2, f64)>,
}

/// Small to large; none is near the orange of the points.
const COLOURS: [Colour; 5] = [
    Colour::rgb(0x9CC9F0),
    Colour::rgb(0x3F7FD9),
    Colour::rgb(0x23307F),
    Colour::rgb(0x8A1FB5),
    Colour::rgb(0xD7191C),
];
/// The largest class begins above this share of the errors.
const BULK: f64 = 0.95;

/// The dots, small errors first, so that a large one is never hidden by them.
pub fn dots(placed: &PlacedErrors, view: &Viewport, unit: f32) -> Vec<Item> {
    let limits_m = limits_m(&placed.errors);
    let layer = |class: usize| {
        let wanted = placed.errors.iter().filter(|e| class_of(e.1, &limits_m) == class);
        let places = wanted.map(|e| view.pixel(e.0)).filter(|&p| view.frame.contains(p, 6.0 * unit));
        let radius = (2.6 + 0.5 * class as f32) * unit;
        Item::Shapes { outlines: places.map(|p| octagon(p, radius)).collect(), colour: COLOURS[class] }
    };
    (0..COLOURS.len()).map(layer).collect()
}

/// What the colours mean, right-aligned on a base line.
pub fn legend(placed: &PlacedErrors, right: f32, base: f32, unit: f32) -> Vec<Item> {
    let limits_m = limits_m(&placed.errors);
    let size = 14.0 * unit;
    let mut items = Vec::new();
    let mut pen = right;
    for class in (0..COLOURS.len()).rev() {
        let text = match class.checked_sub(1) {
            None => format!("< {}", number(limits_m[0])),
            Some(below) => format!("{}+", number(limits_m[below])),
        };
        pen -= text_width_px(&text, size);
        items.push(Item::text([pen, base], text, size, Anchor::Start, Colour::GREY));
        pen -= 18.0 * unit;
        let mark = PixelRect { left: pen, top: base - 11.0 * unit, width: 13.0 * unit, height: 13.0 * unit };
        items.push(Item::rect(mark, COLOURS[class]));
        pen -= 12.0 * unit;
    }
    let text = format!("{} (m)", placed.what);
    items.push(Item::text([pen, base], text, size, Anchor::End, Colour::GREY));
    items
}

/// Where the classes begin, metres: quarters of the first of 1, 2, 4 times a power of ten that is not below the bulk.
fn limits_m(errors: &[(Vec2, f64)]) -> [f64; 4] {
    let mut sizes_m: Vec<f64> = errors.iter().map(|e| e.1).filter(|e| e.is_finite()).collect();
    sizes_m.sort_unstable_by(f64::total_cmp);
    let last = sizes_m.len().saturating_sub(1);
    let bulk_m = sizes_m.get((last as f64 * BULK) as usize).copied().unwrap_or(0.0).max(1e-4);
    let decade = 10_f64.powf(bulk_m.log10().floor());
    let top_m =
        [1.0, 2.0, 4.0, 10.0].map(|k| k * decade).into_iter().find(|&t| t >= bulk_m).unwrap_or(bulk_m);
    [0.25, 0.5, 0.75, 1.0].map(|share| share * top_m)
}

fn class_of(error_m: f64, limits_m: &[f64; 4]) -> usize {
    limits_m.iter().filter(|&&limit| error_m >= limit).count()
}

/// As short as it can be said.
fn number(value_m: f64) -> String {
    let text = format!("{value_m:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn octagon([x, y]: PixelPoint, radius: f32) -> Vec<PixelPoint> {
    let corner = |k: u32| {
        let (s, c) = ((k as f32 + 0.5) * std::f32::consts::FRAC_PI_4).sin_cos();
        [x + radius * c, y + radius * s]
    };
    (0..8).map(corner).collect()
}
