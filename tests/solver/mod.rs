mod covariance;
mod linear;
