//! Native map, reading: every array is checked for its type, shape and range before it is used.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use nalgebra::Matrix3;
use zip::ZipArchive;

use super::FORMAT_VERSION;
use super::npy::{self, Scalar};
use crate::error::{Error, Result};
use crate::geometry::{Information, Pose2, Segment, Vec2};
use crate::io::Read;
use crate::map::{
    AutomaticFactor, Feature, HumanFactor, Mode, Observations, RelativeFactor, ScanRecord, Sighting, SlamMap,
};

/// Rows for which room is made before they are read: a header may promise anything.
const ROWS_IN_ADVANCE: usize = 1 << 20;

/// Reads a map. Fields that later versions may add are ignored.
///
/// # Errors
/// [`Error::Input`] at `file: field`; [`Error::Io`] if the file cannot be opened.
pub fn read(path: &Path) -> Result<Read<SlamMap>> {
    let file = path.display().to_string();
    let reader = BufReader::new(File::open(path).map_err(|e| Error::io(path, e))?);
    let zip = ZipArchive::new(reader).map_err(|e| {
        Error::input(&file, format_args!("found a damaged or cut-off archive ({e}), expected an .npz file"))
    })?;
    let mut arrays = Arrays { zip, file };
    let version = arrays.column::<i64>("format_version")?;
    if version != [FORMAT_VERSION] {
        let message = format!("found {version:?}, expected [{FORMAT_VERSION}]");
        return Err(arrays.error("format_version", message));
    }
    let poses: Vec<Pose2> = arrays.poses("poses")?;
    let mut map = SlamMap {
        observations: arrays.observations(poses.len())?,
        stamps_s: arrays.optional("stamps")?,
        vertex_ids: arrays.optional("vertex_ids")?,
        held: arrays.indices("held")?,
        relative_factors: arrays.relative_factors("relative")?,
        automatic_factors: arrays.automatic_factors()?,
        scans: arrays.scans()?,
        robot_from_laser: arrays.robot_from_laser()?,
        human_factors: Vec::new(),
        poses,
    };
    map.human_factors = arrays.human_factors()?;
    map.validate(&arrays.file)?;
    Ok(Read { value: map, warnings: Vec::new() })
}

struct Arrays {
    zip: ZipArchive<BufReader<File>>,
    file: String,
}

impl Arrays {
    fn error(&self, field: &str, message: impl std::fmt::Display) -> Error {
        Error::input(format_args!("{}: {field}", self.file), message)
    }

    /// An array of shape (rows, `inner`…), `N` being the product of `inner`.
    fn rows<T: Scalar + Default, const N: usize>(
        &mut self,
        field: &str,
        inner: &[usize],
    ) -> Result<Vec<[T; N]>> {
        self.try_rows(field, inner).map_err(|m| self.error(field, m))
    }

    fn try_rows<T: Scalar + Default, const N: usize>(
        &mut self,
        field: &str,
        inner: &[usize],
    ) -> std::result::Result<Vec<[T; N]>, String> {
        let mut entry = self
            .zip
            .by_name(&format!("{field}.npy"))
            .map_err(|e| format!("found no such array ({e}), expected one"))?;
        let header = npy::read_header(&mut entry)?;
        if header.shape.len() != inner.len() + 1 || header.shape[1..] != *inner {
            let expected: String = inner.iter().map(|d| format!(", {d}")).collect();
            return Err(format!("found shape {:?}, expected [rows{expected}]", header.shape));
        }
        let mut rows = Vec::with_capacity(header.shape[0].min(ROWS_IN_ADVANCE));
        let (mut row, mut filled) = ([T::default(); N], 0);
        npy::read_numbers(&mut entry, &header, |number| {
            let Some(value) = T::from_number(number) else { return false };
            row[filled] = value;
            filled += 1;
            if filled == N {
                rows.push(row);
                filled = 0;
            }
            true
        })?;
        Ok(rows)
    }

    /// An array of shape (rows,).
    fn column<T: Scalar + Default>(&mut self, field: &str) -> Result<Vec<T>> {
        Ok(self.rows::<T, 1>(field, &[])?.into_flattened())
    }

    /// A column that need not be there.
    fn optional<T: Scalar + Default>(&mut self, field: &str) -> Result<Option<Vec<T>>> {
        if self.has(field) { self.column(field).map(Some) } else { Ok(None) }
    }

    fn has(&self, field: &str) -> bool {
        self.zip.index_for_name(&format!("{field}.npy")).is_some()
    }

    /// A column of indices.
    fn indices(&mut self, field: &str) -> Result<Vec<usize>> {
        let column = self.column::<i64>(field)?;
        let converted = column.iter().map(|&v| {
            usize::try_from(v).map_err(|_| self.error(field, format_args!("found {v}, expected 0 or more")))
        });
        converted.collect()
    }

    fn poses(&mut self, field: &str) -> Result<Vec<Pose2>> {
        Ok(self.rows::<f64, 3>(field, &[3])?.into_iter().map(Pose2::from_array).collect())
    }

    fn same_length(&self, field: &str, found: usize, expected: usize, of: &str) -> Result<()> {
        if found == expected {
            return Ok(());
        }
        Err(self.error(field, format_args!("found {found} rows, expected {expected}, as many as {of}")))
    }

    fn observations(&mut self, poses: usize) -> Result<Observations> {
        let points = self.rows::<f64, 2>("points_xy", &[2])?;
        let normals = self.rows::<f32, 2>("points_normal", &[2])?;
        self.same_length("points_normal", normals.len(), points.len(), "points_xy")?;
        let ranges_m = self.column::<f32>("points_range")?;
        self.same_length("points_range", ranges_m.len(), points.len(), "points_xy")?;
        let pose_of = self.column::<i32>("points_pose")?;
        self.same_length("points_pose", pose_of.len(), points.len(), "points_xy")?;
        if u32::try_from(points.len()).is_err() {
            return Err(self.error("points_xy", "found more than 2³² points, expected fewer"));
        }
        let mut starts = Vec::with_capacity(poses + 1);
        starts.push(0);
        for (point, &pose) in pose_of.iter().enumerate() {
            let Some(pose) = usize::try_from(pose).ok().filter(|&p| p < poses && p + 1 >= starts.len())
            else {
                let message =
                    format!("point {point}: found pose {pose}, expected ascending poses below {poses}");
                return Err(self.error("points_pose", message));
            };
            starts.resize(pose + 1, point as u32);
        }
        starts.resize(poses + 1, points.len() as u32);
        Ok(Observations { points, normals, ranges_m, starts })
    }

    fn relative_factors(&mut self, prefix: &str) -> Result<Vec<RelativeFactor>> {
        let names = ["ij", "measured", "information"].map(|field| format!("{prefix}_{field}"));
        let [name_ij, name_measured, name_information] = &names;
        let ij = self.rows::<i32, 2>(name_ij, &[2])?;
        let measured = self.poses(name_measured)?;
        self.same_length(name_measured, measured.len(), ij.len(), name_ij)?;
        let information = self.rows::<f64, 9>(name_information, &[3, 3])?;
        self.same_length(name_information, information.len(), ij.len(), name_ij)?;
        let mut factors = Vec::with_capacity(ij.len());
        for (k, (([i, j], i_from_j), matrix)) in ij.into_iter().zip(measured).zip(information).enumerate() {
            let (Ok(i), Ok(j)) = (usize::try_from(i), usize::try_from(j)) else {
                let message = format!("factor {k}: found poses {i} and {j}, expected 0 or more");
                return Err(self.error(name_ij, message));
            };
            let information = Information::new(Matrix3::from_row_slice(&matrix))
                .map_err(|m| self.error(name_information, format_args!("factor {k}: {m}")))?;
            factors.push(RelativeFactor { i, j, i_from_j, information });
        }
        Ok(factors)
    }

    /// None in maps from before there were any.
    fn automatic_factors(&mut self) -> Result<Vec<AutomaticFactor>> {
        if !self.has("automatic_ij") {
            return Ok(Vec::new());
        }
        let factors = self.relative_factors("automatic")?;
        let mut column = |field: &str| {
            let values = self.column::<f64>(field)?;
            self.same_length(field, values.len(), factors.len(), "automatic_ij").map(|()| values)
        };
        let (inliers, ambiguity) = (column("automatic_inliers")?, column("automatic_ambiguity")?);
        let (weak, chi2) = (column("automatic_weak")?, column("automatic_chi2")?);
        let is_weak = self.column::<u8>("automatic_is_weak")?;
        self.same_length("automatic_is_weak", is_weak.len(), factors.len(), "automatic_ij")?;
        let entry = |(k, factor)| AutomaticFactor {
            factor,
            inliers: inliers[k],
            ambiguity: ambiguity[k],
            weak_rad: (is_weak[k] != 0).then_some(weak[k]),
            chi2: chi2[k],
        };
        Ok(factors.into_iter().enumerate().map(entry).collect())
    }

    fn scans(&mut self) -> Result<Vec<ScanRecord>> {
        let stamps_s = self.column::<f64>("scan_stamp")?;
        let parents = self.indices("scan_parent")?;
        self.same_length("scan_parent", parents.len(), stamps_s.len(), "scan_stamp")?;
        let offsets = self.poses("scan_offset")?;
        self.same_length("scan_offset", offsets.len(), stamps_s.len(), "scan_stamp")?;
        let rows = stamps_s.into_iter().zip(parents).zip(offsets);
        Ok(rows
            .map(|((stamp_s, parent), parent_from_robot)| ScanRecord { stamp_s, parent, parent_from_robot })
            .collect())
    }

    fn robot_from_laser(&mut self) -> Result<Pose2> {
        match *self.column::<f64>("robot_from_laser")? {
            [x, y, theta] if [x, y, theta].iter().all(|v| v.is_finite()) => Ok(Pose2::new(x, y, theta)),
            _ => Err(self.error("robot_from_laser", "expected three finite numbers: x, y, theta")),
        }
    }

    fn human_factors(&mut self) -> Result<Vec<HumanFactor>> {
        let modes = self.column::<u8>("human_mode")?;
        let h = modes.len();
        let weights = self.column::<f64>("human_weight")?;
        self.same_length("human_weight", weights.len(), h, "human_mode")?;
        let ids: Vec<String> = serde_json::from_slice(&self.column::<u8>("human_ids")?).map_err(|e| {
            self.error("human_ids", format_args!("found no list of texts ({e}), expected JSON"))
        })?;
        self.same_length("human_ids", ids.len(), h, "human_mode")?;
        let mut features = self.features(h)?.into_iter();
        let mut factors = Vec::with_capacity(h);
        for ((&mode, weight), id) in modes.iter().zip(weights).zip(ids) {
            let Some(&mode) = Mode::ALL.get(usize::from(mode)) else {
                return Err(
                    self.error("human_mode", format_args!("{id}: found code {mode}, expected 0 to 3"))
                );
            };
            let (Some(a), Some(b)) = (features.next(), features.next()) else {
                return Err(self.error("human_segment", format_args!("{id}: found no features")));
            };
            factors.push(HumanFactor { id, mode, weight, a, b });
        }
        Ok(factors)
    }

    /// Both features of `h` factors: a, b, a, b, …
    fn features(&mut self, h: usize) -> Result<Vec<Feature>> {
        let segments = self.rows::<f64, 8>("human_segment", &[2, 4])?;
        self.same_length("human_segment", segments.len(), h, "human_mode")?;
        let points = self.column::<u32>("human_points")?;
        let point_starts = self.starts("human_points_start", h, points.len())?;
        let poses = self.indices("human_sighting_pose")?;
        let along_m = self.column::<f64>("human_sighting_along")?;
        self.same_length("human_sighting_along", along_m.len(), poses.len(), "human_sighting_pose")?;
        let tied = self.column::<u8>("human_sighting_tied")?;
        self.same_length("human_sighting_tied", tied.len(), poses.len(), "human_sighting_pose")?;
        let bearing_rad = self.column::<f64>("human_sighting_bearing")?;
        self.same_length("human_sighting_bearing", bearing_rad.len(), poses.len(), "human_sighting_pose")?;
        let sighting_starts = self.starts("human_sighting_start", h, poses.len())?;
        let sighting = |k: usize| Sighting {
            pose: poses[k],
            along_m: along_m[k],
            tied: tied[k] != 0,
            bearing_rad: bearing_rad[k],
        };
        let features = segments.as_flattened().chunks_exact(4).enumerate().map(|(k, s)| Feature {
            segment: Segment { centre: Vec2::new(s[0], s[1]), direction_rad: s[2], half_length_m: s[3] },
            points: points[point_starts[k]..point_starts[k + 1]].to_vec(),
            sightings: (sighting_starts[k]..sighting_starts[k + 1]).map(sighting).collect(),
        });
        Ok(features.collect())
    }

    /// Bounds of `2h` groups that cover `length` rows.
    fn starts(&mut self, field: &str, h: usize, length: usize) -> Result<Vec<usize>> {
        let starts = self.indices(field)?;
        let is_sound = starts.len() == 2 * h + 1
            && starts.first() == Some(&0)
            && starts.last() == Some(&length)
            && starts.windows(2).all(|w| w[0] <= w[1]);
        if is_sound {
            return Ok(starts);
        }
        let expected = 2 * h + 1;
        Err(self.error(field, format_args!("expected {expected} ascending bounds from 0 to {length}")))
    }
}
