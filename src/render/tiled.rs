//! Several pictures as one.

use super::scene::{Item, Layer, Picture, PixelPoint, PixelRect};

/// The pictures in rows of `columns` (1 at least), from the top left; a row is as high as its highest picture, a column
/// as wide as its widest.
pub fn tiled(pictures: &[Picture], columns: usize) -> Picture {
    let columns = columns.clamp(1, pictures.len().max(1));
    let largest = |sizes: &mut dyn Iterator<Item = u32>| sizes.max().unwrap_or(1);
    let widths: Vec<u32> = (0..columns)
        .map(|c| largest(&mut pictures.iter().skip(c).step_by(columns).map(Picture::width)))
        .collect();
    let heights: Vec<u32> =
        pictures.chunks(columns).map(|row| largest(&mut row.iter().map(Picture::height))).collect();
    let mut all = Picture::new(widths.iter().sum::<u32>().max(1), heights.iter().sum::<u32>().max(1));
    for (k, picture) in pictures.iter().enumerate() {
        let by = [widths[..k % columns].iter().sum::<u32>(), heights[..k / columns].iter().sum::<u32>()];
        for layer in &picture.layers {
            all.layers.push(moved(layer, by.map(|v| v as f32)));
        }
    }
    all
}

fn moved(layer: &Layer, [x, y]: PixelPoint) -> Layer {
    let clip = layer.clip.map(|c| PixelRect { left: c.left + x, top: c.top + y, ..c });
    let shift = |p: &PixelPoint| [p[0] + x, p[1] + y];
    let items = layer.items.iter().map(|item| match item.clone() {
        Item::Dots { points, side, colour } => {
            Item::Dots { points: points.iter().map(shift).collect(), side, colour }
        }
        Item::Line { points, width, colour, dashed } => {
            Item::Line { points: points.iter().map(shift).collect(), width, colour, dashed }
        }
        Item::Shapes { outlines, colour } => {
            let outlines = outlines.iter().map(|o| o.iter().map(shift).collect()).collect();
            Item::Shapes { outlines, colour }
        }
        Item::Text { at, text, size, anchor, colour, halo, upwards } => {
            Item::Text { at: shift(&at), text, size, anchor, colour, halo, upwards }
        }
    });
    Layer { clip, items: items.collect() }
}
