//! Which way a walker faces, told by a sensor that may be mounted in any way.

use nalgebra::{UnitQuaternion, Vector3};

/// Angle by which a rotation turns about the vertical (its twist), radians in (−π, π].
pub fn turn_about_vertical(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> f64 {
    let q = to * from.inverse();
    crate::geometry::wrap_angle(2.0 * q.k.atan2(q.w))
}

/// The sensor axis that points where the walker goes: the mean of the displacements as the resting sensor before each
/// sees them. `None` if they cancel out.
pub fn forward_axis<'a>(
    legs: impl Iterator<Item = (&'a UnitQuaternion<f64>, &'a Vector3<f64>)>,
) -> Option<Vector3<f64>> {
    let sum = legs.fold(Vector3::zeros(), |sum, (n_from_b, d)| {
        let flat = Vector3::new(d.x, d.y, 0.0);
        sum + n_from_b.inverse() * flat
    });
    sum.try_normalize(1e-6)
}

/// Heading of a sensor axis, radians; `None` where it is vertical.
pub fn of_axis(n_from_b: &UnitQuaternion<f64>, axis: &Vector3<f64>) -> Option<f64> {
    let v = n_from_b * axis;
    (v.x.hypot(v.y) > 0.1).then(|| v.y.atan2(v.x))
}
