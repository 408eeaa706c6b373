//! How good a map is: errors against a true trajectory, against its own measurements, against hand-checked relations.
//!
//! [`evaluate`] gathers all of them into the report of `hitl evaluate`; each metric is also a function by itself.
//! Metres and radians throughout, except where a name ends in `_deg`.

mod alignment;
mod association;
mod ate;
mod evaluation;
mod inconsistency;
mod relations;
mod rpe;
mod walls;
mod worst_edge;

pub use alignment::align;
pub use association::{DEFAULT_TOLERANCE_S, associate};
pub use ate::{Ate, PoseError, ate};
pub use evaluation::{Evaluation, Reference, evaluate};
pub use inconsistency::{Inconsistency, InconsistencyOptions, inconsistency};
pub use relations::{RelationError, RelationErrors, SPAN_LIMITS_S, SpanErrors, relation_errors};
pub use rpe::{Rpe, rpe};
pub use walls::{ON_WALL_M, WallErrors, WallSample, wall_errors};
pub use worst_edge::{WorstEdge, worst_edge};
