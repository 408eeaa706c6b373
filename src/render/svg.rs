//! A [`Picture`] as SVG text.
//!
//! Dots are reduced to the picture's pixel grid first: pixels of like density become horizontal runs of one
//! `<path>`, so two million points take no more room than the pixels they touch. Text stays text.

use std::fmt::Write;

use super::density::{Density, density};
use super::scene::{Anchor, Colour, Item, Picture, PixelPoint, PixelRect};

/// Width of the white edge around letters, as a share of the font size (on both sides together).
pub const HALO_SHARE: f32 = 0.28;
/// Densities are drawn in this many steps of opacity.
const DENSITY_STEPS: u8 = 4;

/// The file's text.
pub fn encode(picture: &Picture) -> String {
    let (width, height) = (picture.width(), picture.height());
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans, sans-serif\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (index, layer) in picture.layers.iter().enumerate() {
        if let Some(PixelRect { left, top, width, height }) = layer.clip {
            append(
                &mut out,
                format_args!(
                    "<clipPath id=\"clip{index}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n\
                     <g clip-path=\"url(#clip{index})\">\n",
                    round(left),
                    round(top),
                    round(width),
                    round(height)
                ),
            );
        }
        for item in &layer.items {
            draw(&mut out, item, picture.area_of(layer));
        }
        if layer.clip.is_some() {
            out.push_str("</g>\n");
        }
    }
    out.push_str("</svg>\n");
    out
}

fn draw(out: &mut String, item: &Item, area: PixelRect) {
    match item {
        Item::Dots { points, side, colour } => {
            let density = density(points, *side, area);
            for step in 1..=DENSITY_STEPS {
                draw_density_step(out, &density, step, *colour);
            }
        }
        Item::Line { points, width, colour, dashed } => {
            out.push_str("<path d=\"");
            path(out, points);
            append(
                out,
                format_args!(
                    "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"",
                    hex(*colour),
                    round(*width)
                ),
            );
            opacity(out, "stroke-opacity", *colour);
            if *dashed {
                append(out, format_args!(" stroke-dasharray=\"{}\"", round(3.0 * width)));
            }
            out.push_str(" stroke-linecap=\"round\" stroke-linejoin=\"round\"/>\n");
        }
        Item::Shapes { outlines, colour } => {
            out.push_str("<path d=\"");
            for outline in outlines {
                path(out, outline);
                out.push('Z');
            }
            append(out, format_args!("\" fill=\"{}\"", hex(*colour)));
            opacity(out, "fill-opacity", *colour);
            out.push_str("/>\n");
        }
        Item::Text { at: [x, y], text, size, anchor, colour, halo, upwards } => {
            let (x, y) = (round(*x), round(*y));
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            append(
                out,
                format_args!(
                    "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"",
                    round(*size),
                    hex(*colour)
                ),
            );
            opacity(out, "fill-opacity", *colour);
            if *halo {
                let width = round(HALO_SHARE * size);
                append(
                    out,
                    format_args!(
                        " stroke=\"#fff\" stroke-width=\"{width}\" stroke-linejoin=\"round\" paint-order=\"stroke\""
                    ),
                );
            }
            if *upwards {
                append(out, format_args!(" transform=\"rotate(-90 {x} {y})\""));
            }
            out.push('>');
            escape(out, text);
            out.push_str("</text>\n");
        }
    }
}

/// The pixels whose opacity rounds to `step` of [`DENSITY_STEPS`], as one path of horizontal runs.
fn draw_density_step(out: &mut String, density: &Density, step: u8, colour: Colour) {
    let step_of = |opacity: u8| (u32::from(opacity) * u32::from(DENSITY_STEPS) + 127) / 255;
    let share = f32::from(step) / f32::from(DENSITY_STEPS) * f32::from(colour.opacity) / 255.0;
    let mut d = String::new();
    for (row, opacities) in density.opacity.chunks(density.width.max(1)).enumerate() {
        let mut end_of_last = None;
        let mut column = 0;
        while column < opacities.len() {
            let begin = column;
            while column < opacities.len() && step_of(opacities[column]) == u32::from(step) {
                column += 1;
            }
            if column == begin {
                column += 1;
                continue;
            }
            match end_of_last {
                None => append(&mut d, format_args!("M{} {}", density.left + begin, density.top + row)),
                Some(end) => append(&mut d, format_args!("m{} 0", begin - end)),
            }
            append(&mut d, format_args!("h{}", column - begin));
            end_of_last = Some(column);
        }
    }
    if !d.is_empty() {
        append(
            out,
            format_args!(
                "<path transform=\"translate(0 .5)\" shape-rendering=\"crispEdges\" fill=\"none\" stroke=\"{}\" \
                 stroke-opacity=\"{}\" d=\"{d}\"/>\n",
                hex(colour),
                round(share)
            ),
        );
    }
}

fn path(out: &mut String, points: &[PixelPoint]) {
    for (k, &[x, y]) in points.iter().enumerate() {
        let verb = if k == 0 { 'M' } else { 'L' };
        append(out, format_args!("{verb}{} {}", round(x), round(y)));
    }
}

fn hex(colour: Colour) -> String {
    format!("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue)
}

fn opacity(out: &mut String, attribute: &str, colour: Colour) {
    if colour.opacity < 255 {
        append(out, format_args!(" {attribute}=\"{}\"", round(f32::from(colour.opacity) / 255.0)));
    }
}

/// Hundredths of a pixel are enough.
fn round(value: f32) -> f32 {
    let rounded = (value * 100.0).round() / 100.0;
    if rounded == 0.0 { 0.0 } else { rounded } // no "-0"
}

fn escape(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
}

fn append(out: &mut String, arguments: std::fmt::Arguments) {
    let _ = out.write_fmt(arguments); // writing to a String cannot fail
}
