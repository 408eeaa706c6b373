//! Pictures of maps in the look of the paper's figures: points orange, poses as small black arrows, the poses and
//! segments of human factors in colour on top, equal axes, y up, a scale bar.
//!
//! Layout, top to bottom: title, the map's frame (with coordinates in its margins if there is a grid), scale bar and
//! legend. All sizes on screen are multiples of one unit, a thousandth of the picture's size.

use super::errors::{self, PlacedErrors};
use super::heat::{self, Heat};
use super::map_layers::{self as layers, Link, Overlay};
use super::scene::{Anchor, Colour, Item, Picture, PixelRect};
use super::text::text_width_px;
use super::uncertainty;
use super::viewport::{Viewport, WorldRect};
use crate::geometry::Segment;
use crate::map::{AutomaticFactor, SlamMap};

/// How to draw a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPictureOptions {
    /// Longer side of the map's frame, pixels; brought into 120..=7,000. Letters and lines grow with it.
    pub size_px: u32,
    /// A line above the map.
    pub title: Option<String>,
    /// Grid lines with metre coordinates, for writing strokes in world coordinates.
    pub with_grid: bool,
    /// Show only this part of the world.
    pub crop: Option<WorldRect>,
    /// Segments to draw on top.
    pub overlays: Vec<Overlay>,
    /// Cells to colour; the strokes and their legend are then left out.
    pub heat: Option<Heat>,
    /// Errors to draw along the trajectory instead of poses and automatic factors; the legend is theirs.
    pub errors: Option<PlacedErrors>,
    /// An ellipse around every pose: its position covariance (xx, xy, yy), m², world axes. Strokes' legend gives way to theirs.
    pub position_covariances: Option<Vec<[f64; 3]>>,
}

impl Default for MapPictureOptions {
    fn default() -> Self {
        MapPictureOptions {
            size_px: 1200,
            title: None,
            with_grid: false,
            crop: None,
            overlays: Vec::new(),
            heat: None,
            errors: None,
            position_covariances: None,
        }
    }
}

/// A picture of one map.
pub fn map(map: &SlamMap, options: &MapPictureOptions) -> Picture {
    let world = options.crop.unwrap_or_else(|| WorldRect::around(map));
    let panel = Panel {
        map,
        title: options.title.as_deref().unwrap_or(""),
        highlighted: highlighted(map),
        strokes: if options.heat.is_some() || options.errors.is_some() {
            Vec::new()
        } else {
            own_strokes(map)
        },
        overlays: &options.overlays,
        heat: options.heat.as_ref(),
        errors: options.errors.as_ref(),
        covariances: options.position_covariances.as_deref(),
    };
    let layout = Layout::new(&world, options, 1.0, !panel.title.is_empty());
    let mut picture = Picture::new(layout.width as u32, layout.height as u32);
    draw(&mut picture, &panel, &world, &layout, [0.0, 0.0]);
    picture
}

/// Two states of a map at one scale, side by side (one above the other where the map is more than twice as wide as
/// high). Human factors that only `after` has are shown in `before` where its poses put their points. Overlays are
/// drawn in `before`: that is the map they were drawn on.
pub fn before_after(before: &SlamMap, after: &SlamMap, options: &MapPictureOptions) -> Picture {
    let world = options.crop.unwrap_or_else(|| WorldRect::around(before).union(&WorldRect::around(after)));
    let prefix = options.title.as_ref().map(|t| format!("{t} · ")).unwrap_or_default();
    let same_points = before.observations.starts == after.observations.starts;
    let left = Panel {
        map: before,
        title: &format!("{prefix}before"),
        highlighted: if same_points { highlighted(after) } else { highlighted(before) },
        strokes: if same_points { strokes_before(before, after) } else { own_strokes(before) },
        overlays: &options.overlays,
        heat: None,
        errors: None,
        covariances: None,
    };
    let corrections = after.human_factors.len().saturating_sub(before.human_factors.len());
    let count = match corrections {
        0 => String::new(),
        1 => " · 1 correction".into(),
        n => format!(" · {n} corrections"),
    };
    let right = Panel {
        map: after,
        title: &format!("{prefix}after{count}"),
        highlighted: highlighted(after),
        strokes: own_strokes(after),
        overlays: &[],
        heat: None,
        errors: None,
        covariances: None,
    };
    let layout = Layout::new(&world, options, 1.3, true);
    let stacked = layout.frame.width > 2.0 * layout.frame.height;
    let shift = if stacked { [0.0, layout.height] } else { [layout.width, 0.0] };
    let mut picture = Picture::new((layout.width + shift[0]) as u32, (layout.height + shift[1]) as u32);
    draw(&mut picture, &left, &world, &layout, [0.0, 0.0]);
    draw(&mut picture, &right, &world, &layout, shift);
    picture
}

/// One map within a picture.
struct Panel<'a> {
    map: &'a SlamMap,
    title: &'a str,
    highlighted: Vec<usize>,
    strokes: Vec<(Segment, Segment)>,
    overlays: &'a [Overlay],
    heat: Option<&'a Heat>,
    errors: Option<&'a PlacedErrors>,
    covariances: Option<&'a [[f64; 3]]>,
}

/// The automatic factors of a map.
fn links(map: &SlamMap) -> Vec<Link> {
    let link = |a: &AutomaticFactor| Link {
        ends: [a.factor.i, a.factor.j].map(|pose| map.poses[pose].translation()),
        agrees: !a.disagrees(),
    };
    map.automatic_factors.iter().map(link).collect()
}

/// Poses of any human factor, ascending, in range.
fn highlighted(map: &SlamMap) -> Vec<usize> {
    let features = map.human_factors.iter().flat_map(|h| [&h.a, &h.b]);
    let mut poses: Vec<usize> = features.flat_map(|f| f.sightings.iter().map(|s| s.pose)).collect();
    poses.sort_unstable();
    poses.dedup();
    poses
}

fn own_strokes(map: &SlamMap) -> Vec<(Segment, Segment)> {
    map.human_factors.iter().map(|h| (h.a.segment, h.b.segment)).collect()
}

/// The strokes of `after` as the poses of `before` see them; those that `before` has already, as it has them.
fn strokes_before(before: &SlamMap, after: &SlamMap) -> Vec<(Segment, Segment)> {
    let stroke = |h: &crate::map::HumanFactor| match before.human_factors.iter().find(|b| b.id == h.id) {
        Some(own) => Some((own.a.segment, own.b.segment)),
        None => Some((layers::refit(&h.a, before)?, layers::refit(&h.b, before)?)),
    };
    after.human_factors.iter().filter_map(stroke).collect()
}

/// Where things go in a panel, pixels.
struct Layout {
    unit: f32,
    with_grid: bool,
    frame: PixelRect,
    width: f32,
    height: f32,
}

impl Layout {
    fn new(world: &WorldRect, options: &MapPictureOptions, letters: f32, titled: bool) -> Self {
        let side = options.size_px.clamp(120, 7000) as f32;
        let unit = letters * (side / 1000.0).max(0.4);
        let size = world.size();
        let scale = f64::from(side) / size.max();
        let least = 130.0 * unit; // room for the legend beside a very long or high map
        let frame_width = ((size.x * scale) as f32).max(least.min(side)).round();
        let frame_height = ((size.y * scale) as f32).max(least.min(side)).round();
        let margin = (14.0 * unit).round();
        let (mut left, mut right) = (margin, margin);
        if options.with_grid {
            let frame = PixelRect { left: 0.0, top: 0.0, width: frame_width, height: frame_height };
            for label in layers::grid(&Viewport::fit(world, frame), unit).1 {
                match label {
                    Item::Text { text, size, anchor: Anchor::End, .. } => {
                        left = left.max((text_width_px(&text, size) + 16.0 * unit).round());
                    }
                    Item::Text { text, size, at, .. } => {
                        let reach = at[0] + text_width_px(&text, size) / 2.0 - frame_width;
                        right = right.max((reach + 5.0 * unit).round());
                    }
                    _ => {}
                }
            }
        }
        let top = if titled { (44.0 * unit).round() } else { margin };
        let below = if options.with_grid { 70.0 } else { 46.0 } * unit;
        let frame = PixelRect { left, top, width: frame_width, height: frame_height };
        Layout {
            unit,
            with_grid: options.with_grid,
            frame,
            width: (frame.right() + right).round(),
            height: (frame.bottom() + below).round(),
        }
    }
}

fn draw(picture: &mut Picture, panel: &Panel, world: &WorldRect, layout: &Layout, [x, y]: [f32; 2]) {
    let unit = layout.unit;
    let frame = PixelRect { left: layout.frame.left + x, top: layout.frame.top + y, ..layout.frame };
    let view = Viewport::fit(world, frame);

    let mut inside = Vec::new();
    let mut around = Vec::new();
    if layout.with_grid {
        let (lines, labels) = layers::grid(&view, unit);
        inside.extend(lines);
        around.extend(labels);
    }
    inside.push(layers::points(panel.map, &view, unit));
    if let Some(heat) = panel.heat {
        inside.extend(heat::cells(heat, &view, unit));
    } else if let Some(placed) = panel.errors {
        inside.extend(errors::dots(placed, &view, unit));
    } else {
        inside.extend(layers::poses(panel.map, &panel.highlighted, &view, unit));
        inside.extend(layers::automatic_factors(&links(panel.map), &view, unit));
    }
    if let Some(covariances) = panel.covariances {
        inside.extend(uncertainty::ellipses(panel.map, covariances, &view, unit));
    }
    inside.extend(layers::human_factors(&panel.strokes, &view, unit));
    inside.extend(layers::overlays(panel.overlays, &view, unit));
    let edge = PixelRect { left: frame.left + 0.5, top: frame.top + 0.5, ..frame };
    around.push(Item::line(edge.outline(), 1.0, Colour::LIGHT));
    if !panel.title.is_empty() {
        let at = [frame.left, frame.top - 14.0 * unit];
        around.push(Item::text(at, panel.title, 22.0 * unit, Anchor::Start, Colour::INK));
    }
    let base = y + layout.height - 18.0 * unit;
    let (bar, bar_end) = layers::scale_bar(&view, [frame.left + 2.0, base], unit);
    around.extend(bar);
    if panel.heat.is_some() {
        around.extend(heat::legend(frame.right(), base, unit));
    } else if let Some(placed) = panel.errors {
        around.extend(errors::legend(placed, frame.right(), base, unit));
    } else if let Some(covariances) = panel.covariances {
        around.extend(uncertainty::legend(covariances, frame.right(), base, unit));
    } else {
        around.extend(legend(panel, frame.right(), base, bar_end + 20.0 * unit, unit));
    }
    picture.push(Some(frame), inside);
    picture.push(None, around);
}

/// What the colours mean, right-aligned; left out where it would run into the scale bar.
fn legend(panel: &Panel, right: f32, base: f32, left_limit: f32, unit: f32) -> Vec<Item> {
    let size = 14.0 * unit;
    let mut entries = Vec::new();
    let is_drawn = |colour| panel.overlays.iter().any(|o| o.colour == colour);
    if !panel.strokes.is_empty() {
        entries.extend([
            ("their poses", Colour::BLUE, 0.0),
            ("stroke b", Colour::BLUE, 3.4),
            ("stroke a", Colour::RED, 7.0),
        ]);
    } else if is_drawn(Colour::RED) && is_drawn(Colour::BLUE) {
        entries.extend([("stroke b", Colour::BLUE, 5.0), ("stroke a", Colour::RED, 5.0)]);
    }
    let automatic = &panel.map.automatic_factors;
    if automatic.iter().any(AutomaticFactor::disagrees) {
        entries.push(("disagrees", Colour::PURPLE, 4.0));
    }
    if !automatic.is_empty() {
        entries.push(("matched by itself", Colour::GREEN, 1.8));
    }
    let mut items = Vec::new();
    let mut pen = right;
    for (text, colour, width) in entries {
        let text_left = pen - text_width_px(text, size);
        let mark_left = text_left - 32.0 * unit;
        let middle = base - 5.0 * unit;
        items.push(Item::text([text_left, base], text, size, Anchor::Start, Colour::GREY));
        if width > 0.0 {
            let ends = vec![[mark_left + 5.0 * unit, middle], [text_left - 9.0 * unit, middle]];
            items.push(Item::line(ends, width * unit, colour));
        } else {
            let at = [text_left - 13.0 * unit, middle];
            items.push(Item::Shapes { outlines: vec![layers::dart(at, 0.0, unit)], colour });
        }
        pen = mark_left - 10.0 * unit;
    }
    if pen < left_limit { Vec::new() } else { items }
}
