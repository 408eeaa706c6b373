//! Foot-mounted walks with every footfall measured by ruler (KTU), beside the inertial track that is shipped with them.

use std::fmt::Write as _;
use std::path::Path;

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::inertial::{self, Options, Pdr, Recording, Sample};
use hitl_slam::io;
use hitl_slam::render::{Anchor, Colour, Item, Picture, PixelRect, Viewport, WorldRect};
use nalgebra::Vector3;

use crate::page::Claim;
use crate::{claim, quantile};

/// A footfall is matched to the stance at its time, or to the next one within this, seconds.
const NEAR_S: f64 = 0.15;
/// A stride whose measured length differs by more than this from ours *and* from the shipped track's, metres, while those
/// two agree: the measured point does not belong to the stride.
const MISMATCH_M: f64 = 0.25;
/// The walk that is also in data/.
const PICTURED: usize = 42;

struct Footfall {
    time_s: f64,
    shipped: Vec2,
    truth: Vec2,
}

/// One track against the footfalls.
struct Score {
    end_m: f64,
    rms_m: f64,
    stride_m: f64,
    early_m: f64,
}

pub fn part(folder: &Path, text: &mut String) -> Vec<Claim> {
    text.push_str("\n## Foot-mounted, every footfall measured (KTU, 16 walks)\n\nDead reckoning from the raw data alone. All tracks start at the first measured footfall and are turned about it by the one angle that fits all footfalls best (their frames' headings are unknown). End: at the last footfall. RMS: over all. Stride: median |length error| of a stride. INS: the zero-velocity-aided track shipped with the data (9 states, no bias).\n\n| walk | m | strides | steps | without a step | end: ours, no bias, INS (m) | RMS: ours, no bias, INS (m) | stride: ours, INS (m) | bias, °/min |\n|---|---|---|---|---|---|---|---|---|\n");
    let (mut scores, mut named, mut scales) = ([const { Vec::<Score>::new() }; 3], Vec::new(), Vec::new());
    let mut sigmas = Vec::new();
    for walk in 31..=46 {
        let recording = recording(folder, walk).expect("a walk of the data set");
        let footfalls = footfalls(folder, walk);
        let truth: Vec<Vec2> = footfalls.iter().map(|f| f.truth).collect();
        let shipped: Vec<Vec2> = footfalls.iter().map(|f| f.shipped).collect();
        let reckon = |still_bias| {
            let options = Options { still_bias, ..Options::default() };
            inertial::reckon("walk", &recording, &options).expect("a walk of the data set")
        };
        let (ours, plain) = (reckon(true), reckon(false));
        let (positions, missing) = at_footfalls(&ours, &footfalls);
        let (plain, _) = at_footfalls(&plain, &footfalls);
        let score = [&positions, &plain, &shipped].map(|track| score(track, &truth));
        if walk == PICTURED {
            picture([&positions, &plain, &shipped], &truth);
        }
        let lengths = [&truth, &positions, &shipped].map(|track| lengths(track));
        let wrong: Vec<String> = (0..truth.len() - 1)
            .filter(|&k| {
                let [measured, ours, shipped] = [0, 1, 2].map(|track: usize| lengths[track][k]);
                (measured - ours).abs() > MISMATCH_M
                    && (measured - shipped).abs() > MISMATCH_M
                    && (ours - shipped).abs() < 0.5 * (measured - ours).abs()
            })
            .map(|k| format!("{} (measured {:.2} m, walked {:.2} m)", k + 1, lengths[0][k], lengths[1][k]))
            .collect();
        if !wrong.is_empty() {
            named.push(format!("walk {walk}: stride {}", wrong.join(", ")));
        }
        if ours.steps.len() + 1 != truth.len() {
            named.push(format!(
                "walk {walk}: {} measured strides, {} steps found",
                truth.len() - 1,
                ours.steps.len()
            ));
        }
        scales.push(lengths[1].iter().sum::<f64>() / lengths[0].iter().sum::<f64>());
        if wrong.is_empty() && ours.steps.len() + 1 == truth.len() {
            let errors = ours.steps.iter().zip(&lengths[0]);
            sigmas.extend(errors.map(|(e, &l)| (e.step.length_m() - l).abs() / e.covariance[(0, 0)].sqrt()));
        }
        let bias = ours.gyro_bias_radps.map_or("none found".to_owned(), |b| {
            format!("{:.0}", Vector3::from(b).norm().to_degrees() * 60.0)
        });
        let _ = writeln!(
            text,
            "| {walk} | {:.1} | {} | {} | {missing} | {:.2}, {:.2}, {:.2} | {:.2}, {:.2}, {:.2} | {:.3}, {:.3} | {bias} |",
            lengths[0].iter().sum::<f64>(),
            truth.len() - 1,
            ours.steps.len(),
            score[0].end_m,
            score[1].end_m,
            score[2].end_m,
            score[0].rms_m,
            score[1].rms_m,
            score[2].rms_m,
            score[0].stride_m,
            score[2].stride_m,
        );
        for (all, one) in scores.iter_mut().zip(score) {
            all.push(one);
        }
    }
    summary(&scores, text);
    let better = scores[0].iter().zip(&scores[2]).filter(|(a, b)| a.end_m < b.end_m).count();
    let _ = writeln!(
        text,
        "\nOurs ends nearer than the shipped track in {better} of 16 walks. Lengths are {:.3} of the measured ones in the median ({:.3} to {:.3}): a resting foot rolls, which zero velocity does not allow for. Of the strides of walks without a mismatch {:.0} % are within two of their own standard deviations.",
        quantile(&scales, 0.5),
        quantile(&scales, 0.0),
        quantile(&scales, 1.0),
        100.0 * sigmas.iter().filter(|&&s| s < 2.0).count() as f64 / sigmas.len().max(1) as f64
    );
    let _ = writeln!(
        text,
        "\nWalks whose footfalls and strides do not match: {}. They are in the table and the medians as they are.",
        if named.is_empty() { "none".to_owned() } else { named.join("; ") }
    );
    text.push_str("\n![Walk 42](img/pedestrian-foot.png)\n");
    let median =
        |k: usize, of: fn(&Score) -> f64| quantile(&scores[k].iter().map(of).collect::<Vec<_>>(), 0.5);
    let why = "better than the track shipped with the data, on the median";
    vec![
        claim(
            "real foot: end error, median of 16 measured walks",
            median(0, |s| s.end_m),
            median(2, |s| s.end_m),
            "m",
            why,
        ),
        claim(
            "real foot: RMS over footfalls, median of 16 walks",
            median(0, |s| s.rms_m),
            median(2, |s| s.rms_m),
            "m",
            why,
        ),
    ]
}

fn summary(scores: &[Vec<Score>; 3], text: &mut String) {
    let median =
        |k: usize, of: fn(&Score) -> f64| quantile(&scores[k].iter().map(of).collect::<Vec<_>>(), 0.5);
    text.push_str(
        "\n| median of 16 walks | ours | without the bias step | shipped INS |\n|---|---|---|---|\n",
    );
    for (name, of) in [
        ("end error, m", (|s| s.end_m) as fn(&Score) -> f64),
        ("RMS over the footfalls, m", |s| s.rms_m),
        ("end error with the heading from the first eight strides only, m", |s| s.early_m),
        ("stride length error, m", |s| s.stride_m),
    ] {
        let [a, b, c] = [0, 1, 2].map(|k| median(k, of));
        let _ = writeln!(text, "| {name} | {a:.3} | {b:.3} | {c:.3} |");
        eprintln!("KTU {name}: ours {a:.3}, no bias {b:.3}, INS {c:.3}");
    }
}

fn footfalls(folder: &Path, walk: usize) -> Vec<Footfall> {
    let text =
        std::fs::read_to_string(folder.join(format!("strides/walk_{walk}.csv"))).expect("the footfalls");
    let footfall = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
        Footfall { time_s: v[1], shipped: Vec2::new(v[2], v[3]), truth: Vec2::new(v[5], v[6]) }
    };
    text.lines().skip(1).map(footfall).collect()
}

/// The raw table, or, for three walks, the array in a MATLAB file.
fn recording(folder: &Path, walk: usize) -> Option<Recording> {
    let table = folder.join(format!("imu_csv/SensorConnectData_{walk}.csv.xz"));
    if table.exists() {
        return Some(io::imu::read(&table).ok()?.value);
    }
    let arrays = super::mat::read(&folder.join(format!("LLIO/SensorConnectData_{walk}_LLIO.mat.xz"))).ok()?;
    let ((rows, _, imu), (_, _, times)) = (arrays.get("imu_data")?, arrays.get("timestamps")?);
    let triple = |row: usize, from: usize| Vector3::from_fn(|k, _| imu[(from + k) * rows + row]);
    let sample =
        |row: usize| Sample { time_s: times[row], force_mps2: triple(row, 0), rate_radps: triple(row, 3) };
    Some(Recording { samples: (0..*rows).map(sample).collect() })
}

/// Where a walk is at each footfall, and how many footfalls have no stance near.
fn at_footfalls(pdr: &Pdr, footfalls: &[Footfall]) -> (Vec<Vec2>, usize) {
    let track: Vec<Vec2> = pdr.walk("").track(Default::default()).iter().map(|p| p.translation()).collect();
    let rests: Vec<(f64, f64)> = std::iter::once((f64::NEG_INFINITY, pdr.starts_s))
        .chain(pdr.steps.iter().map(|e| (e.step.time_s, e.rests_until_s)))
        .collect();
    let mut missing = 0;
    let place = |f: &Footfall| {
        let away = |rest: &(f64, f64)| (rest.0 - f.time_s).max(f.time_s - rest.1).max(0.0);
        let nearest =
            (0..rests.len()).min_by(|&a, &b| away(&rests[a]).total_cmp(&away(&rests[b]))).unwrap_or(0);
        missing += usize::from(away(&rests[nearest]) > NEAR_S);
        track[nearest]
    };
    (footfalls.iter().map(place).collect(), missing)
}

fn lengths(track: &[Vec2]) -> Vec<f64> {
    track.windows(2).map(|w| (w[1] - w[0]).norm()).collect()
}

fn score(track: &[Vec2], truth: &[Vec2]) -> Score {
    let errors = |fitted: usize| -> Vec<f64> {
        turned(track, truth, fitted).iter().zip(truth).map(|(p, q)| (p - q).norm()).collect()
    };
    let all = errors(truth.len());
    let strides: Vec<f64> = lengths(track).iter().zip(lengths(truth)).map(|(a, b)| (a - b).abs()).collect();
    Score {
        end_m: all[all.len() - 1],
        rms_m: (all.iter().map(|e| e * e).sum::<f64>() / all.len() as f64).sqrt(),
        stride_m: quantile(&strides, 0.5),
        early_m: errors(8)[all.len() - 1],
    }
}

/// A track with its start on the truth's, turned about it to fit the first `fitted` strides.
fn turned(track: &[Vec2], truth: &[Vec2], fitted: usize) -> Vec<Vec2> {
    let (mut cross, mut dot) = (0.0, 0.0);
    for (p, q) in track.iter().zip(truth).take(fitted + 1) {
        let (p, q) = (*p - track[0], *q - truth[0]);
        cross += p.perp(&q);
        dot += p.dot(&q);
    }
    let turn = Pose2::new(0.0, 0.0, cross.atan2(dot));
    track.iter().map(|p| truth[0] + turn.rotate(*p - track[0])).collect()
}

/// Measured footfalls as discs, tracks as lines, five metres for scale.
fn picture(tracks: [&[Vec2]; 3], truth: &[Vec2]) {
    const SIZE: (u32, u32) = (900, 620);
    let tracks = tracks.map(|track| turned(track, truth, truth.len()));
    let all = || tracks.iter().flatten().chain(truth);
    let low = all().fold(truth[0], |a, b| a.inf(b)) - Vec2::repeat(0.7);
    let high = all().fold(truth[0], |a, b| a.sup(b)) + Vec2::repeat(0.7);
    let world = WorldRect::new(low, high).expect("a walk has an extent");
    let frame =
        PixelRect { left: 10.0, top: 90.0, width: SIZE.0 as f32 - 20.0, height: SIZE.1 as f32 - 100.0 };
    let view = Viewport::fit(&world, frame);
    let mut items = Vec::new();
    let names = ["dead reckoning", "without the bias step", "shipped INS"];
    for k in [2, 1, 0] {
        let colour = [Colour::BLUE, Colour::LIGHT, Colour::ORANGE][k];
        items.push(Item::line(tracks[k].iter().map(|p| view.pixel(*p)).collect(), 2.0, colour));
        let left = 195.0 + 205.0 * k as f32;
        items.push(Item::line(vec![[left, 58.0], [left + 24.0, 58.0]], 3.0, colour));
        items.push(Item::text([left + 30.0, 63.0], names[k], 15.0, Anchor::Start, Colour::INK));
    }
    items.extend(truth.iter().map(|p| Item::disc(view.pixel(*p), 3.0, Colour::INK)));
    items.push(Item::disc([24.0, 58.0], 3.0, Colour::INK));
    items.push(Item::text([34.0, 63.0], "measured footfalls", 15.0, Anchor::Start, Colour::INK));
    items.push(Item::text([16.0, 30.0], "A foot, 131 m, 102 strides", 19.0, Anchor::Start, Colour::INK));
    let end = SIZE.0 as f32 - 24.0;
    let from = end - (5.0 * view.scale) as f32;
    items.push(Item::line(vec![[from, 30.0], [end, 30.0]], 2.2, Colour::INK));
    items.push(Item::text([from - 8.0, 35.0], "5 m", 15.0, Anchor::End, Colour::INK));
    let mut picture = Picture::new(SIZE.0, SIZE.1);
    picture.push(None, items);
    let path = crate::page::project("docs/img/pedestrian-foot.png");
    io::atomic::write(&path, |out| out.write_all(&picture.to_png())).expect("docs/img can be written");
}
