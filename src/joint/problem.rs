//! The joint problem as plain data: made by [`super::build`], read by every back end, owned by none.
//!
//! min ½ Σ ρ(‖r‖²) over poses and segments, each a block (x, y, θ): metres, metres, radians. The terms R1…R4 are
//! defined in docs/MATH.md under the same names.

use crate::error::{Error, Result};
use crate::map::Mode;
use crate::solver::Loss;

/// Everything that a solver needs to know.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointProblem {
    /// Start: `world_from_robot` of every pose, (x, y, θ).
    pub poses: Vec<[f64; 3]>,
    /// Poses that must not move, ascending: the gauge.
    pub held: Vec<usize>,
    /// Start: P_a and P_b of every human factor in turn: (centre x, centre y, direction).
    pub segments: Vec<[f64; 3]>,
    /// R1.
    pub relatives: Vec<RelativeTerm>,
    /// R2.
    pub sightings: Vec<SightingTerm>,
    /// R3.
    pub ties: Vec<TieTerm>,
    /// R4.
    pub relations: Vec<RelationTerm>,
}

/// R1, relative factor: U·[Rzᵀ(Riᵀ(tj − ti) − tz); wrap(θj − θi − θz)].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeTerm {
    /// Index of the first pose.
    pub i: usize,
    /// Index of the second pose.
    pub j: usize,
    /// z = (x, y, θ).
    pub measured: [f64; 3],
    /// U, row-major 3×3, UᵀU = Ω.
    pub sqrt_information: [f64; 9],
    /// Loss on the whole term.
    pub loss: Loss,
}

/// R2, observations: all selected points of one pose against the line of one segment, as three residuals
/// (exactly the sum of squared point-to-line distances, whatever their number).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightingTerm {
    /// Index of the pose.
    pub pose: usize,
    /// Index of the segment.
    pub segment: usize,
    /// Mean of the points, robot frame, metres.
    pub mean: [f64; 2],
    /// Upper triangular (r11, r12, r22), metres: its square is Σ (q − mean)(q − mean)ᵀ. From a QR, so that a
    /// straight wall (a singular scatter) is no trouble.
    pub scatter_root: [f64; 3],
    /// Number of points.
    pub count: f64,
    /// Weight per point: √weight / σ, 1/m.
    pub scale: f64,
}

/// R3, along-line tie: the mean point's coordinate along the segment stays what it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TieTerm {
    /// Index of the pose.
    pub pose: usize,
    /// Index of the segment.
    pub segment: usize,
    /// Mean of the points, robot frame, metres.
    pub mean: [f64; 2],
    /// The coordinate when the correction was made, metres.
    pub along: f64,
    /// Weight, 1/m.
    pub scale: f64,
}

/// R4, relation of two segments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelationTerm {
    /// How they relate.
    pub mode: Mode,
    /// Index of the earlier segment.
    pub a: usize,
    /// Index of the later segment.
    pub b: usize,
    /// √weight / σ_offset, 1/m.
    pub offset_scale: f64,
    /// √weight / σ_angle, 1/rad.
    pub angle_scale: f64,
    /// Loss on the whole term.
    pub loss: Loss,
}

impl JointProblem {
    /// Checks what every back end relies on: indices in range, finite numbers, positive scales, something held.
    ///
    /// # Errors
    /// [`Error::Input`] at `joint problem` that names the term.
    pub fn validate(&self) -> Result<()> {
        let (n, m) = (self.poses.len(), self.segments.len());
        let fail = |message: String| Err(Error::input("joint problem", message));
        let blocks = self.poses.iter().chain(&self.segments);
        if let Some(k) = blocks.flatten().position(|v| !v.is_finite()) {
            return fail(format!(
                "block {}: found a value that is not finite, expected finite numbers",
                k / 3
            ));
        }
        if self.held.is_empty()
            || !self.held.windows(2).all(|w| w[0] < w[1])
            || self.held.iter().any(|&h| h >= n)
        {
            return fail(format!(
                "found held poses {:?}, expected at least one, ascending, below {n}",
                self.held
            ));
        }
        for (k, t) in self.relatives.iter().enumerate() {
            if t.i >= n || t.j >= n || t.i == t.j {
                return fail(format!(
                    "relative term {k}: found poses {} and {}, expected two below {n}",
                    t.i, t.j
                ));
            }
            if !t.measured.iter().chain(&t.sqrt_information).all(|v| v.is_finite()) {
                return fail(format!(
                    "relative term {k}: found a value that is not finite, expected finite numbers"
                ));
            }
        }
        let sighted = self
            .sightings
            .iter()
            .map(|t| (t.pose, t.segment, t.scale, [t.mean, [t.count, t.count]], t.scatter_root));
        let tied =
            self.ties.iter().map(|t| (t.pose, t.segment, t.scale, [t.mean, [t.along, t.along]], [0.0; 3]));
        for (k, (pose, segment, scale, numbers, more)) in sighted.chain(tied).enumerate() {
            if pose >= n || segment >= m {
                return fail(format!(
                    "human term {k}: found pose {pose} and segment {segment}, expected below {n} and {m}"
                ));
            }
            let are_finite = numbers.iter().flatten().chain(&more).all(|v| v.is_finite());
            if !(scale > 0.0 && scale.is_finite() && are_finite) {
                return fail(format!("human term {k}: found scale {scale} or a value that is not finite"));
            }
        }
        for (k, t) in self.relations.iter().enumerate() {
            if t.a >= m || t.b >= m || t.a == t.b {
                return fail(format!(
                    "relation {k}: found segments {} and {}, expected two below {m}",
                    t.a, t.b
                ));
            }
            if ![t.offset_scale, t.angle_scale].iter().all(|s| *s > 0.0 && s.is_finite()) {
                return fail(format!("relation {k}: found a scale that is not a number > 0"));
            }
        }
        Ok(())
    }
}
