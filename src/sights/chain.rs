//! How far the chain between two poses may be off by its own covariance.

use crate::geometry::{Vec2, isotropic_variances};
use crate::map::SlamMap;

/// Standard deviations of a step that no factor holds: metres and radians.
const UNKNOWN: (f64, f64) = (1.0, 1.0);

/// Sums over the steps before each pose, so that any stretch costs one subtraction.
pub struct Chain {
    sums: Vec<Sum>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    /// Position variance, m².
    position: f64,
    /// Heading variance v, rad², and v·p and v·|p|², p being where the robot turned.
    heading: f64,
    first: Vec2,
    second: f64,
}

impl Chain {
    /// Of a map as it stands.
    pub fn new(map: &SlamMap) -> Chain {
        let mut steps = vec![None; map.poses.len().saturating_sub(1)];
        for factor in map.relative_factors.iter().filter(|f| f.i.abs_diff(f.j) == 1) {
            steps[factor.i.min(factor.j)] = Some(isotropic_variances(&factor.information.covariance()));
        }
        let mut sum = Sum::default();
        let mut sums = vec![sum];
        for (step, pose) in steps.into_iter().zip(&map.poses) {
            let (position, heading) = step.unwrap_or((UNKNOWN.0.powi(2), UNKNOWN.1.powi(2)));
            let p = pose.translation();
            sum.position += position;
            sum.heading += heading;
            sum.first += p * heading;
            sum.second += p.norm_squared() * heading;
            sums.push(sum);
        }
        Chain { sums }
    }

    /// Variances of `place` and of a direction there, as the later of two poses sees them from the earlier: m² per axis, rad².
    pub fn variances(&self, i: usize, j: usize, place: Vec2) -> (f64, f64) {
        let (from, to) = (self.sums[i.min(j)], self.sums[i.max(j)]);
        let heading = to.heading - from.heading;
        let levers = place.norm_squared() * heading - 2.0 * place.dot(&(to.first - from.first)) + to.second
            - from.second;
        (to.position - from.position + levers.max(0.0), heading)
    }
}
