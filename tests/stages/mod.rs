mod copslam;
mod explicit;
mod interpret;
pub mod random;
