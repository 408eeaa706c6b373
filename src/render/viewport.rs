//! From world metres (y up) to pixels (y down), and which part of the world to show.

use super::scene::{PixelPoint, PixelRect};
use crate::geometry::Vec2;
use crate::map::SlamMap;

/// An upright rectangle of the world, metres; never empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldRect {
    min: Vec2,
    max: Vec2,
}

impl WorldRect {
    /// Two metres by two around the origin.
    pub const SQUARE: WorldRect = WorldRect { min: Vec2::new(-1.0, -1.0), max: Vec2::new(1.0, 1.0) };

    /// The rectangle between two opposite corners; `None` if it is empty or not finite.
    pub fn new(corner: Vec2, opposite: Vec2) -> Option<Self> {
        let (min, max) = (corner.inf(&opposite), corner.sup(&opposite));
        let size = max - min;
        let fine = size.x > 0.0 && size.y > 0.0 && size.x.is_finite() && size.y.is_finite();
        fine.then_some(WorldRect { min, max })
    }

    /// Lower left corner, metres.
    pub fn min(&self) -> Vec2 {
        self.min
    }

    /// Upper right corner, metres.
    pub fn max(&self) -> Vec2 {
        self.max
    }

    /// Width and height, metres.
    pub fn size(&self) -> Vec2 {
        self.max - self.min
    }

    /// The smallest rectangle around both.
    pub fn union(&self, other: &WorldRect) -> WorldRect {
        WorldRect { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// What to show of a map: all poses and all points, except that where a few stray returns (1 in 1,000 per side)
    /// would more than add a fifth to the width or height, they are left outside. With 2 % of air around.
    pub fn around(map: &SlamMap) -> WorldRect {
        let mut samples: Vec<Vec2> = Vec::new();
        let stride = map.observations.len() / 200_000 + 1;
        for (i, pose) in map.poses.iter().enumerate() {
            let (s, c) = pose.theta_rad.sin_cos();
            for p in map.observations.range(i).filter(|p| p % stride == 0) {
                let [x, y] = map.observations.points[p];
                samples.push(Vec2::new(c * x - s * y + pose.x_m, s * x + c * y + pose.y_m));
            }
        }
        let poses = map.poses.iter().map(|p| p.translation());
        let (x0, x1) = extent(samples.iter().map(|p| p.x).collect(), poses.clone().map(|p| p.x));
        let (y0, y1) = extent(samples.iter().map(|p| p.y).collect(), poses.map(|p| p.y));
        let span = (x1 - x0).max(y1 - y0);
        let air = (0.02 * span).max((1.0 - span) / 2.0); // a single pose is shown in a metre of world
        let around = WorldRect::new(Vec2::new(x0 - air, y0 - air), Vec2::new(x1 + air, y1 + air));
        around.unwrap_or(WorldRect::SQUARE)
    }
}

/// Smallest and largest value to show along one axis.
fn extent(mut points: Vec<f64>, poses: impl Iterator<Item = f64>) -> (f64, f64) {
    points.retain(|v| v.is_finite());
    points.sort_unstable_by(f64::total_cmp);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for pose in poses.filter(|v| v.is_finite()) {
        (low, high) = (low.min(pose), high.max(pose));
    }
    if let (Some(&first), Some(&last)) = (points.first(), points.last()) {
        let skip = points.len() / 1000;
        let bulk_low = low.min(points[skip]);
        let bulk_high = high.max(points[points.len() - 1 - skip]);
        let air = 0.1 * (bulk_high - bulk_low);
        low = if bulk_low - first <= air { first.min(low) } else { bulk_low };
        high = if last - bulk_high <= air { last.max(high) } else { bulk_high };
    }
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// A part of the world shown in a frame of the picture, equal scale on both axes.
#[derive(Debug, Clone, Copy)]
pub struct Viewport {
    /// Where in the picture.
    pub frame: PixelRect,
    /// Pixels per metre.
    pub scale: f64,
    centre: Vec2,
}

impl Viewport {
    /// Shows `world` as large as it fits in the middle of `frame`.
    pub fn fit(world: &WorldRect, frame: PixelRect) -> Self {
        let size = world.size();
        let scale = (f64::from(frame.width) / size.x).min(f64::from(frame.height) / size.y);
        Viewport { frame, scale, centre: world.min + size / 2.0 }
    }

    /// The pixel of a world point.
    pub fn pixel(&self, world: Vec2) -> PixelPoint {
        let d = (world - self.centre) * self.scale;
        let (x, y) = (self.frame.left + self.frame.width / 2.0, self.frame.top + self.frame.height / 2.0);
        [(f64::from(x) + d.x) as f32, (f64::from(y) - d.y) as f32]
    }

    /// The part of the world that the frame shows: (lower left, upper right), metres.
    pub fn visible(&self) -> (Vec2, Vec2) {
        let half = Vec2::new(f64::from(self.frame.width), f64::from(self.frame.height)) / (2.0 * self.scale);
        (self.centre - half, self.centre + half)
    }

    /// The part of a world segment within `margin` pixels of the frame (Liang–Barsky), in pixels; `None` if it has
    /// no such part. Keeps far-away ends from overflowing the rasteriser.
    pub fn clipped(&self, ends: [Vec2; 2], margin: f32) -> Option<[PixelPoint; 2]> {
        let (min, max) = self.visible();
        let air = Vec2::repeat(f64::from(margin) / self.scale);
        let (min, max) = (min - air, max + air);
        let d = ends[1] - ends[0];
        let (mut t0, mut t1) = (0.0f64, 1.0f64);
        for axis in 0..2 {
            let (to_min, to_max) = (min[axis] - ends[0][axis], max[axis] - ends[0][axis]);
            if d[axis] == 0.0 {
                if to_min > 0.0 || to_max < 0.0 {
                    return None;
                }
                continue;
            }
            let (enter, leave) = (to_min / d[axis], to_max / d[axis]);
            t0 = t0.max(enter.min(leave));
            t1 = t1.min(enter.max(leave));
        }
        let inside = t0 <= t1 && d.iter().chain(ends[0].iter()).all(|v| v.is_finite());
        inside.then(|| [self.pixel(ends[0] + d * t0), self.pixel(ends[0] + d * t1)])
    }
}
