//! Seventeen walks of three people through one floor, phone in hand, with timed landmarks and a floor plan (HuMoLiRe).

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use hitl_slam::geometry::{Pose2, Segment, Vec2};
use hitl_slam::inertial::{self, Options as Reckoning};
use hitl_slam::io;
use hitl_slam::pedestrian::successive::{self, Ends, Mode, Outcome};
use hitl_slam::pedestrian::{Layout, Options, Start, TransitionMap, TruthPoint, Walk, metrics};
use serde_json::Value;

use crate::figures::save;
use crate::page::Claim;
use crate::{claim, positions, quantile};

/// All walks begin at one door, and the first leg goes along +x.
const START: (f64, f64) = (7.2, 6.3);
/// How well a person finds the mark at the start, metres; how straight the phone is held, radians.
const START_SIGMAS: (f64, f64) = (0.3, 0.0873);
/// Ends of the rounds: about two legs each.
fn rounds() -> Mode {
    Mode::Successive(Ends::Lengths(vec![15.0, 30.0, 45.0, 60.0, 80.0, 100.0, 120.0, 150.0, 180.0]))
}
const BEST: &str = "FeetSLAM in rounds, start known";
const FILES: [&str; 2] = ["accelerometer-calibrated.txt.xz", "references.txt"];

struct Floor {
    walks: Vec<Walk>,
    truth: Vec<TruthPoint>,
    walls: Vec<Segment>,
}

pub fn part(folder: &Path, text: &mut String) -> Vec<Claim> {
    let floor = floor(folder);
    let particles = if crate::is_quick() { 2_000 } else { 5_000 };
    let mut options = Options { particles, iterations: 2, ..Options::default() };
    // A hand is no foot: its angle to the walker wanders, and Weinberg's gain is not this person's.
    options.noise.heading_rad = 1f64.to_radians();
    options.noise.drift_start_rad = 0.1f64.to_radians();
    options.noise.position_m = 0.05;
    options.noise.scale = 0.05;
    let start = Start {
        pose: Pose2::new(START.0, START.1, 0.0),
        position_sigma_m: START_SIGMAS.0,
        heading_sigma_rad: START_SIGMAS.1,
    };
    let _ = writeln!(
        text,
        "\n## Hand-held phone, 17 walks of three people on one floor (HuMoLiRe)\n\nPDR with one step-length gain for all ({}); {} landmarks, each passed at a known time. Filter: {particles} particles, 2 iterations a round, rounds at 15, 30, 45, 60, 80, 100, 120, 150, 180 m and the end, heading noise 1°, drift 0.1°, position 5 cm, scale 5 % per 0.7 m. Start known: the door, ± 0.3 m and ± 5°. Start unknown: only the first walker's. Errors of the weighted mean over all landmarks of the walkers who take part. Crossings through walls: of the map, for PDR of its tracks drawn on the same hexagons.\n\n| | median, m | mean, m | 90 %, m | worst, m | crossings through walls | take part | s |\n|---|---|---|---|---|---|---|---|",
        Reckoning::default().weinberg_gain,
        floor.truth.len()
    );
    let tracks: Vec<Vec<Vec2>> = floor.walks.iter().map(|w| positions(&w.track(start.pose))).collect();
    let reckoned = errors(&floor, &tracks, &vec![true; tracks.len()]);
    let mut map: Option<TransitionMap> = None;
    let mut runs = Vec::new();
    for (name, mode, unknown) in [
        ("FootSLAM, start known", Mode::FootSlam, false),
        ("FeetSLAM in one round, start known", Mode::FeetSlam, false),
        (BEST, rounds(), false),
        ("FeetSLAM in rounds, start unknown", rounds(), true),
    ] {
        let started = std::time::Instant::now();
        let outcome =
            successive::run(&floor.walks, start, unknown, &mode, &options, &mut |_| ()).expect("real walks");
        let means: Vec<Vec<Vec2>> = outcome.estimates.iter().map(|e| positions(&e.mean)).collect();
        let found = errors(&floor, &means, &outcome.takes_part);
        runs.push((
            name,
            found,
            metrics::crossed_wall_ratio(&outcome.total, &floor.walls),
            taking_part(&outcome),
            started.elapsed().as_secs_f64(),
        ));
        if name == BEST {
            picture(&floor, &tracks, &outcome, &means);
            map = Some(outcome.total);
        }
    }
    let mut row = |name: &str, errors: &[f64], crossed: f64, part: usize, seconds: f64| {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let [half, most, worst] = [0.5, 0.9, 1.0].map(|share| quantile(errors, share));
        let _ = writeln!(
            text,
            "| {name} | {half:.2} | {mean:.2} | {most:.2} | {worst:.2} | {:.1} % | {part} | {seconds:.0} |",
            100.0 * crossed
        );
        eprintln!(
            "HuMoLiRe {name}: median {half:.2} mean {mean:.2} worst {worst:.2}, walls {crossed:.3}, {part} walkers, {seconds:.0} s"
        );
    };
    let grid = map.as_ref().map(|m| m.grid).expect("a map");
    row(
        "PDR, start known",
        &reckoned,
        crossed_by_paths(&grid, &tracks, &floor.walls),
        floor.walks.len(),
        0.0,
    );
    for (name, errors, crossed, part, seconds) in &runs {
        row(name, errors, *crossed, *part, *seconds);
    }
    let truly: Vec<Vec<Vec2>> = floor.walks.iter().map(|w| landmarks(&floor, w)).collect();
    let factor = quantile(&reckoned, 0.5) / quantile(&runs[2].1, 0.5);
    let _ = writeln!(
        text,
        "\nFeetSLAM in rounds: the median is {factor:.1} times smaller than PDR's. In one round it is no help: 200 m are too long for the particles that there are. For comparison, straight lines from landmark to landmark cross walls in {:.1} % of their crossings: plan and landmarks do not fit better than that.\n\n![HuMoLiRe](img/pedestrian-humolire.png)",
        100.0 * crossed_by_paths(&grid, &truly, &floor.walls)
    );
    let why = "better than dead reckoning, on the median";
    vec![claim(
        "real phone: FeetSLAM's median error at landmarks, 17 walks",
        quantile(&runs[2].1, 0.5),
        quantile(&reckoned, 0.5),
        "m",
        why,
    )]
}

fn taking_part(outcome: &Outcome) -> usize {
    outcome.takes_part.iter().filter(|&&t| t).count()
}

/// Errors at the landmarks of those who take part.
fn errors(floor: &Floor, paths: &[Vec<Vec2>], takes_part: &[bool]) -> Vec<f64> {
    let each = floor.walks.iter().zip(paths).zip(takes_part).filter(|(_, part)| **part);
    each.flat_map(|((walk, path), _)| metrics::errors_m(walk, path, &floor.truth)).collect()
}

fn landmarks(floor: &Floor, walk: &Walk) -> Vec<Vec2> {
    floor.truth.iter().filter(|t| t.walker == walk.name).map(|t| t.position).collect()
}

/// The crossed-wall ratio of bare paths: each drawn on the hexagons.
fn crossed_by_paths(
    grid: &hitl_slam::pedestrian::hex::HexGrid,
    paths: &[Vec<Vec2>],
    walls: &[Segment],
) -> f64 {
    let layout = Layout::around(grid, paths.iter().flatten().copied()).expect("a building");
    let mut map = TransitionMap::new(*grid, layout);
    paths.iter().for_each(|path| map.add_path(path, 1.0));
    metrics::crossed_wall_ratio(&map, walls)
}

fn picture(floor: &Floor, tracks: &[Vec<Vec2>], outcome: &Outcome, means: &[Vec<Vec2>]) {
    use hitl_slam::pedestrian::picture::HexPicture;
    let draw = |file: &str, title: &str, maps, paths: &[Vec<Vec2>]| {
        let picture = HexPicture {
            title: title.into(),
            maps,
            walls: &floor.walls,
            paths: paths.to_vec(),
            width_px: 900,
        };
        save(file, &picture);
    };
    draw("pedestrian-humolire-pdr.png", "17 walks by phone: dead reckoning", Vec::new(), tracks);
    draw(
        "pedestrian-humolire.png",
        "FeetSLAM: weighted means and map",
        vec![(String::new(), &outcome.total)],
        means,
    );
}

fn floor(folder: &Path) -> Floor {
    let mut walks: Vec<PathBuf> = Vec::new();
    let mut open = vec![folder.join("imus")];
    while let Some(folder) = open.pop() {
        let inner: Vec<PathBuf> =
            std::fs::read_dir(folder).expect("a folder").flatten().map(|e| e.path()).collect();
        walks.extend(inner.iter().filter(|f| FILES.iter().all(|file| f.join(file).exists())).cloned());
        open.extend(inner.into_iter().filter(|f| f.is_dir()));
    }
    walks.sort();
    let mut floor = Floor { walks: Vec::new(), truth: Vec::new(), walls: walls(folder) };
    for path in walks {
        let parts: Vec<String> =
            path.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
        let from = parts.iter().position(|p| p == "imus").expect("imus") + 1;
        let name = parts[from..].join("-");
        let recording = io::imu::read(&path).expect("a walk").value;
        let pdr = inertial::reckon(&name, &recording, &Reckoning::default()).expect("a walk");
        let keypoints = json(&path.join("keypoints.json"));
        let times = std::fs::read_to_string(path.join(FILES[1])).expect("times");
        let times = times.lines().filter_map(|l| l.split_once(' ')?.0.parse::<f64>().ok());
        for (k, stamp_s) in times.enumerate() {
            let Some(point) = keypoints.get(k.to_string()) else { break };
            floor.truth.push(TruthPoint { walker: name.clone(), stamp_s, position: at(point, 1.0) });
        }
        floor.walks.push(pdr.walk(&name));
    }
    floor
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

fn at(point: &Value, scale: f64) -> Vec2 {
    let number = |key: &str| scale * point[key].as_f64().expect("a number");
    Vec2::new(number("x"), number("y"))
}

fn walls(folder: &Path) -> Vec<Segment> {
    let plan = json(&folder.join("maps/map_data.json"));
    let scale = plan["scale"].as_f64().expect("a scale");
    let links = plan["links"].as_array().expect("links");
    let ends = links.iter().map(|l| (at(&l["node0"], scale), at(&l["node1"], scale)));
    ends.filter(|(a, b)| (b - a).norm() > 1e-6).map(|(a, b)| Segment::from_ends(a, b)).collect()
}
