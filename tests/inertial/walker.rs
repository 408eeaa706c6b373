//! A simulated foot (and a hand) with an inertial sensor: the motion is a formula, what the sensor feels its derivatives.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::inertial::{Recording, Sample};
use nalgebra::{UnitQuaternion, Vector3};

use crate::support::Dice;

pub const GRAVITY: f64 = 9.80665;
/// Standing before the first step, and after the last, seconds.
pub const STANDS_S: f64 = 2.0;
const SWING_S: f64 = 0.55;
const STANCE_S: f64 = 0.5;
const HEEL_PITCH_RAD: f64 = 0.9;

/// How the sensor and its mounting are.
#[derive(Clone)]
pub struct Sensor {
    pub rate_hz: f64,
    pub foot_from_sensor: UnitQuaternion<f64>,
    pub force_bias: Vector3<f64>,
    pub rate_bias: Vector3<f64>,
    pub force_noise: f64,
    pub rate_noise: f64,
}

impl Default for Sensor {
    fn default() -> Self {
        Sensor {
            rate_hz: 200.0,
            foot_from_sensor: UnitQuaternion::identity(),
            force_bias: Vector3::zeros(),
            rate_bias: Vector3::zeros(),
            force_noise: 0.03,
            rate_noise: 0.003,
        }
    }
}

/// Strides: pose of the foot at every stance, the first included.
pub struct FootWalk {
    pub stances: Vec<Pose2>,
}

impl FootWalk {
    /// `strides` of about 1.3 m with turns at random.
    pub fn random(strides: usize, seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let mut stances = vec![Pose2::new(0.0, 0.0, 0.0)];
        for _ in 0..strides {
            let turn = if dice.uniform(0.0, 1.0) < 0.15 {
                dice.uniform(-1.4, 1.4)
            } else {
                dice.uniform(-0.05, 0.05)
            };
            let step = Pose2::new(dice.uniform(1.1, 1.5), dice.uniform(-0.05, 0.05), turn);
            stances.push(stances[stances.len() - 1].compose(step));
        }
        FootWalk { stances }
    }

    pub fn duration_s(&self) -> f64 {
        2.0 * STANDS_S + (self.stances.len() - 1) as f64 * (SWING_S + STANCE_S) - STANCE_S
    }

    /// When stride k lands, k from 1.
    pub fn lands_s(&self, k: usize) -> f64 {
        STANDS_S + (k - 1) as f64 * (SWING_S + STANCE_S) + SWING_S
    }

    /// Position and attitude of the foot.
    fn at(&self, time_s: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let since = (time_s - STANDS_S).max(0.0);
        let stride = ((since / (SWING_S + STANCE_S)) as usize).min(self.stances.len() - 1);
        let from = self.stances[stride];
        let to = self.stances[(stride + 1).min(self.stances.len() - 1)];
        let tau = ((since - stride as f64 * (SWING_S + STANCE_S)) / SWING_S).clamp(0.0, 1.0);
        // Minimum jerk; lift and pitch leave and reach zero smoothly too.
        let s = tau.powi(3) * (10.0 - 15.0 * tau + 6.0 * tau * tau);
        let bump = 64.0 * tau.powi(3) * (1.0 - tau).powi(3);
        let p = from.translation() + (to.translation() - from.translation()) * s;
        let yaw = from.theta_rad + s * hitl_slam::geometry::angle_diff(to.theta_rad, from.theta_rad);
        let pitch = HEEL_PITCH_RAD * bump * (std::f64::consts::TAU * tau).sin();
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw)
            * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), pitch);
        (Vector3::new(p.x, p.y, 0.12 * bump), attitude)
    }

    /// What the sensor records.
    pub fn recording(&self, sensor: &Sensor, seed: u64) -> Recording {
        let mut dice = Dice::new(seed);
        let count = (self.duration_s() * sensor.rate_hz) as usize;
        let samples =
            (0..count).map(|k| sense(&|t| self.at(t), k as f64 / sensor.rate_hz, sensor, &mut dice));
        Recording { samples: samples.collect() }
    }

    /// Positions of the stances.
    pub fn positions(&self) -> Vec<Vec2> {
        self.stances.iter().map(|p| p.translation()).collect()
    }
}

/// A hand-held sensor on a walk of `steps` steps of 0.7 m and 0.5 s along a circle, the walker standing at both ends.
pub fn hand_recording(steps: usize, turn_per_step: f64, swing: f64, sensor: &Sensor, seed: u64) -> Recording {
    let mut dice = Dice::new(seed);
    let end_s = STANDS_S + steps as f64 * 0.5;
    let phase = move |t: f64| ((t - STANDS_S) / 0.5).clamp(0.0, steps as f64);
    let at = move |t: f64| {
        let steps_done = phase(t);
        // A vertical cosine whose acceleration swings by `swing` peak to peak.
        let amplitude = 0.5 * swing / (std::f64::consts::TAU / 0.5).powi(2);
        let height = -amplitude * (std::f64::consts::TAU * steps_done).cos();
        let yaw = turn_per_step * steps_done;
        let tilt = 0.03 * (std::f64::consts::PI * steps_done).sin();
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), tilt);
        (Vector3::new(0.0, 0.0, height), attitude)
    };
    let count = ((end_s + STANDS_S) * sensor.rate_hz) as usize;
    let samples = (0..count).map(|k| sense(&at, k as f64 / sensor.rate_hz, sensor, &mut dice));
    Recording { samples: samples.collect() }
}

/// Differences over 0.1 ms to both sides stand for the derivatives.
fn sense(
    at: &dyn Fn(f64) -> (Vector3<f64>, UnitQuaternion<f64>),
    time_s: f64,
    sensor: &Sensor,
    dice: &mut Dice,
) -> Sample {
    const H: f64 = 1e-4;
    let ((before, q0), (here, q), (after, q1)) = (at(time_s - H), at(time_s), at(time_s + H));
    let acceleration = (after - here * 2.0 + before) / (H * H);
    let force = q.inverse() * (acceleration + Vector3::z() * GRAVITY);
    let rate = (q0.inverse() * q1).scaled_axis() / (2.0 * H);
    let to_sensor = sensor.foot_from_sensor.inverse();
    let mut noise = |sigma: f64| Vector3::from_fn(|_, _| dice.normal(sigma));
    Sample {
        time_s,
        force_mps2: to_sensor * force + sensor.force_bias + noise(sensor.force_noise),
        rate_radps: to_sensor * rate + sensor.rate_bias + noise(sensor.rate_noise),
    }
}
