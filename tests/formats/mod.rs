//! Readers and writers.

mod atomic;
mod carmen;
mod corrections;
mod detect;
mod export;
mod g2o;
mod native;
mod prefixes;
mod stfs;
mod toro;
mod tum;
