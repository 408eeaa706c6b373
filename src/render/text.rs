//! Letters: glyph outlines and widths from an embedded subset of DejaVu Sans (font/LICENSE).
//!
//! Printable ASCII and a few symbols; any other character is drawn as the font's empty box. No kerning.

use std::sync::OnceLock;

use tiny_skia::PathBuilder;
use ttf_parser::{Face, OutlineBuilder};

static FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");

fn face() -> Option<&'static Face<'static>> {
    static FACE: OnceLock<Option<Face<'static>>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(FONT, 0).ok()).as_ref()
}

/// Width of a line of text at a font size, both in pixels.
pub fn text_width_px(text: &str, size_px: f32) -> f32 {
    let Some(face) = face() else { return 0.0 };
    let units: u32 = text.chars().map(|c| u32::from(advance(face, c))).sum();
    units as f32 * size_px / f32::from(face.units_per_em())
}

/// Appends the outlines of `text`; (x, y) is the start of its base line. `upwards` turns it a quarter
/// counter-clockwise about that point.
pub fn outline(builder: &mut PathBuilder, text: &str, [x, y]: [f32; 2], size: f32, upwards: bool) {
    let Some(face) = face() else { return };
    let scale = size / f32::from(face.units_per_em());
    let mut pen = Pen { builder, origin: [x, y], scale, along: 0.0, upwards };
    for c in text.chars() {
        face.outline_glyph(face.glyph_index(c).unwrap_or_default(), &mut pen);
        pen.along += f32::from(advance(face, c)) * scale;
    }
}

fn advance(face: &Face, c: char) -> u16 {
    face.glyph_hor_advance(face.glyph_index(c).unwrap_or_default()).unwrap_or(0)
}

struct Pen<'a> {
    builder: &'a mut PathBuilder,
    origin: [f32; 2],
    scale: f32,
    along: f32,
    upwards: bool,
}

impl Pen<'_> {
    /// Font units (y up) to pixels (y down).
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        let (right, up) = (self.along + x * self.scale, y * self.scale);
        let [x0, y0] = self.origin;
        if self.upwards { (x0 - up, y0 - right) } else { (x0 + right, y0 - up) }
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}
