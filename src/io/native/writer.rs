//! Native map, writing: array after array, straight from the map, so that nothing is copied.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::FORMAT_VERSION;
use super::npy::{self, Scalar};
use crate::error::{Error, Result};
use crate::io::atomic;
use crate::map::{AutomaticFactor, Feature, HumanFactor, RelativeFactor, SlamMap};

/// Writes everything that a map holds.
///
/// # Errors
/// [`Error::Input`] if the map has more poses than the format's 32-bit indices can name, [`Error::Io`] if the file cannot be written.
pub fn write(path: &Path, map: &SlamMap) -> Result<()> {
    if i32::try_from(map.poses.len()).is_err() {
        let message = format!("found {} poses, expected at most 2³¹ − 1", map.poses.len());
        return Err(Error::input(format_args!("{}: poses", path.display()), message));
    }
    let ids: Vec<&str> = map.human_factors.iter().map(|f| f.id.as_str()).collect();
    let ids = serde_json::to_vec(&ids).map_err(|e| Error::Internal(e.to_string()))?;
    write_arrays(path, |arrays| {
        arrays.write_graph(map)?;
        arrays.write_automatic_factors(&map.automatic_factors)?;
        arrays.write_points(map)?;
        arrays.write_human_factors(&map.human_factors, &ids)
    })
}

/// Writes a `.npz` with the arrays that `fill` puts into it.
pub(in crate::io) fn write_arrays(
    path: &Path,
    fill: impl FnOnce(&mut Arrays) -> io::Result<()>,
) -> Result<()> {
    atomic::write_seekable(path, |out| {
        let mut arrays = Arrays { zip: ZipWriter::new(out) };
        fill(&mut arrays)?;
        arrays.zip.finish()?;
        Ok(())
    })
}

/// A `.npz` that is being written.
pub(in crate::io) struct Arrays<'a> {
    zip: ZipWriter<&'a mut BufWriter<File>>,
}

impl Arrays<'_> {
    /// Adds an array; `values` yields as many numbers as `shape` says.
    pub(in crate::io) fn put<T: Scalar>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        let bytes = shape.iter().product::<usize>() as u64 * T::BYTES as u64;
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644)
            .large_file(bytes > u64::from(u32::MAX) - (1 << 17));
        self.zip.start_file(format!("{name}.npy"), options)?;
        npy::write(&mut self.zip as &mut dyn Write, shape, values)
    }

    fn write_graph(&mut self, map: &SlamMap) -> io::Result<()> {
        let (n, m, k) = (map.poses.len(), map.relative_factors.len(), map.scans.len());
        self.put("format_version", &[1], [FORMAT_VERSION])?;
        self.put("poses", &[n, 3], map.poses.iter().flat_map(|p| p.to_array()))?;
        if let Some(stamps_s) = &map.stamps_s {
            self.put("stamps", &[n], stamps_s.iter().copied())?;
        }
        if let Some(ids) = &map.vertex_ids {
            self.put("vertex_ids", &[n], ids.iter().copied())?;
        }
        self.put("held", &[map.held.len()], map.held.iter().map(|&h| h as i32))?;
        self.put_factors("relative", m, || map.relative_factors.iter())?;
        self.put("scan_stamp", &[k], map.scans.iter().map(|s| s.stamp_s))?;
        self.put("scan_parent", &[k], map.scans.iter().map(|s| s.parent as i32))?;
        self.put("scan_offset", &[k, 3], map.scans.iter().flat_map(|s| s.parent_from_robot.to_array()))?;
        self.put("robot_from_laser", &[3], map.robot_from_laser.to_array())
    }

    /// The three arrays of `count` relative factors.
    fn put_factors<'a, I: Iterator<Item = &'a RelativeFactor>>(
        &mut self,
        prefix: &str,
        count: usize,
        factors: impl Fn() -> I,
    ) -> io::Result<()> {
        let name = |field: &str| format!("{prefix}_{field}");
        self.put(&name("ij"), &[count, 2], factors().flat_map(|f| [f.i as i32, f.j as i32]))?;
        self.put(&name("measured"), &[count, 3], factors().flat_map(|f| f.i_from_j.to_array()))?;
        let rows = |f: &RelativeFactor| f.information.matrix().transpose().data.0;
        let entries = factors().flat_map(|f| rows(f).into_iter().flatten());
        self.put(&name("information"), &[count, 3, 3], entries)
    }

    fn write_automatic_factors(&mut self, factors: &[AutomaticFactor]) -> io::Result<()> {
        let n = factors.len();
        self.put_factors("automatic", n, || factors.iter().map(|a| &a.factor))?;
        self.put("automatic_inliers", &[n], factors.iter().map(|a| a.inliers))?;
        self.put("automatic_ambiguity", &[n], factors.iter().map(|a| a.ambiguity))?;
        self.put("automatic_is_weak", &[n], factors.iter().map(|a| u8::from(a.weak_rad.is_some())))?;
        self.put("automatic_weak", &[n], factors.iter().map(|a| a.weak_rad.unwrap_or(0.0)))?;
        self.put("automatic_chi2", &[n], factors.iter().map(|a| a.chi2))
    }

    fn write_points(&mut self, map: &SlamMap) -> io::Result<()> {
        let o = &map.observations;
        let p = o.len();
        self.put("points_xy", &[p, 2], o.points.iter().flatten().copied())?;
        self.put("points_normal", &[p, 2], o.normals.iter().flatten().copied())?;
        self.put("points_range", &[p], o.ranges_m.iter().copied())?;
        let pose_of = (0..map.poses.len()).flat_map(|pose| o.range(pose).map(move |_| pose as i32));
        self.put("points_pose", &[p], pose_of)
    }

    fn write_human_factors(&mut self, factors: &[HumanFactor], ids: &[u8]) -> io::Result<()> {
        let h = factors.len();
        let features = || factors.iter().flat_map(|f| [&f.a, &f.b]);
        let code =
            |f: &HumanFactor| crate::map::Mode::ALL.iter().position(|&m| m == f.mode).unwrap_or(0) as u8;
        self.put("human_mode", &[h], factors.iter().map(code))?;
        self.put("human_weight", &[h], factors.iter().map(|f| f.weight))?;
        self.put("human_ids", &[ids.len()], ids.iter().copied())?;
        let segment = |f: &Feature| {
            let s = &f.segment;
            [s.centre.x, s.centre.y, s.direction_rad, s.half_length_m]
        };
        self.put("human_segment", &[h, 2, 4], features().flat_map(segment))?;
        let starts = |length: fn(&Feature) -> usize| {
            let mut sum = 0;
            std::iter::once(0).chain(features().map(move |f| {
                sum += length(f) as i64;
                sum
            }))
        };
        let points = features().map(|f| f.points.len()).sum();
        self.put("human_points_start", &[2 * h + 1], starts(|f| f.points.len()))?;
        self.put("human_points", &[points], features().flat_map(|f| f.points.iter().copied()))?;
        let sightings = || features().flat_map(|f| &f.sightings);
        let count = sightings().count();
        self.put("human_sighting_start", &[2 * h + 1], starts(|f| f.sightings.len()))?;
        self.put("human_sighting_pose", &[count], sightings().map(|s| s.pose as i32))?;
        self.put("human_sighting_along", &[count], sightings().map(|s| s.along_m))?;
        self.put("human_sighting_tied", &[count], sightings().map(|s| u8::from(s.tied)))?;
        self.put("human_sighting_bearing", &[count], sightings().map(|s| s.bearing_rad))
    }
}
