//! What every back end relies on, checked before any of them sees a problem: Ceres would abort on some of it.

use super::factors::PAPER_EPSILON_M;
use super::gauge;
use super::problem::{JointProblem, RelationTerm, RelativeTerm};
use crate::error::{Error, Result};
use crate::solver::Loss;

/// A complaint without its place.
type Check = std::result::Result<(), String>;

impl JointProblem {
    /// Checks indices, numbers, scales and the gauge.
    ///
    /// # Errors
    /// [`Error::Input`] at `joint problem` that names the term.
    pub fn validate(&self) -> Result<()> {
        self.check().map_err(|message| Error::input("joint problem", message))
    }

    fn check(&self) -> Check {
        let numbers =
            self.poses.iter().chain(&self.segments).flatten().chain(self.ends.iter().flatten().flatten());
        if !all_finite(numbers) {
            return Err("start: found a value that is not finite, expected finite numbers".into());
        }
        for (k, [start, end]) in self.ends.iter().enumerate() {
            let length = (end[0] - start[0]).hypot(end[1] - start[1]);
            if !(length > PAPER_EPSILON_M && length.is_finite()) {
                return Err(format!(
                    "segment {k}: found length {length} m, expected more than {PAPER_EPSILON_M} m"
                ));
            }
        }
        let n = self.poses.len();
        let ascending = self.held.windows(2).all(|w| w[0] < w[1]);
        if self.held.is_empty() || !ascending || self.held.iter().any(|&h| h >= n) {
            let held = &self.held[..self.held.len().min(8)];
            return Err(format!("found held poses {held:?}, expected at least one, ascending, below {n}"));
        }
        for (k, t) in self.relatives.iter().enumerate() {
            check_relative(t, n).map_err(|m| format!("relative term {k}: {m}"))?;
        }
        self.check_observations()?;
        for (k, t) in self.relations.iter().enumerate() {
            check_relation(t, self.segments.len()).map_err(|m| format!("relation {k}: {m}"))?;
        }
        for (k, t) in self.paper_relations.iter().enumerate() {
            check_relation(t, self.ends.len()).map_err(|m| format!("paper relation {k}: {m}"))?;
        }
        match gauge::first_loose(self) {
            Some(pose) => Err(format!("found no held pose that pose {pose} is connected to, expected one")),
            None => Ok(()),
        }
    }

    /// R2, R3 and R5.
    fn check_observations(&self) -> Check {
        let (n, m) = (self.poses.len(), self.segments.len());
        for (k, t) in self.sightings.iter().enumerate() {
            check_sighting(t.pose, t.segment, t.scale, n, m)
                .and_then(|()| expect(t.count > 0.0, "a positive number of points"))
                .and_then(|()| finite(t.mean.iter().chain(&t.scatter_root).chain([&t.count])))
                .map_err(|m| format!("sighting {k}: {m}"))?;
        }
        for (k, t) in self.points.iter().enumerate() {
            check_sighting(t.pose, t.segment, t.scale, n, m)
                .and_then(|()| finite(&t.point))
                .map_err(|m| format!("point {k}: {m}"))?;
        }
        for (k, t) in self.ties.iter().enumerate() {
            check_sighting(t.pose, t.segment, t.scale, n, m)
                .and_then(|()| finite(t.mean.iter().chain([&t.along])))
                .map_err(|m| format!("tie {k}: {m}"))?;
        }
        for (k, t) in self.fits.iter().enumerate() {
            let place = |m| format!("fit {k}: {m}");
            let poses = t.sightings.iter().map(|s| s.pose);
            let ascending = t.sightings.windows(2).all(|w| w[0].pose < w[1].pose);
            let seen = !t.sightings.is_empty() && t.sightings.iter().all(|s| !s.points.is_empty());
            expect(ascending, "poses ascending").map_err(place)?;
            expect(seen, "points for every pose").map_err(place)?;
            for pose in poses {
                check_sighting(pose, t.segment, t.scale, n, self.ends.len()).map_err(place)?;
            }
            finite(t.sightings.iter().flat_map(|s| s.points.iter().flatten())).map_err(place)?;
        }
        Ok(())
    }
}

fn check_relative(t: &RelativeTerm, poses: usize) -> Check {
    if t.i >= poses || t.j >= poses || t.i == t.j {
        return Err(format!("found poses {} and {}, expected two different ones below {poses}", t.i, t.j));
    }
    finite(&t.measured)?;
    finite(&t.sqrt_information)?;
    let u = &t.sqrt_information;
    let triangular = u[3] == 0.0 && u[6] == 0.0 && u[7] == 0.0;
    let regular = u[0] > 0.0 && u[4] > 0.0 && u[8] > 0.0;
    expect(triangular && regular, "an upper triangular square root of the information with a diagonal > 0")?;
    check_loss(t.loss)
}

fn check_relation(t: &RelationTerm, segments: usize) -> Check {
    if t.a >= segments || t.b >= segments || t.a == t.b {
        return Err(format!(
            "found segments {} and {}, expected two different ones below {segments}",
            t.a, t.b
        ));
    }
    check_scale(t.offset_scale)?;
    check_scale(t.angle_scale)?;
    check_loss(t.loss)
}

fn check_sighting(pose: usize, segment: usize, scale: f64, poses: usize, segments: usize) -> Check {
    if pose >= poses || segment >= segments {
        return Err(format!(
            "found pose {pose} and segment {segment}, expected ones below {poses} and {segments}"
        ));
    }
    check_scale(scale)
}

fn check_scale(scale: f64) -> Check {
    if scale > 0.0 && scale.is_finite() {
        return Ok(());
    }
    Err(format!("found scale {scale}, expected a number > 0"))
}

fn check_loss(loss: Loss) -> Check {
    match loss.scale() {
        Some(c) if !(c > 0.0 && c.is_finite()) => Err(format!("found loss scale {c}, expected a number > 0")),
        _ => Ok(()),
    }
}

fn finite<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Check {
    expect(all_finite(numbers), "finite numbers")
}

fn all_finite<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> bool {
    numbers.into_iter().all(|v| v.is_finite())
}

fn expect(fine: bool, what: &str) -> Check {
    if fine { Ok(()) } else { Err(format!("expected {what}")) }
}
