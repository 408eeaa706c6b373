//! The domain model, plain data: a pose graph with what the laser saw, and what people said about it.

mod automatic_factor;
mod correction;
mod human_factor;
mod log;
mod observations;
mod relation;
mod slam_map;
mod trajectory;
mod walls;

pub use automatic_factor::AutomaticFactor;
pub use correction::{Correction, Mode, Stroke};
pub use human_factor::{Feature, HumanFactor, Sighting};
pub use log::{LogScan, NO_RETURN_M, RawLog};
pub use observations::Observations;
pub use relation::Relation;
pub use slam_map::{RelativeFactor, ScanRecord, SlamMap};
pub use trajectory::Trajectory;
pub use walls::{Measure, Wall, WallPair};
