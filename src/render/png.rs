//! A [`Picture`] as PNG: tiny-skia fills paths, dots go through [`super::density`], text through [`super::text`].

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash,
    Transform,
};

use super::density::density;
use super::scene::{Anchor, Colour, Item, Picture, PixelPoint, PixelRect};
use super::text;

/// The file's bytes. A `Picture` has between 1 and 16,384 pixels a side, so allocation and encoding to memory succeed.
pub fn encode(picture: &Picture) -> Vec<u8> {
    let Some(mut pixmap) = Pixmap::new(picture.width(), picture.height()) else { return Vec::new() };
    pixmap.fill(Color::WHITE);
    for layer in &picture.layers {
        let mask = layer.clip.and_then(|clip| mask(picture, clip));
        let area = picture.area_of(layer);
        for item in &layer.items {
            draw(&mut pixmap, item, mask.as_ref(), area);
        }
    }
    compress(&pixmap).unwrap_or_default()
}

/// Opaque on white: three channels say everything.
fn compress(pixmap: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let rgb: Vec<u8> = pixmap.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixmap.width(), pixmap.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

fn mask(picture: &Picture, clip: PixelRect) -> Option<Mask> {
    let mut mask = Mask::new(picture.width(), picture.height())?;
    let rect = Rect::from_xywh(clip.left, clip.top, clip.width, clip.height)?;
    mask.fill_path(&PathBuilder::from_rect(rect), FillRule::Winding, false, Transform::identity());
    Some(mask)
}

fn draw(pixmap: &mut Pixmap, item: &Item, mask: Option<&Mask>, area: PixelRect) {
    match item {
        Item::Dots { points, side, colour } => draw_dots(pixmap, points, *side, *colour, area),
        Item::Line { points, width, colour, dashed } => {
            let dash = if *dashed { StrokeDash::new(vec![3.0 * width, 3.0 * width], 0.0) } else { None };
            if let Some(path) = path(std::slice::from_ref(points), false) {
                let stroke = Stroke { dash, ..round_stroke(*width) };
                pixmap.stroke_path(&path, &paint(*colour), &stroke, Transform::identity(), mask);
            }
        }
        Item::Shapes { outlines, colour } => {
            if let Some(path) = path(outlines, true) {
                fill(pixmap, &path, *colour, mask);
            }
        }
        Item::Text { at: [x, y], text, size, anchor, colour, halo, upwards } => {
            let width = text::text_width_px(text, *size);
            let back = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => width / 2.0,
                Anchor::End => width,
            };
            let start = if *upwards { [*x, y + back] } else { [x - back, *y] };
            let mut builder = PathBuilder::new();
            text::outline(&mut builder, text, start, *size, *upwards);
            let Some(path) = builder.finish() else { return };
            if *halo {
                let edge = round_stroke(super::svg::HALO_SHARE * size);
                pixmap.stroke_path(&path, &paint(Colour::WHITE), &edge, Transform::identity(), mask);
            }
            fill(pixmap, &path, *colour, mask);
        }
    }
}

fn fill(pixmap: &mut Pixmap, path: &Path, colour: Colour, mask: Option<&Mask>) {
    pixmap.fill_path(path, &paint(colour), FillRule::Winding, Transform::identity(), mask);
}

fn paint(colour: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(colour.red, colour.green, colour.blue, colour.opacity);
    paint
}

fn round_stroke(width: f32) -> Stroke {
    Stroke { width, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() }
}

fn path(outlines: &[Vec<PixelPoint>], close: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for outline in outlines {
        for (k, &[x, y]) in outline.iter().enumerate() {
            if k == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
        }
        if close {
            builder.close();
        }
    }
    builder.finish()
}

/// Blends the dots' density over the (opaque) picture.
fn draw_dots(pixmap: &mut Pixmap, points: &[PixelPoint], side: f32, colour: Colour, area: PixelRect) {
    let density = density(points, side, area);
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let data = pixmap.data_mut();
    for row in 0..density.height.min(height.saturating_sub(density.top)) {
        for column in 0..density.width.min(width.saturating_sub(density.left)) {
            let opacity = u32::from(density.opacity[row * density.width + column]);
            if opacity == 0 {
                continue;
            }
            let opacity = opacity * u32::from(colour.opacity) / 255;
            let at = 4 * ((density.top + row) * width + density.left + column);
            for (channel, ink) in [colour.red, colour.green, colour.blue].into_iter().enumerate() {
                let below = u32::from(data[at + channel]);
                data[at + channel] = ((below * (255 - opacity) + u32::from(ink) * opacity + 127) / 255) as u8;
            }
        }
    }
}
