//! Information matrices Ω = Σ⁻¹ of SE(2) measurements: 3×3, order (x, y, θ), in the frame of the measurement.

use nalgebra::{Matrix3, Vector3};

use super::Vec2;

/// Smallest eigenvalue of a repaired matrix, as a share of the largest magnitude.
const NEAREST_FLOOR: f64 = 1e-9;

/// A symmetric positive semi-definite 3×3 information matrix, with U such that UᵀU = Ω.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Information {
    matrix: Matrix3<f64>,
}

impl Information {
    /// Checks that `matrix` is finite, symmetric (to 1e-6 of its largest entry) and positive definite.
    ///
    /// # Errors
    /// One sentence that says what is wrong, without a place.
    pub fn new(matrix: Matrix3<f64>) -> Result<Self, String> {
        if !matrix.iter().all(|v| v.is_finite()) {
            return Err(
                "information matrix: found a value that is not finite, expected finite numbers".into()
            );
        }
        if (matrix - matrix.transpose()).amax() > 1e-6 * matrix.amax() {
            return Err("information matrix: found an asymmetric matrix, expected a symmetric one".into());
        }
        let symmetric = (matrix + matrix.transpose()) / 2.0;
        if symmetric.cholesky().is_none() {
            return Err("information matrix: found one that is not positive definite, expected a positive definite one".into());
        }
        Ok(Information { matrix: symmetric })
    }

    /// The positive definite matrix nearest to a symmetric one (in the Frobenius norm), for files that hold what no
    /// measurement can have: eigenvalues below 1e-9 of the largest magnitude are raised to it. What has no positive eigenvalue is left with
    /// next to no information.
    ///
    /// # Errors
    /// As [`Information::new`], for a matrix that is not finite, not symmetric or zero.
    pub fn nearest(matrix: Matrix3<f64>) -> Result<Self, String> {
        if !matrix.iter().all(|v| v.is_finite()) {
            return Information::new(matrix);
        }
        let mut eigen = matrix.symmetric_eigen();
        let floor = NEAREST_FLOOR * eigen.eigenvalues.amax();
        eigen.eigenvalues.apply(|v| *v = v.max(floor));
        Information::new(eigen.recompose())
    }

    /// Diagonal information from standard deviations (metres, metres, radians), all > 0.
    pub fn from_sigmas(sigma_x_m: f64, sigma_y_m: f64, sigma_theta_rad: f64) -> Self {
        let d = Vector3::new(sigma_x_m, sigma_y_m, sigma_theta_rad).map(|s| 1.0 / (s * s));
        Information { matrix: Matrix3::from_diagonal(&d) }
    }

    /// From a covariance.
    ///
    /// # Errors
    /// As [`Information::new`]; also if the covariance cannot be inverted.
    pub fn from_covariance(covariance: Matrix3<f64>) -> Result<Self, String> {
        match covariance.cholesky() {
            Some(c) => Information::new(c.inverse()),
            None => {
                Err("covariance: found one that is not positive definite, expected a positive definite one"
                    .into())
            }
        }
    }

    /// Ω.
    pub fn matrix(&self) -> Matrix3<f64> {
        self.matrix
    }

    /// Σ = Ω⁻¹.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.matrix.cholesky().map_or_else(Matrix3::zeros, |c| c.inverse())
    }

    /// Upper triangular U with **UᵀU = Ω**: the whitened residual is U·e.
    pub fn sqrt(&self) -> Matrix3<f64> {
        // Positive definite since it was made; written out, for every relative factor of a map needs it at every correction.
        let m = &self.matrix;
        let u00 = m[(0, 0)].sqrt();
        let (u01, u02) = (m[(0, 1)] / u00, m[(0, 2)] / u00);
        let u11 = (m[(1, 1)] - u01 * u01).sqrt();
        let u12 = (m[(1, 2)] - u01 * u02) / u11;
        let u22 = (m[(2, 2)] - u02 * u02 - u12 * u12).sqrt();
        Matrix3::new(u00, u01, u02, 0.0, u11, u12, 0.0, 0.0, u22)
    }

    /// Ω for the same measurement with its translation axes turned by `angle_rad`: R Ω Rᵀ.
    pub fn rotated(&self, angle_rad: f64) -> Self {
        let (s, c) = angle_rad.sin_cos();
        let r = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        let turned = r * self.matrix * r.transpose();
        // Rounding must not leave it asymmetric in the last bit: maps are written and read bit for bit.
        Information { matrix: (turned + turned.transpose()) / 2.0 }
    }

    /// eᵀΩe.
    pub fn chi2(&self, translation_error: Vec2, angle_error_rad: f64) -> f64 {
        let e = Vector3::new(translation_error.x, translation_error.y, angle_error_rad);
        (e.transpose() * self.matrix * e)[0]
    }
}

/// Isotropic variances of a covariance: (mean of the two translation variances in m², angle variance in rad²).
pub fn isotropic_variances(covariance: &Matrix3<f64>) -> (f64, f64) {
    ((covariance[(0, 0)] + covariance[(1, 1)]) / 2.0, covariance[(2, 2)])
}
