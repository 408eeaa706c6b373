//! How a particle moves: the measured step, turned by the particle's own heading offset, plus noise.
//!
//! State per particle: heading offset φ of the dead reckoning against the world, its drift ρ per step, scale s.
//!
//! ρ ← ρ + √ℓ σ_ρ ε₁,  φ ← φ + ℓ ρ + √ℓ σ_φ ε₂,  p ← p + s R(φ) d + √ℓ σ_p (ε₃, ε₄)
//!
//! with ℓ the step's length over [`OdometryNoise::STEP_M`]. All in `f32`: the numbers are noise far above rounding.

use super::hex::HexGrid;
use super::options::OdometryNoise;
use super::walk::Step;
use crate::geometry::Vec2;

/// A step of the dead reckoning, ready for the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredStep {
    /// Displacement in the grid frame as the dead reckoning has it (φ = 0), metres.
    pub motion: [f32; 2],
    /// ℓ.
    pub share: f32,
    /// √ℓ.
    pub root_share: f32,
    /// Heading of the dead reckoning after the step, world frame, radians (not wrapped).
    pub heading_rad: f64,
}

impl MeasuredStep {
    /// A step taken at a heading of the dead reckoning.
    pub fn of(step: &Step, heading_rad: f64, grid: &HexGrid) -> Self {
        let (s, c) = heading_rad.sin_cos();
        let d = Vec2::new(c * step.forward_m - s * step.left_m, s * step.forward_m + c * step.left_m);
        let d = grid.rotate_to_grid(d);
        let share = if step.is_standing() { 0.0 } else { step.length_m() / OdometryNoise::STEP_M };
        MeasuredStep {
            motion: [d.x as f32, d.y as f32],
            share: share as f32,
            root_share: share.sqrt() as f32,
            heading_rad: heading_rad + step.turn_rad,
        }
    }
}

/// The measured steps of a walk that starts with a heading.
pub fn measured(steps: &[Step], start_heading_rad: f64, grid: &HexGrid) -> Vec<MeasuredStep> {
    let mut heading_rad = start_heading_rad;
    let convert = |step: &Step| {
        let moved = MeasuredStep::of(step, heading_rad, grid);
        heading_rad = moved.heading_rad;
        moved
    };
    steps.iter().map(convert).collect()
}

/// Standard deviations as the filter uses them.
#[derive(Debug, Clone, Copy)]
pub struct Sigmas {
    heading: f32,
    drift_start: f32,
    drift: f32,
    position: f32,
    scale: f32,
}

impl From<&OdometryNoise> for Sigmas {
    fn from(noise: &OdometryNoise) -> Self {
        Sigmas {
            heading: noise.heading_rad as f32,
            drift_start: noise.drift_start_rad as f32,
            drift: noise.drift_rad as f32,
            position: noise.position_m as f32,
            scale: noise.scale as f32,
        }
    }
}

/// The odometry error of one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorState {
    /// φ, radians.
    pub heading: f32,
    /// ρ, radians per step.
    pub drift: f32,
    /// s.
    pub scale: f32,
}

impl ErrorState {
    /// The errors at the start of a walk, from three normal numbers.
    pub fn draw(sigmas: &Sigmas, start_heading_sigma: f32, [a, b, c]: [f32; 3]) -> Self {
        ErrorState {
            heading: start_heading_sigma * a,
            drift: sigmas.drift_start * b,
            scale: 1.0 + sigmas.scale * c,
        }
    }

    /// One step: the new error state, the displacement in the grid frame, and (sin φ, cos φ).
    #[inline(always)]
    pub fn step(self, sigmas: &Sigmas, step: &MeasuredStep, normal: [f32; 4]) -> (Self, [f32; 2], [f32; 2]) {
        let root = step.root_share;
        let drift = self.drift + root * sigmas.drift * normal[0];
        let heading = self.heading + (step.share * drift + root * sigmas.heading * normal[1]);
        let (s, c) = sin_cos(heading);
        let [dx, dy] = step.motion;
        let shake = root * sigmas.position;
        let x = self.scale * (c * dx - s * dy) + shake * normal[2];
        let y = self.scale * (s * dx + c * dy) + shake * normal[3];
        (ErrorState { heading, drift, scale: self.scale }, [x, y], [s, c])
    }
}

/// Sine and cosine, good to 4e-7 for |x| < 10⁴, and without a branch or a call, so that loops over it vectorise.
#[inline(always)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    const MAGIC: f32 = 12_582_912.0; // 1.5 · 2²³: adding it rounds to whole numbers
    let turns = (x * std::f32::consts::FRAC_1_PI * 0.5 + MAGIC) - MAGIC;
    // 2π in two parts, so that whole turns come off without rounding.
    let x = (x - turns * 6.281_25) - turns * 1.935_307_2e-3;
    let h = 0.5 * x;
    let h2 = h * h;
    let tail = 1.0 / 362_880.0 - h2 * (1.0 / 39_916_800.0);
    let sin = h * (1.0 - h2 * (1.0 / 6.0 - h2 * (1.0 / 120.0 - h2 * (1.0 / 5_040.0 - h2 * tail))));
    let tail = 1.0 / 40_320.0 - h2 * (1.0 / 3_628_800.0 - h2 * (1.0 / 479_001_600.0));
    let cos = 1.0 - h2 * (0.5 - h2 * (1.0 / 24.0 - h2 * (1.0 / 720.0 - h2 * tail)));
    (2.0 * sin * cos, 1.0 - 2.0 * sin * sin)
}
