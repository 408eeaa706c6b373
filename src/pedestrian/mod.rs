//! Pedestrian mapping without a map: FootSLAM, FeetSLAM and successive collaborative mapping.
//!
//! A walker's dead reckoning ([`walk`]) drifts. People use buildings the same way again and again, so a map of how often
//! the edges between [`hex`]agons were crossed ([`transition_map`]) is enough to weigh hypotheses of where they were:
//! [`footslam`] runs a [`particle_filter`] for one walker, [`feetslam`] lets walkers use each other's maps, and
//! [`successive`] does so again and again while they walk; [`live`] takes steps as they arrive. Formulas: `docs/MATH-pedestrian.md`.
//!
//! Metres, radians, seconds. Everything follows from the walks, the options and the seed, at any number of threads.

pub mod align;
pub mod bend;
pub mod chain;
pub mod evidence;
pub mod feetslam;
pub mod footslam;
mod genealogy;
pub mod grid;
pub mod hex;
mod history;
mod hough;
mod layout;
pub mod live;
pub mod metrics;
pub mod motion;
mod options;
mod overlap;
pub mod particle_filter;
mod path_tree;
pub mod picture;
pub mod random;
pub mod smoothing;
pub mod successive;
mod ties;
pub mod transition_map;
mod visits;
pub mod walk;
pub mod weights;

pub use layout::Layout;
pub use options::{GainSchedule, GridChoice, Norm, OdometryNoise, Options, Start};
pub use path_tree::PathTree;
pub use transition_map::TransitionMap;
pub use walk::{Step, TruthPoint, Walk};
