//! Random numbers by counter: their statistics, and that they depend on nothing but where they are used.

use hitl_slam::pedestrian::motion::sin_cos;
use hitl_slam::pedestrian::random::{Key, Normals};
use hitl_slam::pedestrian::weights::systematic;

const COUNT: u64 = 400_000;

fn draws() -> Vec<[f32; 4]> {
    let (key, table) = (Key::new(7).with(3).named("w1"), Normals::table());
    (0..COUNT).map(|i| table.four(key.word(i))).collect()
}

#[test]
fn normal_numbers_have_the_moments_and_the_distribution_of_normal_numbers() {
    for k in 0..4 {
        let values: Vec<f64> = draws().iter().map(|d| f64::from(d[k])).collect();
        let moment = |p: i32| values.iter().map(|v| v.powi(p)).sum::<f64>() / COUNT as f64;
        // Standard errors of the moments: √(1, 2, 15, 96) / √COUNT; five of them, and the table's own kurtosis.
        let error = 5.0 / (COUNT as f64).sqrt();
        assert!(moment(1).abs() < error, "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < 1.5 * error, "{}", moment(2));
        assert!(moment(3).abs() < 4.0 * error, "{}", moment(3));
        assert!((moment(4) - 3.0).abs() < 10.0 * error + 0.05, "{}", moment(4));
        for (z, share) in
            [(0.0, 0.5), (1.0, 0.841_345), (-1.5, 0.066_807), (2.0, 0.977_250), (3.0, 0.998_650)]
        {
            let below = values.iter().filter(|v| **v <= z).count() as f64 / COUNT as f64;
            assert!((below - share).abs() < 0.004, "{k}: {below} below {z}, expected {share}");
        }
    }
}

#[test]
fn numbers_of_one_word_of_neighbours_and_of_other_streams_are_uncorrelated() {
    let (a, table) = (draws(), Normals::table());
    let other = Key::new(7).with(4).named("w1");
    let correlation = |pairs: &mut dyn Iterator<Item = (f32, f32)>| {
        pairs.map(|(x, y)| f64::from(x) * f64::from(y)).sum::<f64>() / COUNT as f64
    };
    let error = 5.0 / (COUNT as f64).sqrt();
    for (k, l) in [(0, 1), (0, 2), (1, 3), (2, 3)] {
        assert!(correlation(&mut a.iter().map(|d| (d[k], d[l]))).abs() < error);
    }
    assert!(correlation(&mut a.windows(2).map(|w| (w[0][0], w[1][0]))).abs() < error);
    let across = a.iter().enumerate().map(|(i, d)| (d[0], table.four(other.word(i as u64))[0]));
    assert!(correlation(&mut across.into_iter()).abs() < error);
}

#[test]
fn keys_tell_seeds_numbers_and_names_apart() {
    let keys = [
        Key::new(1),
        Key::new(2),
        Key::new(1).with(0),
        Key::new(1).with(1),
        Key::new(1).named("a"),
        Key::new(1).named("b"),
    ];
    for (i, a) in keys.iter().enumerate() {
        assert!(keys[i + 1..].iter().all(|b| a.word(0) != b.word(0)));
    }
    assert_eq!(Key::new(1).named("a").word(5), Key::new(1).named("a").word(5));
}

#[test]
fn sine_and_cosine_are_good_to_a_few_roundings() {
    for k in -40_000..40_000 {
        let x = k as f32 * 1e-3;
        let (s, c) = sin_cos(x);
        let (s0, c0) = f64::from(x).sin_cos();
        assert!((f64::from(s) - s0).abs() < 6e-6 && (f64::from(c) - c0).abs() < 6e-6, "{x}: {s} {c}");
    }
}

#[test]
fn systematic_resampling_gives_every_particle_its_share_to_within_one() {
    let weights: Vec<f32> = (0..1000).map(|i| ((i * 7919) % 1013) as f32).collect();
    let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    for offset in [0.0, 0.3, 0.999_999] {
        let parents = systematic(weights.iter().copied(), sum, 5_000, offset);
        assert_eq!(parents.len(), 5_000);
        for (i, &w) in weights.iter().enumerate() {
            let children = parents.iter().filter(|&&p| p == i as u32).count() as f64;
            assert!((children - f64::from(w) * 5_000.0 / sum).abs() < 1.0 + 1e-6);
        }
    }
}
