mod covariance;
mod incremental;
mod linear;
