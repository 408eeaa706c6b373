//! Round numbers for axes, grids and scale bars.

/// The largest of 1, 2, 5 × 10ᵏ that is at most `length` (which is > 0 and finite).
pub fn round_down(length: f64) -> f64 {
    let power = 10f64.powf(length.log10().floor());
    match length / power {
        m if m >= 5.0 => 5.0 * power,
        m if m >= 2.0 => 2.0 * power,
        _ => power,
    }
}

/// Round values in `from..=to`, about `wanted` of them, with their labels.
pub fn ticks(from: f64, to: f64, wanted: usize) -> Vec<(f64, String)> {
    let span = to - from;
    if !(span > 0.0 && span.is_finite()) {
        return Vec::new();
    }
    let step = round_down(2.0 * span / wanted.max(1) as f64);
    let first = (from / step).ceil();
    let count = ((to / step).floor() - first).clamp(0.0, 1000.0) as usize;
    let value = |k: usize| (first + k as f64) * step;
    (0..=count).map(value).filter(|&v| v <= to).map(|v| (v, label(v, step))).collect()
}

/// Powers of ten in `from..=to` (both > 0); with 2 and 5 times them where there would be fewer than three.
pub fn log_ticks(from: f64, to: f64) -> Vec<(f64, String)> {
    let decades = from.log10().floor() as i32..=to.log10().ceil() as i32;
    let with = |factors: &[f64]| -> Vec<(f64, String)> {
        let values = decades.clone().flat_map(|k| factors.iter().map(move |f| f * 10f64.powi(k)));
        values.filter(|v| (from..=to).contains(v)).map(|v| (v, label(v, v))).collect()
    };
    let powers = with(&[1.0]);
    if powers.len() >= 3 { powers } else { with(&[1.0, 2.0, 5.0]) }
}

/// `value` with the decimals that `step` needs, and a proper minus sign.
pub fn label(value: f64, step: f64) -> String {
    let value = if value.abs() < step * 1e-9 { 0.0 } else { value };
    let magnitude = value.abs();
    let digits = match magnitude {
        m if m >= 1e7 || step < 1e-6 => format!("{m:.0e}"),
        m => {
            let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 6.0) as usize;
            format!("{m:.decimals$}")
        }
    };
    if value < 0.0 { format!("−{digits}") } else { digits }
}
