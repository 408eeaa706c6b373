//! The pictures of the page: the paper's figures 2, 3 and 5.

use hitl_slam::pedestrian::TransitionMap;
use hitl_slam::pedestrian::picture::HexPicture;

use super::*;

pub fn save(file: &str, picture: &HexPicture) {
    let path = page::project("docs/img").join(file);
    io::atomic::write(&path, |out| out.write_all(&picture.draw().to_png())).expect("docs/img can be written");
}

pub fn chapter(text: &mut String) -> Vec<Claim> {
    let simulation = Scenario::Six.run(&Settings::default(), &[]).expect("a scenario");
    let (mut rounds_maps, mut iteration_maps) = (Vec::new(), Vec::new());
    let options = Options { iterations: 3, particles: particles(), ..Options::default() };
    let outcome = run_seen(&simulation, &rounds(), &options, &mut |s| {
        rounds_maps.truncate(s.round);
        rounds_maps.push(s.total.clone());
    });
    let turned = Options { grid: GridChoice::Fixed(15f64.to_radians()), ..options };
    run_seen(&simulation, &Mode::FeetSlam, &turned, &mut |s| iteration_maps.push(s.total.clone()));
    let named = |name: &str, maps: &[TransitionMap], first: usize| -> Vec<(String, TransitionMap)> {
        maps.iter().enumerate().map(|(k, m)| (format!("{name} {}", k + first), m.clone())).collect()
    };
    let walls = simulation.walls.as_slice();
    let draw = |file: &str, title: &str, maps: &[(String, TransitionMap)], paths: Vec<Vec<Vec2>>| {
        let maps = maps.iter().map(|(n, m)| (n.clone(), m)).collect();
        save(file, &HexPicture { title: title.into(), maps, walls, paths, width_px: 900 });
    };
    draw(
        "pedestrian-rounds.png",
        "Experiment 2 (Fig. 5): total map after each round",
        &named("round", &rounds_maps, 1),
        Vec::new(),
    );
    draw(
        "pedestrian-iterations.png",
        "Experiment 1 (Fig. 3), grid at 15°: total map",
        &named("iteration", &iteration_maps, 0),
        Vec::new(),
    );
    let tracks = simulation.walks.iter().map(|w| positions(&w.track(simulation.starts[0]))).collect();
    draw("pedestrian-before.png", "Dead reckoning of the six walkers (Fig. 2)", &[], tracks);
    let means = outcome.estimates.iter().map(|e| positions(&e.mean)).collect();
    draw("pedestrian-after.png", "Experiment 2: weighted means", &[], means);
    for name in ["rounds", "iterations", "before", "after", "laps-before", "laps-after"] {
        let _ = write!(text, "\n![{name}](img/pedestrian-{name}.png)");
    }
    text.push('\n');
    Vec::new()
}
