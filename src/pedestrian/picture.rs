//! Pictures of pedestrian maps: hexagons shaded by their crossings, the plan, walkers' paths; the paper's figures 3 and 5.

use super::transition_map::TransitionMap;
use crate::geometry::{Segment, Vec2};
use crate::render::{Anchor, Colour, Item, Picture, PixelRect, Viewport, WorldRect};

/// Steps of grey: a hexagon's shade says how often its edges were crossed, on a logarithmic scale.
const SHADES: usize = 8;
/// Hexagons with fewer expected crossings are not drawn.
const FAINT: f64 = 0.03;
/// How much darker than the faintest hexagons the darkest are where paths must be seen on them.
const UNDER_PATHS: usize = 60;
const TITLE_PX: f32 = 34.0;

/// What to draw.
#[derive(Debug, Clone, Default)]
pub struct HexPicture<'a> {
    /// A line above.
    pub title: String,
    /// The map; more than one are drawn below each other, each with its own title.
    pub maps: Vec<(String, &'a TransitionMap)>,
    /// The floor plan, if there is one.
    pub walls: &'a [Segment],
    /// Paths over every map, in the order of [`Colour::CYCLE`].
    pub paths: Vec<Vec<Vec2>>,
    /// Width, pixels.
    pub width_px: u32,
}

impl HexPicture<'_> {
    /// Draws it.
    pub fn draw(&self) -> Picture {
        let width = self.width_px.max(200);
        let world = self.extent();
        let size = world.size();
        let row_px = ((f64::from(width) * size.y / size.x).clamp(60.0, 4_000.0) as f32).ceil();
        let rows = self.maps.len().max(1);
        let top = if self.title.is_empty() { 0.0 } else { TITLE_PX };
        let height = top + rows as f32 * (row_px + TITLE_PX);
        let mut picture = Picture::new(width, height as u32);
        if !self.title.is_empty() {
            let title = Item::text([12.0, 24.0], &self.title, 19.0, Anchor::Start, Colour::INK);
            picture.push(None, vec![title]);
        }
        for row in 0..rows {
            let above = top + row as f32 * (row_px + TITLE_PX);
            let frame = PixelRect { left: 0.0, top: above + TITLE_PX, width: width as f32, height: row_px };
            let view = Viewport::fit(&world, frame);
            let mut items = Vec::new();
            if let Some((name, map)) = self.maps.get(row) {
                picture.push(
                    None,
                    vec![Item::text([12.0, above + 24.0], name, 16.0, Anchor::Start, Colour::GREY)],
                );
                items.extend(hexagons(map, &view, if self.paths.is_empty() { 200 } else { UNDER_PATHS }));
            }
            for wall in self.walls {
                if let Some(ends) = view.clipped(wall.ends(), 4.0) {
                    items.push(Item::line(ends.to_vec(), 1.5, Colour::INK));
                }
            }
            for (path, colour) in self.paths.iter().zip(Colour::CYCLE.into_iter().cycle()) {
                let points = path.iter().map(|&p| view.pixel(p)).collect();
                items.push(Item::line(points, 1.6, colour.with_opacity(210)));
            }
            picture.push(Some(frame), items);
        }
        picture
    }

    fn extent(&self) -> WorldRect {
        let cells = self.maps.iter().flat_map(|(_, map)| {
            map.cells().filter(|(_, sum)| *sum > FAINT).map(|(cell, _)| map.grid.centre(cell))
        });
        let walls = self.walls.iter().flat_map(Segment::ends);
        let points = cells.chain(walls).chain(self.paths.iter().flatten().copied());
        let mut corners: Option<(Vec2, Vec2)> = None;
        for p in points.filter(|p| p.x.is_finite() && p.y.is_finite()) {
            corners = Some(corners.map_or((p, p), |(low, high)| (low.inf(&p), high.sup(&p))));
        }
        let (low, high) = corners.unwrap_or_default();
        let air = Vec2::repeat(1.0);
        WorldRect::new(low - air, high + air).unwrap_or(WorldRect::SQUARE)
    }
}

/// One item per shade, the darkest (opacity 40 + `darkest`) last.
fn hexagons(map: &TransitionMap, view: &Viewport, darkest: usize) -> Vec<Item> {
    let most = map.cells().map(|(_, sum)| sum).fold(0.0, f64::max);
    let mut outlines: Vec<Vec<Vec<[f32; 2]>>> = vec![Vec::new(); SHADES];
    for (cell, sum) in map.cells().filter(|(_, sum)| *sum > FAINT) {
        let shade = (1.0 + 99.0 * sum / most).log10() / 2.0;
        let level = ((shade * SHADES as f64) as usize).min(SHADES - 1);
        outlines[level].push(map.grid.corners(cell).map(|p| view.pixel(p)).to_vec());
    }
    let colour = |level: usize| {
        let opacity = 40 + darkest * level / (SHADES - 1);
        Colour::BLUE.with_opacity(opacity as u8)
    };
    let levels = outlines.into_iter().enumerate().filter(|(_, o)| !o.is_empty());
    levels.map(|(level, outlines)| Item::Shapes { outlines, colour: colour(level) }).collect()
}
