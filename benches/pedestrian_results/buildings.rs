//! Walkers in real floor plans: unknown start frames, and many walkers.

use super::*;

/// Rigid motion that takes `from` to `to` best (least squares).
fn fit(from: &[Vec2], to: &[Vec2]) -> (Vec2, f64) {
    let centre = |v: &[Vec2]| v.iter().sum::<Vec2>() / v.len() as f64;
    let (a, b) = (centre(from), centre(to));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (p, q) in from.iter().zip(to) {
        dot += (p - a).dot(&(q - b));
        cross += (p - a).perp(&(q - b));
    }
    (b - a, cross.atan2(dot))
}

pub fn alignment(text: &mut String) {
    let Some(folder) = Some(Path::new("../shared/data/amrl_maps")).filter(|p| p.exists()) else {
        text.push_str("\nAlignment and many walkers: skipped: ../shared is absent.\n");
        return;
    };
    text.push_str("\n## Unknown start frames\n\nFour walkers for 10 minutes in real floor plans, the last one where nobody else goes; 3,000 particles, then 3 joint iterations. Off: the rigid misfit of a walker's path against the truth, less that of the first walker's (position of the path's middle, and turn).\n\n| building | seed | walkers placed | off, m / ° | stranger |\n|---|---|---|---|---|\n");
    let (mut good, mut placed, mut all, mut strangers) = (0, 0, 0, 0);
    for building in ["GHC7", "NSH3", "AHG2", "NYU19"] {
        let walls =
            io::floor_plan::read(&folder.join(format!("{building}.vectormap.txt"))).expect("walls").value;
        for seed in 1..=if is_quick() { 1 } else { 2 } {
            let settings = Settings { seed, walkers: 4, minutes: 10.0, strangers: 1, ..Settings::default() };
            let simulation = Scenario::Building.run(&settings, &walls).expect("a building");
            let options = Options { particles: 3_000, iterations: 3, seed, ..Options::default() };
            let start = Start { pose: simulation.starts[0], ..Start::default() };
            let Ok(outcome) =
                successive::run(&simulation.walks, start, true, &Mode::FeetSlam, &options, &mut |_| ())
            else {
                continue;
            };
            let misfit = |j: usize| {
                let walk = &simulation.walks[j];
                let own: Vec<_> = simulation.truth.iter().filter(|t| t.walker == walk.name).collect();
                let truth: Vec<Vec2> = own.iter().map(|t| t.position).collect();
                let path: Vec<Vec2> = own
                    .iter()
                    .filter_map(|t| walk.position_at(&outcome.estimates[j].best, t.stamp_s))
                    .collect();
                fit(&path, &truth)
            };
            let first = misfit(0);
            let mut cells = Vec::new();
            for j in 1..3 {
                all += 1;
                if outcome.takes_part[j] {
                    let (shift, turn) = misfit(j);
                    let (off, deg) = ((shift - first.0).norm(), (turn - first.1).to_degrees().abs());
                    placed += 1;
                    good += usize::from(off <= 0.5 && deg <= 2.0);
                    cells.push(format!("{off:.2} / {deg:.1}"));
                } else {
                    cells.push("left out".into());
                }
            }
            strangers += usize::from(outcome.takes_part[3]);
            let out = if outcome.takes_part[3] { "forced in" } else { "left out" };
            let _ = writeln!(
                text,
                "| {building} | {seed} | {} of 2 | {} | {out} |",
                outcome.takes_part[1..3].iter().filter(|t| **t).count(),
                cells.join(", ")
            );
            eprintln!("{building} {seed}: {} {out}", cells.join(", "));
        }
    }
    let _ = writeln!(
        text,
        "\nWithin 0.5 m and 2°: {good} of {all} walkers with shared ways ({placed} placed); strangers forced in: {strangers} of {}.",
        all / 2
    );
}
