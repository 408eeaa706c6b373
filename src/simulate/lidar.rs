//! A planar laser: one range per beam with Gaussian noise along the beam, and normals as a robot would get them.
//!
//! Normals come from the noisy points themselves (a line through the neighbouring beams), not from the world:
//! they are wrong near corners and unknown on lone returns, as in real data.

use rand_distr::{Distribution, StandardNormal};

use super::world::{Hit, World};
use crate::geometry::{Pose2, Vec2};
use crate::map::Observations;

/// Beams on either side that a normal is fitted to.
const NEIGHBOURS: usize = 4;
/// Successive returns farther apart than this, plus three beam spacings, are not on one surface.
const SURFACE_GAP_M: f64 = 0.15;
/// Returns needed for a normal.
const NORMAL_RETURNS: usize = 4;

/// A planar laser scanner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lidar {
    /// Where it sits on the robot.
    pub robot_from_laser: Pose2,
    /// Angle that the beams span, symmetric about straight ahead, radians.
    pub field_of_view_rad: f64,
    /// Number of beams, at least 2.
    pub beams: usize,
    /// Nothing beyond this returns, metres.
    pub max_range_m: f64,
}

impl Lidar {
    /// A SICK-like laser: 180°, 181 beams, 0.15 m ahead of the robot's centre.
    pub fn half_circle(max_range_m: f64) -> Self {
        Lidar {
            robot_from_laser: Pose2::new(0.15, 0.0, 0.0),
            field_of_view_rad: std::f64::consts::PI,
            beams: 181,
            max_range_m,
        }
    }

    /// Appends the scan from one pose to `observations`, and the true hit behind each return to `seen`.
    /// Draws one number per beam, return or not, so that a scan never shifts the noise of the next.
    pub fn scan(
        &self,
        world: &World,
        world_from_robot: Pose2,
        range_noise_m: f64,
        random: &mut impl rand_chacha::rand_core::Rng,
        observations: &mut Observations,
        seen: &mut Vec<Hit>,
    ) {
        let world_from_laser = world_from_robot.compose(self.robot_from_laser);
        let step_rad = self.field_of_view_rad / (self.beams - 1) as f64;
        let mut returns = vec![None; self.beams];
        for (beam, slot) in returns.iter_mut().enumerate() {
            let noise: f64 = StandardNormal.sample(random);
            let bearing_rad = beam as f64 * step_rad - self.field_of_view_rad / 2.0;
            let in_laser = Vec2::new(bearing_rad.cos(), bearing_rad.sin());
            let hit = world.cast(
                world_from_laser.translation(),
                world_from_laser.rotate(in_laser),
                self.max_range_m,
            );
            if let Some(hit) = hit {
                let range_m = (hit.range_m + range_noise_m * noise).max(0.0);
                *slot = Some((in_laser * range_m, range_m));
                seen.push(hit);
            }
        }
        for (beam, slot) in returns.iter().enumerate() {
            if let Some((point, range_m)) = *slot {
                let normal = normal_at(&returns, beam, step_rad);
                let point = self.robot_from_laser.transform_point(point);
                observations.push(point, self.robot_from_laser.rotate(normal), range_m);
            }
        }
        observations.end_pose();
    }
}

/// Unit normal towards the laser of the line through the returns around `beam`; zero where there are too few.
fn normal_at(returns: &[Option<(Vec2, f64)>], beam: usize, step_rad: f64) -> Vec2 {
    let mut surface: Vec<Vec2> = returns[beam].iter().map(|r| r.0).collect();
    for side in [-1_isize, 1] {
        let mut last = returns[beam];
        for k in 1..=NEIGHBOURS as isize {
            let next = beam.checked_add_signed(side * k).and_then(|b| returns.get(b).copied().flatten());
            let (Some((p, range_m)), Some((q, _))) = (last, next) else { break };
            if (q - p).norm() > SURFACE_GAP_M + 3.0 * range_m * step_rad {
                break;
            }
            surface.push(q);
            last = next;
        }
    }
    if surface.len() < NORMAL_RETURNS {
        return Vec2::zeros();
    }
    let mean = surface.iter().sum::<Vec2>() / surface.len() as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for d in surface.iter().map(|p| p - mean) {
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    let direction_rad = 0.5 * (2.0 * xy).atan2(xx - yy);
    let normal = Vec2::new(-direction_rad.sin(), direction_rad.cos());
    if normal.dot(&surface[0]) > 0.0 { -normal } else { normal }
}
