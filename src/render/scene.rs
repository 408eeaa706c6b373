//! The display list: what a picture consists of, in pixels, x to the right and y **down**.
//!
//! A [`Picture`] is a stack of layers, each with an optional clip; a layer is a list of primitives. Both back ends
//! ([`super::png`], [`super::svg`]) draw exactly this list, so the two formats cannot drift apart.

/// A point of the picture, pixels from the top left corner.
pub type PixelPoint = [f32; 2];

/// A colour with opacity, 8 bit sRGB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour {
    /// Red, 0..=255.
    pub red: u8,
    /// Green, 0..=255.
    pub green: u8,
    /// Blue, 0..=255.
    pub blue: u8,
    /// 255 is opaque.
    pub opacity: u8,
}

impl Colour {
    /// Paper.
    pub const WHITE: Colour = Colour::rgb(0xFFFFFF);
    /// Titles, poses, axes.
    pub const INK: Colour = Colour::rgb(0x1C1C1C);
    /// Labels.
    pub const GREY: Colour = Colour::rgb(0x666666);
    /// Grid lines and frames.
    pub const LIGHT: Colour = Colour::rgb(0xDDDDDD);
    /// What the laser saw.
    pub const ORANGE: Colour = Colour::rgb(0xE07B12);
    /// First feature of a human factor.
    pub const RED: Colour = Colour::rgb(0xD7191C);
    /// Second feature of a human factor, and the poses that belong to one.
    pub const BLUE: Colour = Colour::rgb(0x1F55C8);
    /// A fourth distinct colour for plots.
    pub const GREEN: Colour = Colour::rgb(0x1A8F5A);
    /// A fifth distinct colour for plots.
    pub const PURPLE: Colour = Colour::rgb(0x7B3FA0);

    /// A sixth distinct colour for plots.
    pub const BROWN: Colour = Colour::rgb(0x6B4A2B);

    /// The order in which plots hand out colours.
    pub const CYCLE: [Colour; 6] =
        [Colour::BLUE, Colour::ORANGE, Colour::GREEN, Colour::RED, Colour::PURPLE, Colour::BROWN];

    /// An opaque colour from 0xRRGGBB.
    pub const fn rgb(hex: u32) -> Self {
        Colour { red: (hex >> 16) as u8, green: (hex >> 8) as u8, blue: hex as u8, opacity: 255 }
    }

    /// The same colour with another opacity, 255 being opaque.
    pub const fn with_opacity(self, opacity: u8) -> Self {
        Colour { opacity, ..self }
    }
}

/// An upright rectangle of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRect {
    /// Left edge, pixels.
    pub left: f32,
    /// Top edge, pixels.
    pub top: f32,
    /// Pixels.
    pub width: f32,
    /// Pixels.
    pub height: f32,
}

impl PixelRect {
    /// Right edge, pixels.
    pub fn right(&self) -> f32 {
        self.left + self.width
    }

    /// Bottom edge, pixels.
    pub fn bottom(&self) -> f32 {
        self.top + self.height
    }

    /// The closed outline, clockwise from the top left.
    pub fn outline(&self) -> Vec<PixelPoint> {
        let (l, t, r, b) = (self.left, self.top, self.right(), self.bottom());
        vec![[l, t], [r, t], [r, b], [l, b], [l, t]]
    }

    /// True if the point lies in the rectangle grown by `margin` on every side.
    pub fn contains(&self, [x, y]: PixelPoint, margin: f32) -> bool {
        x >= self.left - margin
            && x <= self.right() + margin
            && y >= self.top - margin
            && y <= self.bottom() + margin
    }
}

/// Which part of a text sits at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text is centred there.
    Middle,
    /// The text ends there.
    End,
}

/// A primitive.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Item {
    /// Points by the million, drawn as a density: the more of them in a pixel, the stronger the colour.
    Dots {
        /// Positions.
        points: Vec<PixelPoint>,
        /// Side of a dot, pixels.
        side: f32,
        /// Colour where points are dense.
        colour: Colour,
    },
    /// A polyline with round caps and joins.
    Line {
        /// Corners.
        points: Vec<PixelPoint>,
        /// Width, pixels.
        width: f32,
        /// Colour.
        colour: Colour,
        /// Drawn in dashes of three widths.
        dashed: bool,
    },
    /// Filled polygons of one colour (non-zero winding).
    Shapes {
        /// One list of corners per polygon; closed by itself.
        outlines: Vec<Vec<PixelPoint>>,
        /// Colour.
        colour: Colour,
    },
    /// A line of text; the position is on its base line.
    Text {
        /// Position on the base line.
        at: PixelPoint,
        /// The words.
        text: String,
        /// Font size (em), pixels.
        size: f32,
        /// Which part of the text sits at `at`.
        anchor: Anchor,
        /// Colour.
        colour: Colour,
        /// White edge around the letters, for text on top of a map.
        halo: bool,
        /// Reads upwards (a quarter turn counter-clockwise).
        upwards: bool,
    },
}

impl Item {
    /// A solid polyline.
    pub fn line(points: Vec<PixelPoint>, width: f32, colour: Colour) -> Self {
        Item::Line { points, width, colour, dashed: false }
    }

    /// A horizontal text without halo.
    pub fn text(at: PixelPoint, text: impl Into<String>, size: f32, anchor: Anchor, colour: Colour) -> Self {
        Item::Text { at, text: text.into(), size, anchor, colour, halo: false, upwards: false }
    }

    /// A filled disc.
    pub fn disc([x, y]: PixelPoint, radius: f32, colour: Colour) -> Self {
        let corner = |k: u32| {
            let (s, c) = (k as f32 * std::f32::consts::TAU / 20.0).sin_cos();
            [x + radius * c, y + radius * s]
        };
        Item::Shapes { outlines: vec![(0..20).map(corner).collect()], colour }
    }

    /// A filled upright rectangle.
    pub fn rect(rect: PixelRect, colour: Colour) -> Self {
        Item::Shapes { outlines: vec![rect.outline()], colour }
    }
}

/// Primitives that share a clip, drawn in order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layer {
    /// Nothing is drawn outside; `None`: the whole picture.
    pub clip: Option<PixelRect>,
    /// Later items cover earlier ones.
    pub items: Vec<Item>,
}

/// A finished picture on white.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    width: u32,
    height: u32,
    /// Later layers cover earlier ones.
    pub layers: Vec<Layer>,
}

impl Picture {
    /// Largest width or height, pixels.
    pub const MAX_SIDE: u32 = 16_384;

    /// An empty picture; sides are brought into 1..=[`Picture::MAX_SIDE`] pixels.
    pub fn new(width: u32, height: u32) -> Self {
        let side = |s: u32| s.clamp(1, Picture::MAX_SIDE);
        Picture { width: side(width), height: side(height), layers: Vec::new() }
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The whole area.
    pub fn area(&self) -> PixelRect {
        PixelRect { left: 0.0, top: 0.0, width: self.width as f32, height: self.height as f32 }
    }

    /// The part of the picture that a layer may draw on.
    pub fn area_of(&self, layer: &Layer) -> PixelRect {
        let Some(clip) = layer.clip else { return self.area() };
        let (left, top) = (clip.left.max(0.0), clip.top.max(0.0));
        let width = (clip.right().min(self.width as f32) - left).max(0.0);
        let height = (clip.bottom().min(self.height as f32) - top).max(0.0);
        PixelRect { left, top, width, height }
    }

    /// Puts items on top, cut off outside `clip` if there is one.
    pub fn push(&mut self, clip: Option<PixelRect>, items: Vec<Item>) {
        self.layers.push(Layer { clip, items });
    }

    /// The picture as a PNG file, 8 bit RGB.
    pub fn to_png(&self) -> Vec<u8> {
        super::png::encode(self)
    }

    /// The picture as an SVG file.
    pub fn to_svg(&self) -> String {
        super::svg::encode(self)
    }
}
