mod covariance;
mod incremental;
mod linear;
mod reweighing;
