//! The paper's figures, made by the program: what each mode moves (2), the information matrix (5), lost poses (8), two
//! collinear corrections that together fix a full-rank error (9), and where maps contradict themselves.

use hitl_slam::explicit;
use hitl_slam::geometry::{Pose2, Segment, Vec2};
use hitl_slam::map::{Correction, Mode, SlamMap, Trajectory};
use hitl_slam::metrics::{self, InconsistencyOptions};
use hitl_slam::pipeline::Options;
use hitl_slam::render::{
    self, Anchor, Colour, Heat, Item, MapPictureOptions, Overlay, Picture, PixelRect, WorldRect,
};
use hitl_slam::simulate::{self, Scenario, Settings, Simulation};

use crate::figures::save;
use crate::page::{Result, Section};
use crate::runs;

pub fn section() -> Result<Section> {
    let body = [modes()?, information()?, lost_poses()?, collinear()?, heat()?].concat();
    Ok(Section { title: "The paper's figures", name: "figures", body, claims: Vec::new() })
}

/// Fig. 2: what the explicit correction of each mode moves.
fn modes() -> Result<String> {
    let a = Segment::from_ends(Vec2::new(-1.6, 0.0), Vec2::new(1.4, 0.0));
    let b = Segment { centre: Vec2::new(1.5, -1.5), direction_rad: 0.42, half_length_m: 1.4 };
    let steep = Segment { direction_rad: 1.15, ..b };
    let mut panels = vec![mode_panel("original", &a, &b, None)];
    for (mode, b) in
        [(Mode::Colocation, b), (Mode::Collinear, b), (Mode::Parallel, b), (Mode::Perpendicular, steep)]
    {
        panels.push(mode_panel(mode.name(), &a, &b, Some(mode)));
    }
    panels.push(mode_key());
    let picture = render::tiled(&panels, 3);
    let alt = "what each mode moves: colocation all of b, collinear across the line only, parallel and perpendicular only its direction";
    save("modes.png", alt, &picture)
}

const PANEL_PX: f32 = 300.0;

fn mode_panel(title: &str, a: &Segment, b: &Segment, mode: Option<Mode>) -> Picture {
    let mut picture = Picture::new(PANEL_PX as u32 + 20, PANEL_PX as u32 + 20);
    let frame = PixelRect { left: 10.0, top: 10.0, width: PANEL_PX, height: PANEL_PX };
    let pixel = |p: Vec2| [160.0 + 46.0 * (p.x as f32 - 0.35), 150.0 - 46.0 * (p.y as f32 + 0.55)];
    // Points of a wall with a return to either side, so that one sees where along the wall they lie.
    let cloud = |s: &Segment| -> Vec<Vec2> {
        let along = (0..=24).map(|k| (f64::from(k) / 12.0 - 1.0, 0.05 * (f64::from(k) * 2.4).sin()));
        let corner = (1..=6).map(|k| (1.0, 0.09 * f64::from(k)));
        along
            .chain(corner)
            .map(|(x, y)| s.centre + s.direction() * (x * s.half_length_m) + s.normal() * y)
            .collect()
    };
    let dots = |points: &[Vec2], colour| {
        points.iter().map(|&p| Item::disc(pixel(p), 2.6, colour)).collect::<Vec<_>>()
    };
    let line = |s: &Segment, colour| Item::line(s.ends().map(pixel).to_vec(), 3.0, colour);
    let seen = cloud(b);
    let pivot = seen.iter().sum::<Vec2>() / seen.len() as f64;
    let mut items = dots(&cloud(a), Colour::RED);
    items.push(line(a, Colour::RED));
    let moved = mode.and_then(|m| explicit::correction(m, a, b, pivot));
    if let Some(motion) = moved {
        let ghost = Colour::rgb(0xAFC3EC);
        items.extend(dots(&seen, ghost));
        items.push(line(b, ghost));
        let now: Vec<Vec2> = seen.iter().map(|&p| motion.transform_point(p)).collect();
        items.extend(dots(&now, Colour::BLUE));
        items.push(line(&b.transformed(motion), Colour::BLUE));
        let way = [pivot, motion.transform_point(pivot)].map(pixel);
        items.push(Item::line(way.to_vec(), 2.0, Colour::INK));
        items.push(Item::disc(way[1], 5.0, Colour::INK));
    } else {
        items.extend(dots(&seen, Colour::BLUE));
        items.push(line(b, Colour::BLUE));
        items.push(Item::disc(pixel(pivot), 5.0, Colour::INK));
    }
    items.push(Item::line(frame.outline(), 1.0, Colour::LIGHT));
    items.push(Item::text([20.0, 32.0], title, 17.0, Anchor::Start, Colour::INK));
    picture
        .push(Some(PixelRect { left: 9.0, top: 9.0, width: PANEL_PX + 2.0, height: PANEL_PX + 2.0 }), items);
    picture
}

/// What the colours of the panels mean.
fn mode_key() -> Picture {
    let mut picture = Picture::new(PANEL_PX as u32 + 20, PANEL_PX as u32 + 20);
    let lines = [
        ("a: seen first, stays", Colour::RED),
        ("b, corrected", Colour::BLUE),
        ("b as it was", Colour::rgb(0xAFC3EC)),
        ("mean of b's points, and its way", Colour::INK),
    ];
    let items = lines.iter().enumerate().flat_map(|(k, (text, colour))| {
        let y = 90.0 + 34.0 * k as f32;
        [
            Item::disc([36.0, y - 5.0], 6.0, *colour),
            Item::text([54.0, y], *text, 15.0, Anchor::Start, Colour::INK),
        ]
    });
    picture.push(None, items.collect());
    picture
}

/// Fig. 5.
fn information() -> Result<String> {
    let s = runs::simulated(Scenario::OfficeBent, 1, 0.02)?;
    let (after, _) = runs::corrected(&s.map, &s.corrections, Options::default())?;
    let options = MapPictureOptions { size_px: 900, title: Some("office-bent".into()), ..Default::default() };
    let matrix = render::information(&after, 560, Some("information matrix"));
    let picture = render::tiled(&[render::map(&after, &options), matrix], 1);
    save(
        "information.png",
        "a corrected map and its information matrix, human factors coloured by mode",
        &picture,
    )
}

/// A map laid on the truth as well as it can be, so that true walls can be drawn over it.
fn laid_on_truth(map: &SlamMap, s: &Simulation) -> SlamMap {
    let stamps_s: Vec<f64> = (0..s.truth.len()).map(|k| k as f64).collect();
    let [own, truth] =
        [&map.poses, &s.truth].map(|p| Trajectory { stamps_s: stamps_s.clone(), poses: p.clone() });
    let pairs: Vec<(usize, usize)> = (0..s.truth.len()).map(|k| (k, k)).collect();
    let motion = metrics::ate(&own, &truth, &pairs).map_or(Pose2::IDENTITY, |a| a.truth_from_estimate);
    let mut laid = map.clone();
    laid.poses.iter_mut().for_each(|p| *p = motion.compose(*p));
    for factor in &mut laid.human_factors {
        factor.a.segment = factor.a.segment.transformed(motion);
        factor.b.segment = factor.b.segment.transformed(motion);
    }
    laid
}

/// Fig. 8: black lines are the true walls.
fn lost_poses() -> Result<String> {
    let s = runs::simulated(Scenario::LostPoses, 1, 0.02)?;
    let (after, _) = runs::corrected(&s.map, &s.corrections, Options::default())?;
    let wall = |w: &hitl_slam::map::Wall| Overlay {
        ends: w.segment.ends(),
        label: String::new(),
        colour: Colour::INK,
        width_px: 1.2,
    };
    let maps = [laid_on_truth(&s.map, &s), laid_on_truth(&after, &s)];
    let around = WorldRect::around(&maps[0]).union(&WorldRect::around(&maps[1]));
    let panels = [(&maps[0], "before"), (&maps[1], "after")].map(|(map, title)| {
        let options = MapPictureOptions {
            size_px: 640,
            title: Some(format!("lost poses, {title} · black lines: the true walls")),
            overlays: s.walls.iter().map(wall).collect(),
            crop: Some(around),
            ..Default::default()
        };
        render::map(map, &options)
    });
    save("lost-poses.png", "lost poses before and after, true walls in black", &render::tiled(&panels, 2))
}

/// Fig. 9: the north wall, then the west wall: each says one direction, both together fix the corner.
fn collinear() -> Result<String> {
    let s = runs::simulated(Scenario::LostPoses, 1, 0.02)?;
    let crop = WorldRect::new(Vec2::new(-1.2, 4.4), Vec2::new(4.2, 9.6));
    // The room as far as it is right before the corner is seen a second time, then north and west, and nothing else.
    let mut told: Vec<Correction> = s.corrections[..4].to_vec();
    let collinear: Vec<Correction> =
        s.corrections[4..].iter().filter(|c| c.mode == Mode::Collinear).take(2).cloned().collect();
    let mut panels = Vec::new();
    for (count, title) in
        [(0, "two images of one corner"), (1, "the north wall collinear"), (2, "then the west wall too")]
    {
        told.truncate(4);
        told.extend_from_slice(&collinear[..count]);
        let (map, _) = runs::corrected(&s.map, &told, Options::default())?;
        let mut shown = map;
        shown.human_factors = shown.human_factors.split_off(4.min(shown.human_factors.len()));
        let options =
            MapPictureOptions { size_px: 420, title: Some(title.into()), crop, ..Default::default() };
        panels.push(render::map(&shown, &options));
    }
    save(
        "collinear.png",
        "two collinear corrections that together fix a full-rank error",
        &render::tiled(&panels, 3),
    )
}

/// Where a map contradicts itself, before and after.
fn heat() -> Result<String> {
    let s = runs::simulated(Scenario::OfficeBent, 1, 0.02)?;
    let (after, _) = runs::corrected(&s.map, &s.corrections, Options::default())?;
    let settings = Settings { thorough: true, ..Settings::default() };
    let patient = simulate::run(Scenario::OfficeBent, &settings)?.corrections;
    let (straight, _) = runs::corrected(&s.map, &patient, Options::default())?;
    let true_map = SlamMap { poses: s.truth.clone(), ..s.map.clone() };
    let true_m2 = metrics::inconsistency(&true_map, &InconsistencyOptions::default())?.area_m2;
    let mut panels = Vec::new();
    let [usual, thorough] = [s.corrections.len(), patient.len()].map(|n| format!("after {n} corrections"));
    for (map, when) in [(&s.map, "before"), (&after, &usual), (&straight, &thorough)] {
        let found = metrics::inconsistency(map, &InconsistencyOptions::default())?;
        let options = MapPictureOptions {
            size_px: 900,
            title: Some(format!("office-bent, {when}: {:.0} m² (true map: {true_m2:.0} m²)", found.area_m2)),
            heat: Some(Heat { side_m: found.resolution_m, cells: found.cells }),
            ..Default::default()
        };
        panels.push(render::map(map, &options));
    }
    save(
        "inconsistency.png",
        "where a map contradicts itself: before, after the usual corrections, after those of a thorough person",
        &render::tiled(&panels, 1),
    )
}
