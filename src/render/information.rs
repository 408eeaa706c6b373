//! The information matrix of a map (the paper's Fig. 5): which poses a factor ties to which.
//!
//! One row and one column per pose, the first at the top left. White: the relative factors, a band along the diagonal and
//! the closures off it, those found without a person in yellow-green. In colour, by mode: what human factors add between the poses of X_a and those of X_b once the
//! segments are eliminated.

use super::scene::{Anchor, Colour, Item, Picture, PixelRect};
use super::text::text_width_px;
use crate::map::{Feature, Mode, SlamMap};

/// Poses at most this far apart are drawn as one run: a pose in between that saw too little of a wall is no gap.
const RUN_GAP: usize = 3;
/// No mark is smaller than this, thousandths of the side.
const LEAST_MARK: f32 = 5.0;

/// The colour of automatic factors.
const AUTOMATIC: Colour = Colour::rgb(0xB8E04A);

/// The colour of a mode.
pub fn mode_colour(mode: Mode) -> Colour {
    match mode {
        Mode::Colocation => Colour::rgb(0x3D8BFF),
        Mode::Collinear => Colour::rgb(0xE83FC8),
        Mode::Perpendicular => Colour::rgb(0x2FC46B),
        Mode::Parallel => Colour::rgb(0xF2A01E),
    }
}

/// A picture of the matrix, its side `size_px` (brought into 120..=7,000) without the margins.
pub fn information(map: &SlamMap, size_px: u32, title: Option<&str>) -> Picture {
    let side = size_px.clamp(120, 7000) as f32;
    let unit = side / 1000.0;
    let (left, top) = (70.0 * unit, if title.is_some() { 70.0 } else { 40.0 } * unit);
    let frame = PixelRect { left, top, width: side, height: side };
    let mut picture = Picture::new((side + 95.0 * unit) as u32, (top + side + 130.0 * unit) as u32);
    let scale = side / map.poses.len().max(1) as f32;
    let least = LEAST_MARK * unit;
    // The block of poses rows × columns, grown about its middle where it could not be seen.
    let block = |rows: [usize; 2], columns: [usize; 2]| {
        let span = |[from, to]: [usize; 2], start: f32| {
            let (length, middle) = ((to - from + 1) as f32 * scale, (from + to + 1) as f32 / 2.0 * scale);
            (start + middle - length.max(least) / 2.0, length.max(least))
        };
        let ((y, height), (x, width)) = (span(rows, top), span(columns, left));
        PixelRect { left: x, top: y, width, height }.outline()
    };
    let mut band = Vec::new();
    for factor in &map.relative_factors {
        let (i, j) = (factor.i.min(factor.j), factor.i.max(factor.j));
        if j == i + 1 {
            band.push(block([i, j], [i, j]));
        } else {
            band.extend([block([i, i], [j, j]), block([j, j], [i, i])]);
        }
    }
    let mut inside = vec![Item::rect(frame, Colour::INK)];
    let mut present = Vec::new();
    for factor in &map.human_factors {
        let mut outlines = Vec::new();
        for a in runs(&factor.a) {
            for b in runs(&factor.b) {
                outlines.extend([block(a, b), block(b, a)]);
            }
        }
        inside.push(Item::Shapes { outlines, colour: mode_colour(factor.mode) });
        present.push(factor.mode);
    }
    inside.push(Item::Shapes { outlines: band, colour: Colour::WHITE });
    let found = map.automatic_factors.iter().map(|a| (a.factor.i, a.factor.j));
    let outlines = found.flat_map(|(i, j)| [block([i, i], [j, j]), block([j, j], [i, i])]).collect();
    inside.push(Item::Shapes { outlines, colour: AUTOMATIC });
    picture.push(Some(frame), inside);
    picture.push(None, labels(map, &present, frame, unit, title));
    picture
}

/// Runs of poses of X, first and last.
fn runs(feature: &Feature) -> Vec<[usize; 2]> {
    let poses: Vec<usize> = feature.sightings.iter().map(|s| s.pose).collect();
    let runs = poses.chunk_by(|a, b| b - a <= RUN_GAP);
    runs.map(|run| [run[0], run[run.len() - 1]]).collect()
}

fn labels(map: &SlamMap, present: &[Mode], frame: PixelRect, unit: f32, title: Option<&str>) -> Vec<Item> {
    let size = 22.0 * unit;
    let (right, bottom) = (frame.right(), frame.bottom());
    let last = map.poses.len().saturating_sub(1).to_string();
    let mut items = vec![
        Item::text([frame.left - 8.0 * unit, frame.top + size], "0", size, Anchor::End, Colour::INK),
        Item::text([frame.left - 8.0 * unit, bottom], last.clone(), size, Anchor::End, Colour::INK),
        Item::text([frame.left, frame.top - 10.0 * unit], "0", size, Anchor::Start, Colour::INK),
        Item::text(
            [(frame.left + right) / 2.0, frame.top - 10.0 * unit],
            "pose",
            size,
            Anchor::Middle,
            Colour::GREY,
        ),
        Item::text([right, frame.top - 10.0 * unit], last, size, Anchor::End, Colour::INK),
    ];
    if let Some(title) = title {
        let at = [frame.left, frame.top - 44.0 * unit];
        items.push(Item::text(at, title, 26.0 * unit, Anchor::Start, Colour::INK));
    }
    let mut entries = vec![("relative factors".to_owned(), Colour::WHITE)];
    if !map.automatic_factors.is_empty() {
        entries.push((format!("matched by itself ×{}", map.automatic_factors.len()), AUTOMATIC));
    }
    for mode in Mode::ALL {
        match present.iter().filter(|&&m| m == mode).count() {
            0 => {}
            1 => entries.push((mode.name().into(), mode_colour(mode))),
            n => entries.push((format!("{} ×{n}", mode.name()), mode_colour(mode))),
        }
    }
    let (mut x, mut y) = (frame.left, bottom + 40.0 * unit);
    for (text, colour) in entries {
        let width = 34.0 * unit + text_width_px(&text, size);
        if x + width > right {
            (x, y) = (frame.left, y + 34.0 * unit);
        }
        let mark = PixelRect { left: x, top: y - 18.0 * unit, width: 20.0 * unit, height: 20.0 * unit };
        items.push(Item::rect(mark, colour));
        items.push(Item::line(mark.outline(), unit.max(1.0), Colour::INK));
        items.push(Item::text([x + 28.0 * unit, y], text, size, Anchor::Start, Colour::INK));
        x += width + 26.0 * unit;
    }
    items
}
