//! The only place that touches modulo 2π. Angles are radians in (−π, π].

use std::f64::consts::{FRAC_2_PI, PI, TAU};

/// π/2 in three parts, the first two of 33 bits: any of them times a whole number below 2²⁰ is exact.
const QUARTER_TURN: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// Taylor-like coefficients of sin r/r and of cos r for |r| ≤ π/4 (Sun's fdlibm; error below 2⁻⁵⁷).
const SIN: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COS: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];
/// Adding it rounds a number below 2⁵¹ to a whole one, which then stands in the last bits.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;
/// Quarter turns beyond which the reduction would lose digits.
const MOST_QUARTERS: f64 = 1_048_576.0;

/// (cos, sin) of an angle of any size, to within 2 units of the last digit of 1: many at a time ([`cos_sin_of`]) cost a
/// fraction of the library's, and are the same on every machine.
#[inline]
pub fn cos_sin(angle_rad: f64) -> [f64; 2] {
    match cos_sin_of([angle_rad]) {
        Some([[cos], [sin]]) => [cos, sin],
        None => {
            let (sin, cos) = angle_rad.sin_cos();
            [cos, sin]
        }
    }
}

/// The same of several angles: their cosines and their sines; `None` if one is so large (or no number) that the reduction
/// would lose digits. Without a branch inside: made to be compiled for whatever vectors there are.
#[inline(always)]
pub fn cos_sin_of<const N: usize>(angles_rad: [f64; N]) -> Option<[[f64; N]; 2]> {
    let [first, second, third] = QUARTER_TURN;
    let (mut cosines, mut sines) = ([0.0; N], [0.0; N]);
    let mut reducible = true;
    for k in 0..N {
        let shifted = angles_rad[k] * FRAC_2_PI + TO_WHOLE;
        let quarters = shifted - TO_WHOLE;
        // Also false if it is not a number.
        reducible &= quarters.abs() < MOST_QUARTERS;
        let r = ((angles_rad[k] - quarters * first) - quarters * second) - quarters * third;
        let z = r * r;
        let polynomial = |c: &[f64; 6]| c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * (c[4] + z * c[5]))));
        let sin = r + r * z * polynomial(&SIN);
        let cos = 1.0 - (0.5 * z - z * z * polynomial(&COS));
        // The quarter says which is which, and the signs: (cos, sin), (−sin, cos), (−cos, −sin), (sin, −cos).
        let quarter = shifted.to_bits();
        let (x, y) = if quarter & 1 == 0 { (cos, sin) } else { (sin, cos) };
        cosines[k] = f64::from_bits(x.to_bits() ^ (((quarter + 1) & 2) << 62));
        sines[k] = f64::from_bits(y.to_bits() ^ ((quarter & 2) << 62));
    }
    reducible.then_some([cosines, sines])
}

/// The same direction as `angle_rad`, in (−π, π].
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad - TAU * (angle_rad / TAU).round();
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

/// `to − from`, the short way round: in (−π, π].
pub fn angle_diff(to_rad: f64, from_rad: f64) -> f64 {
    wrap_angle(to_rad - from_rad)
}
