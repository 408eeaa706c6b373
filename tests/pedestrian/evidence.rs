//! How likely it is that one building made two walks.

use hitl_slam::geometry::Vec2;
use hitl_slam::pedestrian::evidence::{Board, COPIES, Trial, ln_gamma, offset_of};
use hitl_slam::pedestrian::hex::HexGrid;
use hitl_slam::pedestrian::random::Key;
use hitl_slam::pedestrian::{Layout, TransitionMap};

const ALPHA: f64 = 0.8;

fn grid(radius_m: f64) -> HexGrid {
    HexGrid { radius_m, angle_rad: 0.1, origin: Vec2::new(0.3, -0.2) }
}

/// The same without tables: maps are drawn, and every hexagon is looked at.
fn naive(grid: HexGrid, placed: &[&[Vec2]], path: &[Vec2]) -> f64 {
    let layout = Layout::around(&grid, placed.iter().flat_map(|p| p.iter().copied())).unwrap();
    let drawn = |paths: &[&[Vec2]]| {
        let mut map = TransitionMap::new(grid, layout);
        for path in paths {
            for copy in 0..COPIES {
                let moved: Vec<Vec2> = path.iter().map(|p| p + offset_of(copy)).collect();
                for part in moved.split(|p| !layout.contains(&grid, *p)) {
                    map.add_path(part, 1.0 / COPIES as f64);
                }
            }
        }
        map
    };
    let (a, b) = (drawn(placed), drawn(&[path]));
    let ln_beta = |counts: [f64; 6]| {
        let sum: f64 = counts.iter().sum();
        counts.iter().map(|n| ln_gamma(n + ALPHA)).sum::<f64>() - ln_gamma(sum + 6.0 * ALPHA)
    };
    let cells = layout.ids().map(|id| layout.cell(id));
    let one = |cell| {
        let (n_a, n_b): ([f64; 6], [f64; 6]) = (a.counts_of(cell), b.counts_of(cell));
        let both = std::array::from_fn(|e| n_a[e] + n_b[e]);
        ln_beta(both) - ln_beta(n_a) - ln_beta(n_b) + ln_beta([0.0; 6])
    };
    cells.map(one).sum()
}

/// Back and forth between a few places, a little beside the line: a random walk of a random number of legs.
fn way(key: Key, legs: u64, extent_m: f64) -> Vec<Vec2> {
    let place = |k: u64| Vec2::new(key.uniform(2 * k), key.uniform(2 * k + 1)) * extent_m;
    let mut points = Vec::new();
    for leg in 0..legs {
        let draw = |k: u64| (key.named("leg").uniform(k) * 5.0) as u64;
        let (from, to) = (place(draw(leg)), place(draw(leg + 1)));
        let count = ((to - from).norm() / 2.1).ceil().max(1.0) as usize;
        let noise = |k: usize| {
            let at = leg * 1_000 + 2 * k as u64;
            Vec2::new(key.named("x").normal(at), key.named("x").normal(at + 1)) * 0.1
        };
        points.extend((0..count).map(|k| from + (to - from) * (k as f64 / count as f64) + noise(k)));
    }
    points
}

#[test]
fn evidence_from_tables_is_that_of_maps_drawn_hexagon_by_hexagon() {
    let mut trial = Trial::default();
    for seed in 1..=12 {
        let key = Key::new(seed);
        let extent_m = 15.0 + 30.0 * key.uniform(0);
        let placed: Vec<Vec<Vec2>> = (0..1 + seed % 3).map(|k| way(key.with(k), 30, extent_m)).collect();
        let placed: Vec<&[Vec2]> = placed.iter().map(Vec::as_slice).collect();
        for radius_m in [0.75, 1.5] {
            let board = Board::new(grid(radius_m), &placed, ALPHA).unwrap();
            for k in 0..6 {
                // Some lie on the map, some beside it, some leave the window and come back.
                let shift = Vec2::new(key.normal(100 + k), key.normal(200 + k)) * 8.0 * k as f64;
                let other = way(key.with(k), 10 + 8 * k, extent_m);
                let path: Vec<Vec2> = other.iter().map(|p| p + shift).collect();
                let (fast, slow) = (board.evidence(&path, &mut trial), naive(grid(radius_m), &placed, &path));
                assert!(
                    (fast - slow).abs() < 1e-6 * (1.0 + slow.abs()),
                    "{seed} {radius_m} {k}: {fast} {slow}"
                );
                // The room that was used before leaves nothing behind.
                assert_eq!(fast, board.evidence(&path, &mut Trial::default()));
            }
        }
    }
}

#[test]
fn counts_beyond_the_tables_are_computed() {
    let few = [Vec2::new(0.0, 0.0), Vec2::new(12.0, 0.0)];
    let many = few.repeat(400);
    let board = Board::new(grid(1.5), &[&few], ALPHA).unwrap();
    let (fast, slow) = (board.evidence(&many, &mut Trial::default()), naive(grid(1.5), &[&few], &many));
    assert!((fast - slow).abs() < 1e-6 * slow.abs(), "{fast} {slow}");
}

#[test]
fn evidence_is_greatest_where_two_ways_agree_and_zero_where_they_do_not_meet() {
    let along = |y: f64| [Vec2::new(-10.0, y), Vec2::new(10.0, y)].repeat(3);
    let across = [Vec2::new(0.0, -10.0), Vec2::new(0.0, 10.0)].repeat(3);
    let board = Board::new(grid(0.75), &[&along(0.1)], ALPHA).unwrap();
    let evidence = |path: &[Vec2]| board.evidence(path, &mut Trial::default());
    assert!(evidence(&along(0.1)) > 20.0);
    assert!(evidence(&along(0.1)) > evidence(&along(0.6)));
    assert_eq!(evidence(&along(8.0)), 0.0);
    assert!(evidence(&across) < 1.0);
}

#[test]
fn ln_gamma_is_that_of_the_factorials() {
    let mut factorial = 0.0;
    for n in 1..60 {
        assert!((ln_gamma(f64::from(n)) - factorial).abs() < 1e-9 * (1.0 + factorial), "{n}");
        factorial += f64::from(n).ln();
    }
    assert!((ln_gamma(0.5) - 0.5 * std::f64::consts::PI.ln()).abs() < 1e-10);
}
