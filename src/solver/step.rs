//! How large a step is and what it promises: sums over all unknowns, in lanes that the compiler turns into vectors. The
//! order of every sum is fixed: the same bytes on every machine.

use super::simd::wide;

const LANES: usize = 8;

/// A step δ that is finite.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Step {
    /// Its largest entry.
    pub max: f64,
    /// What it promises to take off the cost, of the linear model at negligible damping: ½ δᵀ(−g).
    pub promised: f64,
}

impl Step {
    /// δ where the gradient is g; `None` if it is not finite.
    pub fn of(delta: &[f64], gradient: &[f64]) -> Option<Step> {
        let mut sums = Sums::default();
        add_up(delta, gradient, &mut sums);
        let Sums { max, dot, zeros } = sums;
        let max = max.into_iter().fold(0.0, f64::max);
        // Nothing but zeros, unless one of them came from what is not finite.
        (zeros.iter().sum::<f64>() == 0.0).then(|| Step { max, promised: -0.5 * in_pairs(dot) })
    }
}

/// Largest entry, without its sign; what is not a number does not count.
pub(super) fn largest(v: &[f64]) -> f64 {
    let mut sums = Sums::default();
    add_up(v, v, &mut sums);
    sums.max.into_iter().fold(0.0, f64::max)
}

#[derive(Default)]
struct Sums {
    max: [f64; LANES],
    dot: [f64; LANES],
    zeros: [f64; LANES],
}

fn in_pairs(s: [f64; LANES]) -> f64 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

wide! {
    fn add_up(a: &[f64], b: &[f64], sums: &mut Sums) {
        let Sums { mut max, mut dot, mut zeros } = *sums;
        let mut add = |k: usize, a: f64, b: f64| {
            let size = a.abs();
            max[k] = if size > max[k] { size } else { max[k] };
            dot[k] += a * b;
            zeros[k] += 0.0 * a;
        };
        let (a, a_rest) = a.as_chunks::<LANES>();
        let (b, b_rest) = b.as_chunks::<LANES>();
        for (a, b) in a.iter().zip(b) {
            for k in 0..LANES {
                add(k, a[k], b[k]);
            }
        }
        for (k, (&a, &b)) in a_rest.iter().zip(b_rest).enumerate() {
            add(k, a, b);
        }
        *sums = Sums { max, dot, zeros };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(n: usize) -> (Vec<f64>, Vec<f64>) {
        let at = |k: usize, by: f64| ((k as f64 + 1.0) * by).sin() * (k as f64 * 0.7).exp2().min(1e3);
        ((0..n).map(|k| at(k, 1.3)).collect(), (0..n).map(|k| at(k, 2.9)).collect())
    }

    #[test]
    fn a_step_is_measured_as_one_sum_after_the_other_measures_it() {
        for n in [0, 1, 7, 8, 9, 64, 301] {
            let (delta, gradient) = numbers(n);
            let dot: f64 = delta.iter().zip(&gradient).map(|(d, g)| d * g).sum();
            let size: f64 = delta.iter().zip(&gradient).map(|(d, g)| (d * g).abs()).sum();
            let max = delta.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
            let same = |step: Step| step.max == max && (step.promised + 0.5 * dot).abs() <= 1e-14 * size;
            assert!(Step::of(&delta, &gradient).is_some_and(same), "{n}");
            assert_eq!(largest(&delta), max, "{n}");
        }
    }

    #[test]
    fn a_step_with_one_number_that_is_none_is_no_step() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for at in [0, 5, 8, 16, 18] {
                let (mut delta, gradient) = numbers(19);
                delta[at] = bad;
                assert_eq!(Step::of(&delta, &gradient), None, "{bad} at {at}");
            }
        }
    }
}
