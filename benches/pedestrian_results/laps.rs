//! FootSLAM with revisits.

use hitl_slam::pedestrian::picture::HexPicture;

use super::*;

/// A lap of the ring takes so long, seconds: 108 m at 0.7 m every 0.6 s.
const LAP_S: f64 = 108.0 / 0.7 * 0.6;

/// Independent filters that share the 10,000 particles.
const ISLANDS: usize = 10;

pub fn chapter(text: &mut String) -> Vec<Claim> {
    text.push_str(
        "\n## FootSLAM with revisits: 30 minutes of laps, one walker\n\nA ring of corridors, 36 m × 18 m, about 19 laps, every third \
         through the cross passage; heading drift of 4°/min (standard deviation) and a random walk of 0.2° a step. Ten \
         filters of 1,000 particles, the most central path kept, the mean over all but those astray (`--islands 10`). Errors at a true \
         position every 7 m, in the truth's frame: nothing is aligned. The best particle's path is the path that its ancestors took, \
         as known at the end; the weighted mean is the one after each step, as a person would have seen it then, so before the first \
         lap closes it is dead reckoning. *Shape*: RMS of the best path after the best rigid fit; the rest is the frame, which only the first metres tell.\n\n\
         | seed | PDR, worst m | best particle: RMS m | worst m | worst after 3 laps, m | shape m | weighted mean: RMS m | worst m | worst after 3 laps, m |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let (mut best_rms, mut mean_rms, mut later, mut shapes) = (0.0_f64, 0.0_f64, [0.0_f64; 2], 0.0_f64);
    for seed in 1..=SEEDS {
        let settings = Settings { seed, minutes: 30.0, ..Settings::default() };
        let simulation = Scenario::Loops.run(&settings, &[]).expect("a scenario");
        let outcome =
            run(&simulation, &Mode::FootSlam, &Options { seed, islands: ISLANDS, ..Options::default() });
        let (walk, estimate) = (&simulation.walks[0], &outcome.estimates[0]);
        let [best, mean, pdr] = errors(&simulation, walk, estimate, simulation.starts[0]);
        let three_laps = simulation.truth.partition_point(|t| t.stamp_s < 3.0 * LAP_S);
        let most = |v: &[f64]| quantile(v, 1.0);
        let shape = shape_m(&simulation, walk, &estimate.best);
        let _ = writeln!(
            text,
            "| {seed} | {:.1} | {:.2} | {:.2} | {:.2} | {shape:.2} | {:.2} | {:.2} | {:.2} |",
            most(&pdr),
            rms(&best),
            most(&best),
            most(&best[three_laps..]),
            rms(&mean),
            most(&mean),
            most(&mean[three_laps..])
        );
        best_rms = best_rms.max(rms(&best));
        mean_rms = mean_rms.max(rms(&mean));
        later = [later[0].max(most(&best[three_laps..])), later[1].max(most(&mean[three_laps..]))];
        shapes = shapes.max(shape);
        if seed == 1 {
            pictures(&simulation, &outcome);
        }
    }
    let issue = "at most 1 m over 30 minutes";
    vec![
        claim(
            "30 minutes of laps: RMS error of the best particle's path, worst seed",
            best_rms,
            1.0,
            "m",
            issue,
        ),
        claim("30 minutes of laps: RMS error of the weighted mean, worst seed", mean_rms, 1.0, "m", issue),
        claim(
            "30 minutes of laps: error of the path's shape (RMS after a rigid fit), worst seed",
            shapes,
            0.5,
            "m",
            "half a metre, one cell",
        ),
        claim(
            "30 minutes of laps: weighted mean, worst moment of the worst seed after 3 laps",
            later[1],
            1.0,
            "m",
            issue,
        ),
        claim(
            "30 minutes of laps: best particle, worst moment of the worst seed after 3 laps",
            later[0],
            1.0,
            "m",
            issue,
        ),
    ]
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|e| e * e).sum::<f64>() / values.len() as f64).sqrt()
}

/// RMS distance of a path from the truth after the best rigid motion.
fn shape_m(simulation: &Simulation, walk: &Walk, path: &[Vec2]) -> f64 {
    let pair = |t: &hitl_slam::pedestrian::TruthPoint| Some((walk.position_at(path, t.stamp_s)?, t.position));
    let pairs: Vec<(Vec2, Vec2)> = simulation.truth.iter().filter_map(pair).collect();
    let count = pairs.len() as f64;
    let (from, to) = pairs.iter().fold((Vec2::zeros(), Vec2::zeros()), |(a, b), (p, q)| (a + p, b + q));
    let (from, to) = (from / count, to / count);
    let (dot, cross) = pairs.iter().fold((0.0, 0.0), |(dot, cross), (p, q)| {
        (dot + (p - from).dot(&(q - to)), cross + (p - from).perp(&(q - to)))
    });
    let turn = Pose2::new(0.0, 0.0, f64::atan2(cross, dot));
    rms(&pairs.iter().map(|(p, q)| (turn.rotate(p - from) - (q - to)).norm()).collect::<Vec<_>>())
}

fn pictures(simulation: &Simulation, outcome: &Outcome) {
    let draw = |file: &str, title: &str, maps, path: Vec<Vec2>| {
        let walls = simulation.walls.as_slice();
        let picture = HexPicture { title: title.into(), maps, walls, paths: vec![path], width_px: 900 };
        figures::save(file, &picture);
    };
    let track = positions(&simulation.walks[0].track(simulation.starts[0]));
    draw("pedestrian-laps-before.png", "30 minutes of laps: dead reckoning", Vec::new(), track);
    let map = vec![(String::new(), &outcome.total)];
    draw(
        "pedestrian-laps-after.png",
        "FootSLAM: best particle and map",
        map,
        outcome.estimates[0].best.clone(),
    );
}
