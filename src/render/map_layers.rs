//! What a map picture is made of, each as primitives in a viewport: points, pose arrows, human factors, overlays,
//! grid and scale bar. `unit` is the picture's unit of length, pixels; sizes on screen are multiples of it.

use super::axis;
use super::scene::{Anchor, Colour, Item, PixelPoint, PixelRect};
use super::text::text_width_px;
use super::viewport::Viewport;
use crate::geometry::{Segment, Vec2};
use crate::map::{Feature, SlamMap};

/// An extra segment on top of the map, such as a stroke as it was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// End points, world frame, metres.
    pub ends: [Vec2; 2],
    /// Written beside its middle; may be empty.
    pub label: String,
    /// Colour of segment and label.
    pub colour: Colour,
    /// Width of the line in a picture of usual size, pixels; wide ones get a white edge.
    pub width_px: f32,
}

/// All points of the map that fall into the frame.
pub fn points(map: &SlamMap, view: &Viewport, unit: f32) -> Item {
    let mut points = Vec::with_capacity(map.observations.len());
    for (i, pose) in map.poses.iter().enumerate() {
        let (s, c) = pose.theta_rad.sin_cos(); // once a pose, not once a point
        for &[x, y] in &map.observations.points[map.observations.range(i)] {
            let p = view.pixel(Vec2::new(c * x - s * y + pose.x_m, s * x + c * y + pose.y_m));
            if view.frame.contains(p, 2.0 * unit) {
                points.push(p);
            }
        }
    }
    // Where there are few, as in a close-up, dots grow so that each can be seen.
    let pixels_each = view.frame.width * view.frame.height / points.len().max(1) as f32;
    let side = (1.3 * unit).max(1.0) * (pixels_each / 60.0).sqrt().clamp(1.0, 3.5);
    Item::Dots { points, side, colour: Colour::ORANGE }
}

/// Poses as darts of one size on screen, those in `highlighted` (ascending) blue and on top. Where poses are dense,
/// those that would overlap one already drawn are left out, blue ones last.
pub fn poses(map: &SlamMap, highlighted: &[usize], view: &Viewport, unit: f32) -> Vec<Item> {
    let mut spacing = Spacing::new(view.frame, 12.0 * unit);
    let is_highlighted = |i: &usize| highlighted.binary_search(i).is_ok();
    let mut darts = |wanted: bool| -> Vec<Vec<PixelPoint>> {
        let chosen = (0..map.poses.len()).filter(|i| is_highlighted(i) == wanted);
        let placed = chosen.map(|i| (view.pixel(map.poses[i].translation()), map.poses[i].theta_rad));
        placed.filter(|&(at, _)| spacing.take(at)).map(|(at, theta)| dart(at, theta, unit)).collect()
    };
    let blue = Item::Shapes { outlines: darts(true), colour: Colour::BLUE };
    let black = Item::Shapes { outlines: darts(false), colour: Colour::INK };
    vec![black, blue]
}

/// An arrow head with its middle at `at`, pointing along `theta_rad` (counter-clockwise in the world, y up).
pub fn dart([x, y]: PixelPoint, theta_rad: f64, unit: f32) -> Vec<PixelPoint> {
    let (s, c) = (theta_rad.sin() as f32, theta_rad.cos() as f32);
    let corner =
        |forward: f32, left: f32| [x + unit * (forward * c - left * s), y - unit * (forward * s + left * c)];
    vec![corner(5.5, 0.0), corner(-4.5, 3.4), corner(-2.6, 0.0), corner(-4.5, -3.4)]
}

/// Remembers where something was drawn, so that nothing else is drawn closer than `distance`.
struct Spacing {
    frame: PixelRect,
    distance: f32,
    columns: usize,
    cells: Vec<Vec<PixelPoint>>,
}

impl Spacing {
    fn new(frame: PixelRect, distance: f32) -> Self {
        let columns = (frame.width / distance) as usize + 3;
        let rows = (frame.height / distance) as usize + 3;
        Spacing { frame, distance, columns, cells: vec![Vec::new(); columns * rows] }
    }

    /// True, and taken from now on, if the place is in the frame and free.
    fn take(&mut self, at: PixelPoint) -> bool {
        if !self.frame.contains(at, 0.0) {
            return false; // also where a coordinate is not a number
        }
        let column = ((at[0] - self.frame.left) / self.distance) as usize + 1;
        let row = ((at[1] - self.frame.top) / self.distance) as usize + 1;
        for r in row - 1..=row + 1 {
            for cell in &self.cells[r * self.columns + column - 1..=r * self.columns + column + 1] {
                if cell.iter().any(|p| (p[0] - at[0]).hypot(p[1] - at[1]) < self.distance) {
                    return false;
                }
            }
        }
        self.cells[row * self.columns + column].push(at);
        true
    }
}

/// Every automatic factor as a line between its two poses: green, purple on top where it disagrees with the map.
pub fn automatic_factors(links: &[Link], view: &Viewport, unit: f32) -> Vec<Item> {
    let mut items = Vec::with_capacity(links.len());
    for (wanted, colour, width) in [(true, Colour::GREEN, 1.8), (false, Colour::PURPLE, 4.0)] {
        for link in links.iter().filter(|l| l.agrees == wanted) {
            if let Some(ends) = view.clipped(link.ends, 20.0 * unit) {
                items.push(Item::line(ends.to_vec(), width * unit, colour));
            }
        }
    }
    items
}

/// Two poses that the program joined by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Where they are, world frame, metres.
    pub ends: [Vec2; 2],
    /// False where the factor disagrees with the rest of the map.
    pub agrees: bool,
}

/// Both segments of each human factor: a red, b blue and thinner, so that both show where they coincide.
pub fn human_factors(pairs: &[(Segment, Segment)], view: &Viewport, unit: f32) -> Vec<Item> {
    let mut items = Vec::new();
    let mut stroke = |segment: &Segment, width: f32, colour| {
        if let Some(ends) = view.clipped(segment.ends(), 20.0 * unit) {
            items.push(Item::line(ends.to_vec(), width * unit, colour));
        }
    };
    for (a, b) in pairs {
        stroke(a, 10.0, Colour::WHITE);
        stroke(b, 7.0, Colour::WHITE);
    }
    for (a, b) in pairs {
        stroke(a, 7.0, Colour::RED);
        stroke(b, 3.4, Colour::BLUE);
    }
    items
}

/// A feature as seen from the poses of another state of the same map: the line through those of its points S that its
/// own visit saw, as those poses place them (total least squares), from the first to the last of them; points of the
/// other visit lie elsewhere on a bent map. `None` if the two don't belong together.
pub fn refit(feature: &Feature, map: &SlamMap) -> Option<Segment> {
    let own: Vec<usize> = feature.sightings.iter().filter(|s| s.tied).map(|s| s.pose).collect();
    let mut points = Vec::with_capacity(feature.points.len());
    for &index in &feature.points {
        let index = index as usize;
        if index >= map.observations.len() {
            return None;
        }
        let pose = map.observations.pose_of(index);
        if own.binary_search(&pose).is_ok() {
            points.push(map.poses[pose].transform_point(map.observations.point(index)));
        }
    }
    let mean = points.iter().sum::<Vec2>() / points.len().max(1) as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for d in points.iter().map(|p| p - mean) {
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    let direction_rad = 0.5 * (2.0 * xy).atan2(xx - yy); // principal axis of the scatter matrix
    let axis = Segment { centre: mean, direction_rad, half_length_m: 0.0 };
    let along = points.iter().map(|p| axis.along_across(*p).0);
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    let at = |t: f64| mean + axis.direction() * t;
    (low < high).then(|| Segment::from_ends(at(low), at(high)))
}

/// Extra segments with their labels.
pub fn overlays(overlays: &[Overlay], view: &Viewport, unit: f32) -> Vec<Item> {
    let mut items = Vec::new();
    for overlay in overlays {
        let Some(ends) = view.clipped(overlay.ends, 20.0 * unit) else { continue };
        if overlay.width_px >= 3.0 {
            items.push(Item::line(ends.to_vec(), (overlay.width_px + 3.0) * unit, Colour::WHITE));
        }
        items.push(Item::line(ends.to_vec(), overlay.width_px * unit, overlay.colour));
        if overlay.label.is_empty() {
            continue;
        }
        let [[x0, y0], [x1, y1]] = ends;
        let (size, half) = (17.0 * unit, text_width_px(&overlay.label, 17.0 * unit) / 2.0);
        let steep = (y1 - y0).abs() > (x1 - x0).abs();
        let beside = if steep { [half + 9.0 * unit, size * 0.35] } else { [0.0, -10.0 * unit] };
        let frame = view.frame; // keep the words inside
        let x = ((x0 + x1) / 2.0 + beside[0]).min(frame.right() - half).max(frame.left + half);
        let y = ((y0 + y1) / 2.0 + beside[1]).min(frame.bottom() - 4.0).max(frame.top + size);
        items.push(Item::Text {
            at: [x, y],
            text: overlay.label.clone(),
            size,
            anchor: Anchor::Middle,
            colour: overlay.colour,
            halo: true,
            upwards: false,
        });
    }
    items
}

/// Light lines at round coordinates: (lines, labels for the margins left and below).
pub fn grid(view: &Viewport, unit: f32) -> (Vec<Item>, Vec<Item>) {
    let (frame, size) = (view.frame, 14.0 * unit);
    let (min, max) = view.visible();
    let wanted = |length: f32| ((length / (95.0 * unit)) as usize).max(2);
    let step_wanted = wanted(frame.width.max(frame.height));
    let span = (max - min).max();
    let along = |from: f64, to: f64| {
        axis::ticks(from, to, ((step_wanted as f64 * (to - from) / span).round() as usize).max(1))
    };
    let (mut lines, mut labels) = (Vec::new(), Vec::new());
    let mut columns = along(min.x, max.x);
    if let Some((_, last)) = columns.last_mut() {
        last.push_str(" m");
    }
    for (x_m, label) in columns {
        let x = view.pixel(Vec2::new(x_m, 0.0))[0].round() + 0.5;
        lines.push(Item::line(vec![[x, frame.top], [x, frame.bottom()]], 1.0, Colour::LIGHT));
        let at = [x, frame.bottom() + 1.35 * size];
        labels.push(Item::text(at, label, size, Anchor::Middle, Colour::GREY));
    }
    for (y_m, label) in along(min.y, max.y) {
        let y = view.pixel(Vec2::new(0.0, y_m))[1].round() + 0.5;
        lines.push(Item::line(vec![[frame.left, y], [frame.right(), y]], 1.0, Colour::LIGHT));
        let at = [frame.left - 0.5 * size, y + 0.36 * size];
        labels.push(Item::text(at, label, size, Anchor::End, Colour::GREY));
    }
    (lines, labels)
}

/// A bar of a round length with its label, its left end at `at`; also says how far to the right it reaches.
pub fn scale_bar(view: &Viewport, [x, y]: PixelPoint, unit: f32) -> (Vec<Item>, f32) {
    let length_m =
        axis::round_down(f64::from(view.frame.width.min(view.frame.height * 2.0)) * 0.3 / view.scale);
    let end = x + (length_m * view.scale) as f32;
    let (tick, size) = (5.0 * unit, 16.0 * unit);
    let outline = vec![[x, y - tick], [x, y], [end, y], [end, y - tick]];
    let label = match length_m {
        l if l >= 1000.0 => format!("{} km", axis::label(l / 1000.0, l / 1000.0)),
        l if l < 0.01 => format!("{} mm", axis::label(l * 1000.0, l * 1000.0)),
        l => format!("{} m", axis::label(l, l)),
    };
    let right = end + 8.0 * unit + text_width_px(&label, size);
    let items = vec![
        Item::line(outline, 2.2 * unit, Colour::INK),
        Item::text([end + 8.0 * unit, y + 1.0 * unit], label, size, Anchor::Start, Colour::INK),
    ];
    (items, right)
}
