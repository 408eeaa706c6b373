//! Several pictures as one.

use super::scene::{Item, Layer, Picture, PixelPoint, PixelRect};

/// The pictures in rows of `columns` (1 at least), each in a cell of the largest one's size, from the top left.
pub fn tiled(pictures: &[Picture], columns: usize) -> Picture {
    let columns = columns.clamp(1, pictures.len().max(1));
    let width = pictures.iter().map(Picture::width).max().unwrap_or(1);
    let height = pictures.iter().map(Picture::height).max().unwrap_or(1);
    let rows = pictures.len().div_ceil(columns).max(1);
    let mut all = Picture::new(width * columns as u32, height * rows as u32);
    for (k, picture) in pictures.iter().enumerate() {
        let by = [(k % columns) as f32 * width as f32, (k / columns) as f32 * height as f32];
        for layer in &picture.layers {
            all.layers.push(moved(layer, by));
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
