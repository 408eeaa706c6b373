//! The error-state filter: its Jacobian against differences, the whole of it against a second implementation.

use hitl_slam::inertial::filter::{
    ATTITUDE, Error15, Filter, Matrix15, Noise, Nominal, POSITION, RATE_BIAS, SIZE, VELOCITY,
};
use hitl_slam::inertial::stance;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::walker::{FootWalk, GRAVITY, Sensor};
use crate::support::Dice;

fn vector(dice: &mut Dice, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| dice.normal(size))
}

fn state(dice: &mut Dice) -> Nominal {
    Nominal {
        position_m: vector(dice, 3.0),
        velocity_mps: vector(dice, 3.0),
        n_from_b: UnitQuaternion::from_scaled_axis(vector(dice, 2.0)),
        force_bias_mps2: vector(dice, 0.3),
        rate_bias_radps: vector(dice, 0.1),
    }
}

#[test]
fn the_transition_is_the_derivative_of_the_motion() {
    let mut dice = Dice::new(5);
    for _ in 0..50 {
        let from = state(&mut dice);
        let (force, rate, dt) = (vector(&mut dice, 15.0), vector(&mut dice, 4.0), 0.01);
        let f = from.transition(force, rate, dt, GRAVITY);
        let reference = from.moved(force, rate, dt, GRAVITY);
        for column in 0..SIZE {
            let mut error = Error15::zeros();
            let h = 1e-5;
            error[column] = h;
            let plus = from.corrected(&error).moved(force, rate, dt, GRAVITY);
            let minus = from.corrected(&-error).moved(force, rate, dt, GRAVITY);
            let difference = (reference.error_to(&plus) - reference.error_to(&minus)) / (2.0 * h);
            let worst = (difference - f.column(column)).amax();
            assert!(worst < 2e-7, "column {column}: {worst}");
        }
    }
}

#[test]
fn a_correction_and_the_error_between_two_states_are_inverse() {
    let mut dice = Dice::new(6);
    for _ in 0..50 {
        let (a, b) = (state(&mut dice), state(&mut dice));
        assert!(a.corrected(&a.error_to(&b)).error_to(&b).amax() < 1e-12);
    }
}

/// The same filter written otherwise: the attitude's error in the *sensor's* axes, every Jacobian by differences, the
/// plain update.
struct Twin {
    nominal: Nominal,
    covariance: Matrix15,
    noise: Noise,
}

impl Twin {
    fn plus(a: &Nominal, error: &Error15) -> Nominal {
        let mut other = a.corrected(error);
        let turn = error.fixed_rows::<3>(ATTITUDE).into_owned();
        other.n_from_b = a.n_from_b * UnitQuaternion::from_scaled_axis(turn);
        other
    }

    fn minus(a: &Nominal, b: &Nominal) -> Error15 {
        let mut error = a.error_to(b);
        let turn = (a.n_from_b.inverse() * b.n_from_b).scaled_axis();
        error.fixed_rows_mut::<3>(ATTITUDE).copy_from(&turn);
        error
    }

    fn predict(&mut self, force: Vector3<f64>, rate: Vector3<f64>, dt: f64) {
        let next = self.nominal.moved(force, rate, dt, GRAVITY);
        let mut f = Matrix15::zeros();
        for column in 0..SIZE {
            let mut e = Error15::zeros();
            e[column] = 1e-5;
            let at = |e: &Error15| {
                Twin::minus(&next, &Twin::plus(&self.nominal, e).moved(force, rate, dt, GRAVITY))
            };
            f.set_column(column, &((at(&e) - at(&-e)) / 2e-5));
        }
        self.nominal = next;
        self.covariance = f * self.covariance * f.transpose();
        let Noise { force, rate, force_bias, rate_bias } = self.noise;
        for (at, q) in [(3, force), (6, rate), (9, force_bias), (12, rate_bias)] {
            (at..at + 3).for_each(|k| self.covariance[(k, k)] += q * dt);
        }
    }

    fn rest(&mut self, sigma: f64) {
        let s = self.covariance.fixed_view::<3, 3>(VELOCITY, VELOCITY) + Matrix3::identity() * sigma * sigma;
        let gain = self.covariance.fixed_columns::<3>(VELOCITY) * s.try_inverse().unwrap();
        self.nominal = Twin::plus(&self.nominal, &(gain * -self.nominal.velocity_mps));
        self.covariance -= gain * self.covariance.fixed_rows::<3>(VELOCITY);
    }
}

#[test]
fn the_filter_agrees_with_a_second_implementation() {
    let walk = FootWalk::random(12, 3);
    let recording =
        walk.recording(&Sensor { rate_bias: Vector3::new(0.003, -0.002, 0.004), ..Sensor::default() }, 4);
    let statistic = stance::statistic(&recording, Vector3::zeros(), GRAVITY);
    let thresholds = vec![1e5; statistic.len()];
    let stances = stance::stances(&recording, &statistic, &thresholds, 1e5);
    let nominal = Nominal::at_rest(recording.samples[0].force_mps2, Vector3::zeros(), GRAVITY);
    let mut covariance = Matrix15::identity() * 1e-4;
    (POSITION..POSITION + 3).for_each(|k| covariance[(k, k)] = 1e-12);
    (RATE_BIAS..SIZE).for_each(|k| covariance[(k, k)] = 1e-5);
    let noise = Noise { force: 2.5e-3, rate: 7.6e-7, force_bias: 1e-6, rate_bias: 1e-10 };
    let mut filter = Filter::new(nominal, covariance, GRAVITY, noise);
    let mut twin = Twin { nominal, covariance, noise };
    for (k, sample) in recording.samples.iter().enumerate().skip(1) {
        let dt = sample.time_s - recording.samples[k - 1].time_s;
        filter.predict(sample.force_mps2, sample.rate_radps, dt, 1.0);
        twin.predict(sample.force_mps2, sample.rate_radps, dt);
        if stances.iter().any(|run| run.contains(&k)) {
            filter.rest(0.01);
            twin.rest(0.01);
        }
    }
    let difference = filter.nominal.error_to(&twin.nominal);
    assert!(walk.stances.len() > 10 && filter.nominal.position_m.norm() > 3.0);
    assert!(difference.fixed_rows::<3>(POSITION).norm() < 2e-3, "{difference}");
    assert!(difference.fixed_rows::<3>(ATTITUDE).norm() < 1e-3, "{difference}");
    for k in (POSITION..ATTITUDE).chain(RATE_BIAS..SIZE) {
        let (ours, theirs) = (filter.covariance[(k, k)], twin.covariance[(k, k)]);
        assert!((ours / theirs - 1.0).abs() < 0.02, "variance {k}: {ours} and {theirs}");
    }
}
