//! The joint problem on both back ends.

mod agreement;
mod backends_agree;
mod graphs;
mod jacobians;
mod malformed;
mod options;
mod outliers;
mod paper;
mod silence;
mod solving;
