//! A small plot: curves, dots and bars with error bars on linear or logarithmic axes with round ticks and a legend.

use super::axis;
use super::scene::{Anchor, Colour, Item, Picture, PixelPoint, PixelRect};
use super::text::text_width_px;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A curve through the values, in their order.
    Line,
    /// A disc per value.
    Dots,
    /// A bar per value, from the axis; several series of bars stand beside each other.
    Bars,
}

/// Values that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty: not in the legend.
    pub label: String,
    /// (x, y); values that are not finite (or ≤ 0 on a logarithmic axis) are left out and interrupt a curve.
    pub points: Vec<[f64; 2]>,
    /// (low, high) end of each value's error bar, e.g. its 95 % interval; empty: none.
    pub intervals: Vec<[f64; 2]>,
    /// How to draw it.
    pub mark: Mark,
}

/// A plot. Start from `Plot::default()`.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// A line above; may be empty.
    pub title: String,
    /// Quantity and unit along x.
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// Logarithmic x axis.
    pub log_x: bool,
    /// Logarithmic y axis.
    pub log_y: bool,
    /// Names of x = 0, 1, 2, … instead of numbers (bars); empty: a numeric axis.
    pub categories: Vec<String>,
    /// What to draw, colours in the order of [`Colour::CYCLE`].
    pub series: Vec<Series>,
    /// Width and height, pixels.
    pub size_px: (u32, u32),
}

impl Default for Plot {
    fn default() -> Self {
        Plot {
            title: String::new(),
            x_label: String::new(),
            y_label: String::new(),
            log_x: false,
            log_y: false,
            categories: Vec::new(),
            series: Vec::new(),
            size_px: (1200, 640),
        }
    }
}

impl Plot {
    /// Draws the plot.
    pub fn draw(&self) -> Picture {
        let mut picture = Picture::new(self.size_px.0.max(160), self.size_px.1.max(120));
        let unit = (picture.width() as f32 / 1000.0).min(picture.height() as f32 / 560.0).max(0.4);
        let (x, y) = (self.x_axis(), self.y_axis());
        let widest = y.ticks.iter().map(|(_, l)| text_width_px(l, 15.0 * unit)).fold(0.0, f32::max);
        let left = (widest + 48.0 * unit).round();
        let top = if self.title.is_empty() { 18.0 * unit } else { 52.0 * unit };
        let legend_height = if self.series.iter().any(|s| !s.label.is_empty()) { 30.0 * unit } else { 0.0 };
        let below = if self.x_label.is_empty() { 38.0 } else { 66.0 } * unit;
        let frame = PixelRect {
            left,
            top: (top + legend_height).round(),
            width: (picture.width() as f32 - left - 24.0 * unit).round(),
            height: (picture.height() as f32 - top - legend_height - below).round(),
        };
        let place = Place { x, y, frame };
        picture.push(None, place.axes(self, unit));
        let mut marks = Vec::new();
        for index in 0..self.series.len() {
            marks.extend(self.marks(index, &place, unit));
        }
        // Discs and whiskers at the very edge may reach over it.
        let clip = PixelRect {
            left: frame.left - 6.0 * unit,
            top: frame.top - 6.0 * unit,
            width: frame.width + 12.0 * unit,
            height: frame.height + 6.0 * unit,
        };
        picture.push(Some(clip), marks);
        picture.push(None, self.legend(frame, unit));
        picture
    }

    fn bar_series(&self) -> Vec<usize> {
        (0..self.series.len()).filter(|&i| self.series[i].mark == Mark::Bars).collect()
    }

    fn x_axis(&self) -> Axis {
        if !self.categories.is_empty() {
            let ticks = self.categories.iter().enumerate().map(|(i, c)| (i as f64, c.clone())).collect();
            return Axis { from: -0.5, to: self.categories.len() as f64 - 0.5, log: false, ticks };
        }
        let values = self.series.iter().flat_map(|s| s.points.iter().map(|p| p[0]));
        let half_bar = if self.bar_series().is_empty() { 0.0 } else { 0.5 };
        Axis::around(values.flat_map(|v| [v - half_bar, v + half_bar]), self.log_x, false)
    }

    /// Linear y axes begin at zero where the values allow it.
    fn y_axis(&self) -> Axis {
        let values = self
            .series
            .iter()
            .flat_map(|s| s.points.iter().map(|p| p[1]).chain(s.intervals.iter().flatten().copied()));
        Axis::around(values, self.log_y, true)
    }

    fn marks(&self, index: usize, place: &Place, unit: f32) -> Vec<Item> {
        let series = &self.series[index];
        let colour = Colour::CYCLE[index % Colour::CYCLE.len()];
        let bars = self.bar_series();
        let rank = bars.iter().position(|&b| b == index);
        let slot = 0.72 / bars.len().max(1) as f64;
        let shift = rank.map_or(0.0, |r| (r as f64 - (bars.len() as f64 - 1.0) / 2.0) * slot);
        let mut items = Vec::new();
        let mut run: Vec<PixelPoint> = Vec::new();
        for &[x, y] in &series.points {
            let Some(at) = place.pixel(x + shift, y) else {
                items.extend(polyline(&mut run, colour, unit));
                continue;
            };
            match series.mark {
                Mark::Line => run.push(at),
                Mark::Dots => items.push(Item::disc(at, 3.4 * unit, colour.with_opacity(190))),
                Mark::Bars => {
                    let base = place.pixel(x, 0.0).map_or(place.frame.bottom(), |p| p[1]);
                    let half = (0.46 * slot * place.pixels_per_x()) as f32;
                    let (top, bottom) = (at[1].min(base), at[1].max(base));
                    let bar = PixelRect { left: at[0] - half, top, width: 2.0 * half, height: bottom - top };
                    items.push(Item::rect(bar, colour.with_opacity(205)));
                }
            }
        }
        items.extend(polyline(&mut run, colour, unit));
        let whisker_colour = if series.mark == Mark::Bars { Colour::INK } else { colour };
        for (&[x, _], &[low, high]) in series.points.iter().zip(&series.intervals) {
            let (Some([x, y0]), Some([_, y1])) = (place.pixel(x + shift, low), place.pixel(x + shift, high))
            else {
                continue;
            };
            let cap = 5.0 * unit;
            for ends in [[[x, y0], [x, y1]], [[x - cap, y0], [x + cap, y0]], [[x - cap, y1], [x + cap, y1]]] {
                items.push(Item::line(ends.to_vec(), 1.6 * unit, whisker_colour));
            }
        }
        items
    }

    fn legend(&self, frame: PixelRect, unit: f32) -> Vec<Item> {
        let (size, y) = (15.0 * unit, frame.top - 14.0 * unit);
        let mut items = Vec::new();
        let mut x = frame.left;
        for (index, series) in self.series.iter().enumerate().filter(|(_, s)| !s.label.is_empty()) {
            let colour = Colour::CYCLE[index % Colour::CYCLE.len()];
            let middle = y - 5.0 * unit;
            match series.mark {
                Mark::Line => {
                    items.push(Item::line(
                        vec![[x + 2.0, middle], [x + 24.0 * unit, middle]],
                        2.6 * unit,
                        colour,
                    ));
                }
                Mark::Dots => items.push(Item::disc([x + 14.0 * unit, middle], 4.0 * unit, colour)),
                Mark::Bars => {
                    let (left, top) = (x + 8.0 * unit, middle - 6.0 * unit);
                    let rect = PixelRect { left, top, width: 12.0 * unit, height: 12.0 * unit };
                    items.push(Item::rect(rect, colour.with_opacity(205)));
                }
            }
            items.push(Item::text(
                [x + 32.0 * unit, y],
                series.label.as_str(),
                size,
                Anchor::Start,
                Colour::INK,
            ));
            x += 58.0 * unit + text_width_px(&series.label, size);
        }
        items
    }
}

fn polyline(run: &mut Vec<PixelPoint>, colour: Colour, unit: f32) -> Option<Item> {
    let points = std::mem::take(run);
    match points[..] {
        [] => None,
        [alone] => Some(Item::disc(alone, 2.0 * unit, colour)),
        _ => Some(Item::line(points, 1.8 * unit, colour)),
    }
}

/// A range of values with its ticks.
struct Axis {
    from: f64,
    to: f64,
    log: bool,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    fn around(values: impl Iterator<Item = f64>, log: bool, with_zero: bool) -> Axis {
        let usable = values.filter(|v| v.is_finite() && (!log || *v > 0.0));
        let (mut from, mut to) =
            usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if from > to {
            (from, to) = if log { (0.1, 10.0) } else { (0.0, 1.0) };
        }
        if log {
            if to < from * 2.0 {
                (from, to) = (from / 2.0, to * 2.0);
            }
            let air = (to / from).powf(0.04);
            (from, to) = (from / air, to * air);
            return Axis { from, to, log, ticks: axis::log_ticks(from, to) };
        }
        if with_zero {
            let air = 0.06 * (to - from);
            from = if from >= 0.0 { 0.0 } else { from - air };
            to = if to <= 0.0 { 0.0 } else { to + air };
        }
        if to - from <= 1e-12 * from.abs().max(to.abs()) {
            let half = from.abs().max(to.abs()).max(1.0) / 2.0;
            (from, to) = (from - half, to + half);
        }
        Axis { from, to, log, ticks: axis::ticks(from, to, 6) }
    }

    /// Where a value lies, 0 at `from`, 1 at `to`; `None` if it has no place.
    fn share(&self, value: f64) -> Option<f64> {
        let share = if self.log {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        };
        share.is_finite().then_some(share.clamp(-1.0, 2.0))
    }
}

/// From values to pixels.
struct Place {
    x: Axis,
    y: Axis,
    frame: PixelRect,
}

impl Place {
    fn pixel(&self, x: f64, y: f64) -> Option<PixelPoint> {
        let (x, y) = (self.x.share(x)? as f32, self.y.share(y)? as f32);
        Some([self.frame.left + x * self.frame.width, self.frame.bottom() - y * self.frame.height])
    }

    fn pixels_per_x(&self) -> f64 {
        f64::from(self.frame.width) / (self.x.to - self.x.from)
    }

    fn axes(&self, plot: &Plot, unit: f32) -> Vec<Item> {
        let (frame, size) = (self.frame, 15.0 * unit);
        let mut items = Vec::new();
        for (value, label) in &self.y.ticks {
            let Some(share) = self.y.share(*value) else { continue };
            let y = (frame.bottom() - share as f32 * frame.height).round() + 0.5;
            items.push(Item::line(vec![[frame.left, y], [frame.right(), y]], 1.0, Colour::LIGHT));
            let at = [frame.left - 8.0 * unit, y + 0.36 * size];
            items.push(Item::text(at, label.as_str(), size, Anchor::End, Colour::GREY));
        }
        for (value, label) in &self.x.ticks {
            let Some(share) = self.x.share(*value) else { continue };
            let x = (frame.left + share as f32 * frame.width).round() + 0.5;
            if plot.categories.is_empty() {
                let ends = vec![[x, frame.bottom()], [x, frame.bottom() + 5.0 * unit]];
                items.push(Item::line(ends, 1.0, Colour::GREY));
            }
            let at = [x, frame.bottom() + 22.0 * unit];
            items.push(Item::text(at, label.as_str(), size, Anchor::Middle, Colour::GREY));
        }
        let base = frame.bottom().round() + 0.5;
        items.push(Item::line(vec![[frame.left, base], [frame.right(), base]], 1.0, Colour::GREY));
        let middle = frame.left + frame.width / 2.0;
        let x_label = [middle, frame.bottom() + 50.0 * unit];
        items.push(Item::text(x_label, plot.x_label.as_str(), size, Anchor::Middle, Colour::INK));
        items.push(Item::Text {
            at: [20.0 * unit, frame.top + frame.height / 2.0],
            text: plot.y_label.clone(),
            size,
            anchor: Anchor::Middle,
            colour: Colour::INK,
            halo: false,
            upwards: true,
        });
        let title = [frame.left, 32.0 * unit];
        items.push(Item::text(title, plot.title.as_str(), 20.0 * unit, Anchor::Start, Colour::INK));
        items
    }
}
