//! Where a map contradicts itself: cells coloured by how often.

use super::scene::{Anchor, Colour, Item, PixelPoint, PixelRect};
use super::text::text_width_px;
use super::viewport::Viewport;
use crate::geometry::Vec2;

/// Counts on square cells of the world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Heat {
    /// Side of a cell, metres.
    pub side_m: f64,
    /// Middle of a cell, world frame, and its count.
    pub cells: Vec<(Vec2, u64)>,
}

/// From how many contradictions on a cell has which colour.
const SCALE: [(u64, Colour); 4] = [
    (1, Colour::rgb(0x9CC9F0)),
    (10, Colour::rgb(0x3F7FD9)),
    (30, Colour::rgb(0x8A1FB5)),
    (100, Colour::rgb(0xD7191C)),
];

/// The cells, hot ones on top and never smaller than two pixels.
pub fn cells(heat: &Heat, view: &Viewport, unit: f32) -> Vec<Item> {
    let side = ((heat.side_m * view.scale) as f32).max(2.0);
    let layer = |k: usize| {
        let (from, colour) = SCALE[k];
        let to = SCALE.get(k + 1).map_or(u64::MAX, |next| next.0);
        let wanted = heat.cells.iter().filter(|c| (from..to).contains(&c.1));
        let places = wanted.map(|c| view.pixel(c.0)).filter(|&p| view.frame.contains(p, 2.0 * unit));
        let square = |[x, y]: PixelPoint| {
            PixelRect { left: x - side / 2.0, top: y - side / 2.0, width: side, height: side }.outline()
        };
        Item::Shapes { outlines: places.map(square).collect(), colour }
    };
    (0..SCALE.len()).map(layer).collect()
}

/// What the colours mean, right-aligned on a base line.
pub fn legend(right: f32, base: f32, unit: f32) -> Vec<Item> {
    let size = 14.0 * unit;
    let mut items = Vec::new();
    let mut pen = right;
    for (from, colour) in SCALE.into_iter().rev() {
        let text = format!("{from}+");
        pen -= text_width_px(&text, size);
        items.push(Item::text([pen, base], text, size, Anchor::Start, Colour::GREY));
        pen -= 18.0 * unit;
        let mark = PixelRect { left: pen, top: base - 11.0 * unit, width: 13.0 * unit, height: 13.0 * unit };
        items.push(Item::rect(mark, colour));
        pen -= 12.0 * unit;
    }
    items.push(Item::text([pen, base], "contradictions on a cell", size, Anchor::End, Colour::GREY));
    items
}
