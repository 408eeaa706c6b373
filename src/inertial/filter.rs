//! A strapdown solution with its error: a 15-state error-state Kalman filter with zero-velocity updates (Foxlin 2005;
//! Skog, Händel, Nilsson, Rantakokko 2010).
//!
//! Nominal state: p, v (navigation frame, z up), R = n_from_b, biases b_a, b_ω. Error δ = (δp, δv, δθ, δb_a, δb_ω) with
//! p = p̂ + δp, v = v̂ + δv, R = Exp(δθ) R̂, b = b̂ + δb: the attitude's error is in the navigation frame.

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

/// The error's size.
pub const SIZE: usize = 15;
/// Error vector, (δp, δv, δθ, δb_a, δb_ω).
pub type Error15 = SVector<f64, SIZE>;
/// Its covariance, or a map of errors.
pub type Matrix15 = SMatrix<f64, SIZE, SIZE>;

/// Where each part of the error begins.
pub const POSITION: usize = 0;
/// δv.
pub const VELOCITY: usize = 3;
/// δθ.
pub const ATTITUDE: usize = 6;
/// δb_a.
pub const FORCE_BIAS: usize = 9;
/// δb_ω.
pub const RATE_BIAS: usize = 12;

/// The nominal state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nominal {
    /// p, metres.
    pub position_m: Vector3<f64>,
    /// v, m/s.
    pub velocity_mps: Vector3<f64>,
    /// R.
    pub n_from_b: UnitQuaternion<f64>,
    /// b_a, m/s².
    pub force_bias_mps2: Vector3<f64>,
    /// b_ω, rad/s.
    pub rate_bias_radps: Vector3<f64>,
}

impl Nominal {
    /// At rest at the origin, level by the mean specific force; what that is too long or short for gravity is bias.
    pub fn at_rest(force_mps2: Vector3<f64>, rate_bias_radps: Vector3<f64>, gravity_mps2: f64) -> Self {
        let up = Vector3::z();
        let level = UnitQuaternion::rotation_between(&force_mps2, &up);
        let norm = force_mps2.norm().max(1e-9);
        Nominal {
            position_m: Vector3::zeros(),
            velocity_mps: Vector3::zeros(),
            // Upside down, any horizontal axis serves.
            n_from_b: level
                .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)),
            force_bias_mps2: force_mps2 * (1.0 - gravity_mps2 / norm),
            rate_bias_radps,
        }
    }

    /// Acceleration of the sensor over `dt` seconds, navigation frame: with the attitude in the middle of them.
    fn acceleration(&self, force: Vector3<f64>, rate: Vector3<f64>, dt: f64, gravity: f64) -> Vector3<f64> {
        let half = UnitQuaternion::from_scaled_axis((rate - self.rate_bias_radps) * (0.5 * dt));
        (self.n_from_b * half) * (force - self.force_bias_mps2) - Vector3::z() * gravity
    }

    /// The state after `dt` seconds with this mean specific force and mean rate.
    pub fn moved(&self, force: Vector3<f64>, rate: Vector3<f64>, dt: f64, gravity: f64) -> Self {
        let a = self.acceleration(force, rate, dt, gravity);
        Nominal {
            position_m: self.position_m + self.velocity_mps * dt + a * (0.5 * dt * dt),
            velocity_mps: self.velocity_mps + a * dt,
            n_from_b: self.n_from_b * UnitQuaternion::from_scaled_axis((rate - self.rate_bias_radps) * dt),
            ..*self
        }
    }

    /// F: how an error before [`Nominal::moved`] shows after it.
    pub fn transition(&self, force: Vector3<f64>, rate: Vector3<f64>, dt: f64, gravity: f64) -> Matrix15 {
        let a_force = self.acceleration(force, rate, dt, gravity) + Vector3::z() * gravity;
        let turn = (rate - self.rate_bias_radps) * dt;
        let start = self.n_from_b.to_rotation_matrix().into_inner();
        let middle =
            (self.n_from_b * UnitQuaternion::from_scaled_axis(turn * 0.5)).to_rotation_matrix().into_inner();
        let lever = cross(a_force);
        // A bias of the rate turns the end by −R J(φ) δb dt, and the middle by about half of it.
        let end_turn = start * left_jacobian(turn) * -dt;
        let middle_turn = start * left_jacobian(turn * 0.5) * (-0.5 * dt);
        let mut f = Matrix15::identity();
        let mut set = |row: usize, column: usize, block: Matrix3<f64>| {
            f.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        set(POSITION, VELOCITY, Matrix3::identity() * dt);
        for (row, factor) in [(VELOCITY, dt), (POSITION, 0.5 * dt * dt)] {
            set(row, ATTITUDE, lever * -factor);
            set(row, FORCE_BIAS, middle * -factor);
            set(row, RATE_BIAS, lever * middle_turn * -factor);
        }
        set(ATTITUDE, RATE_BIAS, end_turn);
        f
    }

    /// The state that differs from this one by δ.
    pub fn corrected(&self, error: &Error15) -> Self {
        let part = |at: usize| error.fixed_rows::<3>(at).into_owned();
        let turned = UnitQuaternion::from_scaled_axis(part(ATTITUDE)) * self.n_from_b;
        Nominal {
            position_m: self.position_m + part(POSITION),
            velocity_mps: self.velocity_mps + part(VELOCITY),
            n_from_b: UnitQuaternion::new_normalize(turned.into_inner()),
            force_bias_mps2: self.force_bias_mps2 + part(FORCE_BIAS),
            rate_bias_radps: self.rate_bias_radps + part(RATE_BIAS),
        }
    }

    /// The δ that leads from this state to another.
    pub fn error_to(&self, other: &Nominal) -> Error15 {
        let mut error = Error15::zeros();
        let mut set = |at: usize, value: Vector3<f64>| error.fixed_rows_mut::<3>(at).copy_from(&value);
        set(POSITION, other.position_m - self.position_m);
        set(VELOCITY, other.velocity_mps - self.velocity_mps);
        set(ATTITUDE, (other.n_from_b * self.n_from_b.inverse()).scaled_axis());
        set(FORCE_BIAS, other.force_bias_mps2 - self.force_bias_mps2);
        set(RATE_BIAS, other.rate_bias_radps - self.rate_bias_radps);
        error
    }
}

/// White noise per sample, as variances per second (spectral densities), and how the biases wander.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Of the specific force, (m/s²)² s.
    pub force: f64,
    /// Of the rate, (rad/s)² s.
    pub rate: f64,
    /// Of b_a's change, (m/s²)²/s.
    pub force_bias: f64,
    /// Of b_ω's change, (rad/s)²/s.
    pub rate_bias: f64,
}

/// The filter.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    /// The state.
    pub nominal: Nominal,
    /// Its error's covariance.
    pub covariance: Matrix15,
    gravity_mps2: f64,
    noise: Noise,
}

impl Filter {
    /// A filter that starts in a state.
    pub fn new(nominal: Nominal, covariance: Matrix15, gravity_mps2: f64, noise: Noise) -> Self {
        Filter { nominal, covariance, gravity_mps2, noise }
    }

    /// `dt` seconds with this mean specific force and mean rate; `factor` ≥ 1 multiplies the noise's variance.
    pub fn predict(&mut self, force: Vector3<f64>, rate: Vector3<f64>, dt: f64, factor: f64) {
        let f = self.nominal.transition(force, rate, dt, self.gravity_mps2);
        self.nominal = self.nominal.moved(force, rate, dt, self.gravity_mps2);
        self.covariance = f * self.covariance * f.transpose();
        let Noise { force, rate, force_bias, rate_bias } = self.noise;
        for (at, variance) in [
            (VELOCITY, factor * force * dt),
            (ATTITUDE, factor * rate * dt),
            (FORCE_BIAS, force_bias * dt),
            (RATE_BIAS, rate_bias * dt),
        ] {
            (at..at + 3).for_each(|k| self.covariance[(k, k)] += variance);
        }
    }

    /// More doubt about velocity and attitude: variances per axis, (m/s)² and rad².
    pub fn doubt(&mut self, velocity: f64, attitude: f64) {
        for (at, variance) in [(VELOCITY, velocity), (ATTITUDE, attitude)] {
            (at..at + 3).for_each(|k| self.covariance[(k, k)] += variance);
        }
    }

    /// The foot rests: v = 0 with standard deviation `sigma_mps` per axis.
    pub fn rest(&mut self, sigma_mps: f64) {
        self.update(VELOCITY, -self.nominal.velocity_mps, sigma_mps);
    }

    /// Nothing turns: the measured rate is the bias, with standard deviation `sigma_radps` per axis.
    pub fn stop_turning(&mut self, rate: Vector3<f64>, sigma_radps: f64) {
        self.update(RATE_BIAS, rate - self.nominal.rate_bias_radps, sigma_radps);
    }

    /// A measurement of three components of the error from `at` on: z = H δ + noise, H = I there. Joseph form.
    fn update(&mut self, at: usize, z: Vector3<f64>, sigma: f64) {
        let mut h = SMatrix::<f64, 3, SIZE>::zeros();
        h.fixed_view_mut::<3, 3>(0, at).fill_diagonal(1.0);
        let r = Matrix3::identity() * sigma.powi(2);
        let s = h * self.covariance * h.transpose() + r;
        let Some(inverse) = s.cholesky().map(|c| c.inverse()) else { return };
        let gain = self.covariance * h.transpose() * inverse;
        self.nominal = self.nominal.corrected(&(gain * z));
        let keep = Matrix15::identity() - gain * h;
        let joseph = keep * self.covariance * keep.transpose() + gain * r * gain.transpose();
        self.covariance = (joseph + joseph.transpose()) * 0.5;
    }

    /// Makes here the origin: position and heading are known from now on, so that what the filter then says of them is
    /// relative to this place (Nilsson, Zachariah, Skog, Händel 2013).
    pub fn begin_here(&mut self) {
        self.nominal.position_m = Vector3::zeros();
        for known in [POSITION, POSITION + 1, POSITION + 2, ATTITUDE + 2] {
            self.covariance.row_mut(known).fill(0.0);
            self.covariance.column_mut(known).fill(0.0);
        }
    }
}

/// The matrix of v×.
pub fn cross(v: Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// J_l(φ): Exp(φ + δ) ≈ Exp(J_l δ) Exp(φ), to fourth order in φ (a sample's turn is small).
fn left_jacobian(turn: Vector3<f64>) -> Matrix3<f64> {
    let k = cross(turn);
    Matrix3::identity() + k * 0.5 + k * k / 6.0 + k * k * k / 24.0
}
