//! Millions of dots as one opacity per pixel, in one pass over the dots.
//!
//! Each dot is a square that adds to every pixel the area that it covers there (so its edges are smooth). The sum c
//! becomes an opacity 1 − exp(−c / c₀): c₀ follows the picture's own median, so that a map of ten thousand points
//! and one of ten million are both neither pale nor a blob, and walls seen often stand out from walls seen once.

use super::scene::{PixelPoint, PixelRect};

/// Opacity per pixel of a part of the picture.
pub struct Density {
    /// Column of the picture where the part begins.
    pub left: usize,
    /// Row of the picture where the part begins.
    pub top: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row; 255 is opaque.
    pub opacity: Vec<u8>,
}

/// Opacity of a pixel that a single dot covers, however dense the rest of the picture is: lone points stay visible.
const LONE_DOT_OPACITY: f32 = 0.38;
/// A pixel of median density gets 1 − exp(−this) = 0.7.
const MEDIAN_EXPOSURE: f32 = 1.2;

/// The opacity of every pixel of `area`, from square dots with sides of `side` pixels.
pub fn density(points: &[PixelPoint], side: f32, area: PixelRect) -> Density {
    let (left, top) = (area.left.max(0.0).floor() as usize, area.top.max(0.0).floor() as usize);
    let width = (area.right().ceil().max(0.0) as usize).saturating_sub(left);
    let height = (area.bottom().ceil().max(0.0) as usize).saturating_sub(top);
    let mut sums = vec![0.0f32; width * height];
    let points = if sums.is_empty() { &[] } else { points };
    for &[x, y] in points {
        splat(&mut sums, width, height, [x - left as f32, y - top as f32], side);
    }
    let opacity = expose(&sums);
    Density { left, top, width, height, opacity }
}

fn splat(sums: &mut [f32], width: usize, height: usize, [x, y]: PixelPoint, side: f32) {
    let (x0, x1) = (x - side / 2.0, x + side / 2.0);
    let (y0, y1) = (y - side / 2.0, y + side / 2.0);
    if !(x1 > 0.0 && y1 > 0.0 && x0 < width as f32 && y0 < height as f32) {
        return; // outside, or not a number
    }
    let columns = x0.max(0.0) as usize..=(x1 as usize).min(width - 1);
    for row in y0.max(0.0) as usize..=(y1 as usize).min(height - 1) {
        let covered_y = y1.min(row as f32 + 1.0) - y0.max(row as f32);
        for column in columns.clone() {
            let covered_x = x1.min(column as f32 + 1.0) - x0.max(column as f32);
            sums[row * width + column] += covered_x * covered_y;
        }
    }
}

fn expose(sums: &[f32]) -> Vec<u8> {
    let mut covered: Vec<f32> = sums.iter().copied().filter(|&c| c > 0.1).collect();
    let middle = covered.len() / 2;
    let median = match covered.is_empty() {
        true => 1.0,
        false => *covered.select_nth_unstable_by(middle, f32::total_cmp).1,
    };
    let reference = median.max(0.75) / MEDIAN_EXPOSURE;
    let opacity = |&c: &f32| {
        if c == 0.0 {
            return 0;
        }
        let exposed = 1.0 - (-c / reference).exp();
        (255.0 * exposed.max(LONE_DOT_OPACITY * c.min(1.0))).round() as u8
    };
    sums.iter().map(opacity).collect()
}
