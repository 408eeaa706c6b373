mod copslam;
mod explicit;
mod interpret;
