//! Repairs bent 2D lidar maps with a person's help.
//!
//! An implementation of *Human-in-the-Loop SLAM* (Nashed & Biswas, AAAI 2018). The modules follow the pipeline:
//!
//! [`io`] reads a log or map → [`front_end`] makes the pose chain → [`map`] is the factor graph →
//! [`interpret`] finds out what two strokes meant (EM) → [`explicit`] moves the map as they say →
//! [`copslam`] spreads the jump over the loop → [`joint`] optimises poses and human factors together →
//! [`metrics`] and [`render`] show what came out. [`pipeline`] is the whole of it in one call,
//! [`session`] a person's work with it, event by event.
//!
//! Metres, radians, seconds; tangent order (x, y, θ). Conventions: `docs/CONVENTIONS.md`; formulas: `docs/MATH.md`.

#![deny(missing_docs, unsafe_code)]

pub mod closures;
pub mod contradictions;
pub mod copslam;
pub mod crosscheck;
pub mod error;
pub mod explicit;
pub mod front_end;
pub mod geometry;
pub mod inertial;
pub mod interpret;
pub mod io;
pub mod joint;
pub mod map;
pub mod metrics;
pub mod pedestrian;
pub mod pipeline;
pub mod render;
pub mod scan_match;
#[cfg(feature = "serve")]
pub mod serve;
pub mod session;
pub mod sights;
pub mod simulate;
pub mod solver;
pub mod suggest;
