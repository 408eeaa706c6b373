//! Laws that the geometry must obey, on random input, headings near ±π among it.

use std::f64::consts::PI;

use hitl_slam::geometry::{
    Information, Pose2, Scatter, Segment, Vec2, angle_diff, cos_sin, cos_sin_of, wrap_angle,
};
use nalgebra::Matrix3;

use crate::support::Dice;

#[test]
fn wrapped_angles_lie_in_the_half_open_circle_and_keep_their_direction() {
    let mut random = Dice::new(1);
    for k in -7..=7 {
        assert!((wrap_angle(f64::from(k) * 2.0 * PI)).abs() < 1e-14 * 7.0 * 6.3);
        let odd = wrap_angle(f64::from(2 * k + 1) * PI);
        assert!(odd > -PI && odd <= PI && (odd.abs() - PI).abs() < 1e-13);
    }
    assert_eq!(wrap_angle(-PI), PI);
    for _ in 0..10_000 {
        let angle = random.uniform(-100.0, 100.0);
        let wrapped = wrap_angle(angle);
        assert!(wrapped > -PI && wrapped <= PI);
        assert!((wrapped.sin() - angle.sin()).abs() < 1e-12 && (wrapped.cos() - angle.cos()).abs() < 1e-12);
    }
}

#[test]
fn our_cosine_and_sine_are_the_librarys_up_to_the_last_digit() {
    let mut random = Dice::new(7);
    let quarters = (-4000..4000).map(|k| f64::from(k) * PI / 4.0);
    let wild = [0.0, -0.0, 1e-300, PI, -PI, 1.6e6, -1.7e6, 1e15, 1e300];
    let drawn: Vec<f64> = (0..100_000).map(|k| random.uniform(-4.0, 4.0) * [1.0, 1e3, 4e5][k % 3]).collect();
    for angle in quarters.chain(wild).chain(drawn) {
        let [cos, sin] = cos_sin(angle);
        let off = (cos - angle.cos()).abs().max((sin - angle.sin()).abs());
        assert!(off <= 2.3e-16, "{angle}: {off:e}");
        if let Some([cosines, sines]) = cos_sin_of([0.3, angle, -2.0, angle]) {
            assert_eq!(
                [cosines[1], sines[1], cosines[3], sines[3]],
                [cos, sin, cos, sin],
                "{angle}, one of four"
            );
        }
    }
    assert!(cos_sin(f64::NAN)[0].is_nan() && cos_sin(f64::INFINITY)[1].is_nan());
}

#[test]
fn poses_form_a_group_also_near_plus_minus_pi() {
    let mut random = Dice::new(2);
    for _ in 0..1000 {
        let (a, b, c) = (random.pose(), random.pose(), random.pose());
        let p = Vec2::new(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0));
        close(a.compose(a.inverse()), Pose2::IDENTITY);
        close(a.compose(a.between(b)), b);
        close(a.compose(b).compose(c), a.compose(b.compose(c)));
        assert!((a.compose(b).transform_point(p) - a.transform_point(b.transform_point(p))).norm() < 1e-11);
        assert!((a.inverse_rotate(a.rotate(p)) - p).norm() < 1e-12);
        close(a.interpolate(b, 0.0), a);
        close(a.interpolate(b, 1.0), b);
    }
}

#[test]
fn a_segment_keeps_its_ends_and_moves_rigidly() {
    let mut random = Dice::new(3);
    for _ in 0..1000 {
        let ends = [random.pose().translation(), random.pose().translation()];
        let segment = Segment::from_ends(ends[0], ends[1]);
        let motion = random.pose();
        let moved = segment.transformed(motion).ends();
        for k in 0..2 {
            assert!((segment.ends()[k] - ends[k]).norm() < 1e-12);
            assert!((moved[k] - motion.transform_point(ends[k])).norm() < 1e-12);
            assert!(segment.along_across(ends[k]).1.abs() < 1e-12);
        }
    }
}

#[test]
fn the_square_root_of_an_information_matrix_whitens_it_the_right_way_round() {
    // UᵀU = Ω, not UUᵀ: only a non-diagonal matrix shows the difference.
    let mut random = Dice::new(4);
    for _ in 0..200 {
        let information = random.information();
        let u = information.sqrt();
        assert!((u.transpose() * u - information.matrix()).amax() < 1e-9 * information.matrix().amax());
        assert!((u * u.transpose() - information.matrix()).amax() > 1e-3);
        assert!((information.covariance() * information.matrix() - Matrix3::identity()).amax() < 1e-9);
    }
}

#[test]
fn the_nearest_information_is_definite_and_nothing_definite_is_nearer() {
    let dice = &mut Dice::new(9);
    let random = |dice: &mut Dice| Matrix3::from_fn(|_, _| dice.normal(100.0));
    let mut indefinite = 0;
    for _ in 0..200 {
        let a = random(dice);
        let matrix = a + a.transpose();
        indefinite += usize::from(Information::new(matrix).is_err());
        let nearest = Information::nearest(matrix).unwrap().matrix();
        assert!(nearest.cholesky().is_some());
        let distance = (nearest - matrix).norm();
        for _ in 0..50 {
            let b = random(dice) * 0.2;
            let other = nearest.cholesky().unwrap().l() + b;
            assert!((other * other.transpose() - matrix).norm() >= distance * (1.0 - 1e-6), "{matrix}");
        }
    }
    assert!(indefinite > 100);
    let definite = dice.information();
    assert!(
        (Information::nearest(definite.matrix()).unwrap().matrix() - definite.matrix()).amax()
            < 1e-9 * 8100.0
    );
    assert!(Information::nearest(Matrix3::zeros()).is_err());
    assert!(Information::nearest(Matrix3::repeat(f64::NAN)).is_err());
    assert!(Information::nearest(-Matrix3::identity()).unwrap().matrix().amax() < 1e-8);
}

#[test]
fn an_information_matrix_that_is_not_positive_definite_is_refused() {
    assert!(Information::new(Matrix3::new(1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0)).is_err());
    assert!(Information::new(Matrix3::identity() * f64::NAN).is_err());
    assert!(Information::new(Matrix3::new(1.0, 0.3, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)).is_err());
    assert!(Information::new(Matrix3::identity() * 2.7e12).is_ok());
}

#[test]
fn the_scatter_of_a_straight_wall_has_a_root_although_it_is_singular() {
    let line = (0..50).map(|k| Vec2::new(3.0 + 0.1 * f64::from(k), -2.0 + 0.05 * f64::from(k)));
    let scatter = Scatter::of(line.clone());
    let [xx, xy, yy] = scatter.second_moments();
    let naive = line
        .clone()
        .map(|p| p - scatter.mean)
        .fold([0.0; 3], |m, d| [m[0] + d.x * d.x, m[1] + d.x * d.y, m[2] + d.y * d.y]);
    for (a, b) in [xx, xy, yy].iter().zip(naive) {
        assert!((a - b).abs() < 1e-12 * naive[0]);
    }
    assert!(scatter.root[2].abs() < 1e-12, "points on a line have no thickness: {:?}", scatter.root);
    assert_eq!(Scatter::of([Vec2::new(1.0, 2.0)].into_iter()).root, [0.0; 3]);
}

fn close(a: Pose2, b: Pose2) {
    assert!((a.translation() - b.translation()).norm() < 1e-11, "{a:?} {b:?}");
    assert!(angle_diff(a.theta_rad, b.theta_rad).abs() < 1e-11, "{a:?} {b:?}");
}
