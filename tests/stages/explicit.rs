//! Stage 3: every mode puts b where it belongs, and nothing moves along the mode's null space.

use std::f64::consts::{FRAC_PI_2, PI};

use hitl_slam::explicit::{correction, rotation};
use hitl_slam::geometry::{Pose2, Segment, Vec2, wrap_angle};
use hitl_slam::map::Mode;

use crate::support::Dice;

/// A segment within ±40° of parallel to `a` (or of perpendicular), drawn in either direction.
fn partner(random: &mut Dice, mode: Mode, a: &Segment) -> Segment {
    let wanted = if mode == Mode::Perpendicular { FRAC_PI_2 } else { 0.0 };
    let flip = if random.uniform(0.0, 1.0) < 0.5 { PI } else { 0.0 };
    Segment {
        centre: random.pose().translation(),
        direction_rad: wrap_angle(a.direction_rad + wanted + flip + random.uniform(-0.7, 0.7)),
        half_length_m: random.uniform(0.3, 4.0),
    }
}

fn cases(mode: Mode, mut check: impl FnMut(&Segment, &Segment, Vec2, Pose2)) {
    let mut random = Dice::new(mode as u64 + 20);
    for _ in 0..500 {
        let ends = [random.pose().translation(), random.pose().translation()];
        let a = Segment::from_ends(ends[0], ends[1]);
        let b = partner(&mut random, mode, &a);
        let pivot = b.centre + b.direction() * random.uniform(-0.2, 0.2);
        let motion = correction(mode, &a, &b, pivot).expect("not ambiguous within 40°");
        assert!(motion.theta_rad.abs() <= 0.7 + 1e-9, "the smaller of the two rotations");
        check(&a, &b.transformed(motion), pivot, motion);
    }
}

#[test]
fn colocation_puts_b_on_a() {
    cases(Mode::Colocation, |a, b, _, _| {
        assert!((a.centre - b.centre).norm() < 1e-9);
        assert!((b.direction_rad - a.direction_rad).sin().abs() < 1e-9);
    });
}

#[test]
fn collinear_puts_b_on_the_line_of_a_and_moves_its_points_not_along_it() {
    cases(Mode::Collinear, |a, b, pivot, motion| {
        assert!(b.ends().iter().all(|&end| a.along_across(end).1.abs() < 1e-9));
        let moved = motion.transform_point(pivot) - pivot;
        assert!(moved.dot(&a.direction()).abs() < 1e-9, "moved along the line by {moved:?}");
    });
}

#[test]
fn parallel_and_perpendicular_turn_b_about_its_own_points() {
    cases(Mode::Parallel, |a, b, pivot, motion| {
        assert!((b.direction_rad - a.direction_rad).sin().abs() < 1e-9);
        assert!((motion.transform_point(pivot) - pivot).norm() < 1e-9);
    });
    cases(Mode::Perpendicular, |a, b, pivot, motion| {
        assert!((b.direction_rad - a.direction_rad).cos().abs() < 1e-9);
        assert!((motion.transform_point(pivot) - pivot).norm() < 1e-9);
    });
}

#[test]
fn the_direction_of_drawing_makes_no_difference_even_at_45_degrees() {
    // The released implementation flips maps by 180° at walls near ±45°.
    for degrees in [-135.0, -90.0, -45.0, 0.0, 44.9, 45.0, 90.0, 135.0, 180.0_f64] {
        let at = |offset: f64| Segment {
            centre: Vec2::new(1.0, 2.0),
            direction_rad: wrap_angle((degrees + offset).to_radians()),
            half_length_m: 1.0,
        };
        for mode in Mode::ALL {
            let skew = if mode == Mode::Perpendicular { 95.0 } else { 5.0 };
            for flip in [0.0, 180.0] {
                let turn = rotation(mode, &at(0.0), &at(skew + flip)).expect("not ambiguous");
                assert!((turn + 5.0_f64.to_radians()).abs() < 1e-9, "{mode:?} {degrees} {flip}: {turn}");
            }
        }
    }
}

#[test]
fn two_candidates_within_10_degrees_of_each_other_are_ambiguous() {
    let a = Segment { centre: Vec2::zeros(), direction_rad: 3.0, half_length_m: 1.0 };
    for (off_degrees, ambiguous) in
        [(84.9_f64, false), (85.1, true), (90.0, true), (94.9, true), (95.1, false)]
    {
        let b = Segment { direction_rad: wrap_angle(3.0 + off_degrees.to_radians()), ..a };
        assert_eq!(rotation(Mode::Parallel, &a, &b).is_none(), ambiguous, "{off_degrees}");
        let b = Segment { direction_rad: wrap_angle(3.0 + (90.0 - off_degrees).to_radians()), ..a };
        assert_eq!(rotation(Mode::Perpendicular, &a, &b).is_none(), ambiguous, "{off_degrees}");
    }
}
