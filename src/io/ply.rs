//! PLY point clouds: every return in the world frame, with its normal and the pose that saw it. Written, not read.

use std::path::Path;

use super::atomic;
use super::text::Shortest;
use crate::error::Result;
use crate::map::SlamMap;

/// Writes the points of a map as ASCII PLY: `x y z nx ny nz pose`; z is 0, unknown normals are 0.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, map: &SlamMap) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "ply\nformat ascii 1.0\ncomment hitl-slam, metres, world frame")?;
        writeln!(out, "element vertex {}", map.observations.len())?;
        for name in ["x", "y", "z"] {
            writeln!(out, "property double {name}")?;
        }
        for name in ["nx", "ny", "nz"] {
            writeln!(out, "property float {name}")?;
        }
        writeln!(out, "property int pose\nend_header")?;
        for (i, pose) in map.poses.iter().enumerate() {
            for k in map.observations.range(i) {
                let p = pose.transform_point(map.observations.point(k));
                let n = pose.rotate(map.observations.normal(k));
                let [x, y, nx, ny] = [p.x, p.y, f64::from(n.x as f32), f64::from(n.y as f32)].map(Shortest);
                writeln!(out, "{x} {y} 0 {nx} {ny} 0 {i}")?;
            }
        }
        Ok(())
    })
}
