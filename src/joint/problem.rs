//! The joint problem as plain data: made by [`super::build`], read by every back end, owned by none.
//!
//! min ½ Σ ρ(‖r‖²) over poses and segments, each a block (x, y, θ): metres, metres, radians; in the formulation
//! `paper` segments are two free end points (x, y) instead. The terms R1…R6 are defined in docs/MATH.md under the
//! same names; their order here is their order in every back end.

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
    /// Start, `paper`: both ends of P_a and of P_b of every human factor in turn.
    pub ends: Vec<[[f64; 2]; 2]>,
    /// R1.
    pub relatives: Vec<RelativeTerm>,
    /// R2, all points of a pose at once.
    pub sightings: Vec<SightingTerm>,
    /// R2, point by point.
    pub points: Vec<PointTerm>,
    /// R3.
    pub ties: Vec<TieTerm>,
    /// R4; `a` and `b` are indices into `segments`.
    pub relations: Vec<RelationTerm>,
    /// R5: R_a and R_b of `paper`.
    pub fits: Vec<FitTerm>,
    /// R6: R_p of `paper`; `a` and `b` are indices into `ends`.
    pub paper_relations: Vec<RelationTerm>,
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
    /// U, row-major 3×3, upper triangular with a diagonal > 0, UᵀU = Ω.
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

/// R2 for a single point: its distance to the line of a segment. The sum over a pose's points is its [`SightingTerm`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointTerm {
    /// Index of the pose.
    pub pose: usize,
    /// Index of the segment.
    pub segment: usize,
    /// The point, robot frame, metres.
    pub point: [f64; 2],
    /// √weight / σ, 1/m.
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

/// R4 and R6, relation of two segments.
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

/// R5, the paper's R_a or R_b: the root of the mean over S of the squared distance to the segment, ends included.
#[derive(Debug, Clone, PartialEq)]
pub struct FitTerm {
    /// Index into [`JointProblem::ends`].
    pub segment: usize,
    /// S by pose, ascending, none empty.
    pub sightings: Vec<FitSighting>,
    /// √weight / σ, 1/m.
    pub scale: f64,
}

/// The points of S that one pose saw.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSighting {
    /// Index of the pose.
    pub pose: usize,
    /// Robot frame, metres.
    pub points: Vec<[f64; 2]>,
}

/// What a term is. The order is that of the terms in a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TermKind {
    /// R1.
    Relative,
    /// R2, all points of a pose at once.
    Sighting,
    /// R2, point by point.
    Point,
    /// R3.
    Tie,
    /// R4.
    Relation,
    /// R5.
    Fit,
    /// R6.
    PaperRelation,
}

impl TermKind {
    /// snake_case name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            TermKind::Relative => "relative",
            TermKind::Sighting => "sighting",
            TermKind::Point => "point",
            TermKind::Tie => "tie",
            TermKind::Relation => "relation",
            TermKind::Fit => "fit",
            TermKind::PaperRelation => "paper_relation",
        }
    }
}

impl JointProblem {
    /// Kind of a term and its index within its kind; `None` beyond the last term.
    pub fn kind_of(&self, term: usize) -> Option<(TermKind, usize)> {
        // Nearly all terms of nearly all problems.
        if term < self.relatives.len() {
            return Some((TermKind::Relative, term));
        }
        let mut k = term;
        for (kind, count) in self.counts() {
            if k < count {
                return Some((kind, k));
            }
            k -= count;
        }
        None
    }

    /// Number of terms of every kind, in order.
    pub fn counts(&self) -> [(TermKind, usize); 7] {
        [
            (TermKind::Relative, self.relatives.len()),
            (TermKind::Sighting, self.sightings.len()),
            (TermKind::Point, self.points.len()),
            (TermKind::Tie, self.ties.len()),
            (TermKind::Relation, self.relations.len()),
            (TermKind::Fit, self.fits.len()),
            (TermKind::PaperRelation, self.paper_relations.len()),
        ]
    }
}
