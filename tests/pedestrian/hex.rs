//! Hexagons: crossings against brute force, numbering, counts.

use hitl_slam::geometry::Vec2;
use hitl_slam::pedestrian::hex::{Cell, HexGrid, Hexagon, opposite};
use hitl_slam::pedestrian::{Layout, TransitionMap};

use crate::support::Dice;

#[test]
fn crossing_every_edge_there_is_and_back_leads_home() {
    let home = Cell { q: 3, r: -2 };
    for edge in 0..6 {
        assert_eq!(home.across(edge).across(opposite(edge)), home);
    }
}

#[test]
fn a_walk_crosses_exactly_the_hexagons_that_brute_force_finds() {
    let (mut dice, hexagon) = (Dice::new(4), Hexagon::new(0.5));
    for _ in 0..2_000 {
        let from = [dice.uniform(-9.0, 9.0), dice.uniform(-9.0, 9.0)];
        let step = [dice.uniform(-4.0, 4.0), dice.uniform(-4.0, 4.0)];
        let (start, offset) = hexagon.enter(from.map(|v| v as f32));
        let mut walked = vec![start];
        let (end, _) = hexagon.walk(start, offset, step.map(|v| v as f32), 64, |cell, edge| {
            assert_eq!(*walked.last().unwrap(), cell);
            walked.push(cell.across(edge));
        });
        assert_eq!(*walked.last().unwrap(), end);
        // Brute force: the cell of very many points of the way. It may miss a corner that is clipped by less than the
        // spacing, never see one that the walk missed.
        let mut sampled: Vec<Cell> = Vec::new();
        for k in 0..=20_000 {
            let t = f64::from(k) / 20_000.0;
            let cell = hexagon.locate([0, 1].map(|i| (from[i] + t * step[i]) as f32));
            if sampled.last() != Some(&cell) {
                sampled.push(cell);
            }
        }
        let mut rest = walked.iter();
        for cell in &sampled {
            assert!(rest.any(|w| w == cell), "{from:?} {step:?}: {sampled:?} but walked {walked:?}");
        }
        assert!(walked.len() <= sampled.len() + 1, "{from:?} {step:?}: {sampled:?} but walked {walked:?}");
    }
}

#[test]
fn a_metre_of_straight_walk_crosses_1_47_edges_on_average() {
    // (2/π) · 3R / area, whatever the direction is drawn evenly from.
    let (mut dice, hexagon) = (Dice::new(5), Hexagon::new(0.5));
    let (mut crossings, mut metres) = (0, 0.0);
    for _ in 0..20_000 {
        let angle = dice.uniform(0.0, std::f64::consts::TAU);
        let from = [dice.uniform(-9.0, 9.0) as f32, dice.uniform(-9.0, 9.0) as f32];
        let (cell, offset) = hexagon.enter(from);
        let step = [5.0 * angle.cos() as f32, 5.0 * angle.sin() as f32];
        hexagon.walk(cell, offset, step, 64, |_, _| crossings += 1);
        metres += 5.0;
    }
    let per_metre = f64::from(crossings) / metres;
    assert!((per_metre - 1.470).abs() < 0.01, "{per_metre}");
}

fn grid() -> HexGrid {
    HexGrid { radius_m: 0.5, angle_rad: 0.3, origin: Vec2::new(1.0, -2.0) }
}

#[test]
fn every_id_of_a_window_names_one_cell_and_neighbours_share_one_edge() {
    for low in [Vec2::new(-7.0, -3.0), Vec2::new(-6.0, -4.1)] {
        let layout = Layout::around(&grid(), [low, Vec2::new(5.0, 4.0)]).unwrap();
        for id in layout.ids() {
            let cell = layout.cell(id);
            assert_eq!(layout.id(cell), id);
            for edge in 0..6 {
                let other = layout.id(cell.across(edge));
                let expected = if edge < 3 { (id, edge) } else { (other, edge - 3) };
                assert_eq!(layout.edge_between(id, other), expected, "{cell:?} {edge}");
            }
        }
    }
}

#[test]
fn a_path_counts_once_per_crossing_seen_from_both_sides() {
    let layout = Layout::around(&grid(), [Vec2::new(-9.0, -9.0), Vec2::new(9.0, 9.0)]).unwrap();
    let mut map = TransitionMap::new(grid(), layout);
    let path = [Vec2::new(-3.0, 0.1), Vec2::new(2.0, 0.4), Vec2::new(2.2, 3.0), Vec2::new(-3.0, 0.1)];
    map.add_path(&path, 1.0);
    let once = map.total();
    let back: Vec<Vec2> = path.iter().rev().copied().collect();
    map.add_path(&back, 1.0);
    assert_eq!(map.total(), 2.0 * once, "the way back crosses the same edges");
    for (cell, edge, count) in map.edges() {
        assert_eq!(map.count(cell.across(edge), opposite(edge)), count);
    }
    let mut other = TransitionMap::new(grid(), layout);
    other.add_path(&back, 0.37);
    let before = map.clone();
    map.add_map(&other);
    assert!(map.change(&before) > 0.0);
    map.subtract(&other);
    assert_eq!(map, before, "what was added can be taken away exactly");
}
