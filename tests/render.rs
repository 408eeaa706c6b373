//! Pictures: right primitives in the right places, same bytes for the same input, no surprise on odd maps.

use crate::building;
use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::map::{Observations, SlamMap};
use hitl_slam::render::{
    Colour, Item, MapPictureOptions, Mark, Overlay, Picture, PlacedErrors, Plot, Series, WorldRect,
    before_after, map, text_width_px,
};

fn items(picture: &Picture) -> impl Iterator<Item = &Item> {
    picture.layers.iter().flat_map(|layer| &layer.items)
}

fn texts(picture: &Picture) -> Vec<&str> {
    items(picture)
        .filter_map(|i| if let Item::Text { text, .. } = i { Some(text.as_str()) } else { None })
        .collect()
}

/// Arrows of a colour: (black or blue) outlines with the four corners of a dart.
fn arrows(picture: &Picture, wanted: Colour) -> Vec<Vec<[f32; 2]>> {
    let outlines = items(picture).filter_map(|item| match item {
        Item::Shapes { outlines, colour } if *colour == wanted => Some(outlines.clone()),
        _ => None,
    });
    outlines.flatten().filter(|o| o.len() == 4).collect()
}

fn lines(picture: &Picture, wanted: Colour) -> Vec<Vec<[f32; 2]>> {
    let points = items(picture).filter_map(|item| match item {
        Item::Line { points, colour, .. } if *colour == wanted => Some(points.clone()),
        _ => None,
    });
    points.collect()
}

fn pixels(picture: &Picture) -> (usize, Vec<u8>) {
    let bytes = picture.to_png();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    assert_eq!((info.width, info.height), (picture.width(), picture.height()));
    (info.width as usize, data)
}

#[test]
fn the_same_map_gives_the_same_bytes() {
    let (before, after) = building::before_and_after(120, 60);
    let options = MapPictureOptions { size_px: 400, with_grid: true, ..Default::default() };
    let (one, two) = (before_after(&before, &after, &options), before_after(&before, &after, &options));
    assert_eq!(one.to_png(), two.to_png());
    assert_eq!(one.to_svg(), two.to_svg());
}

#[test]
fn a_point_lands_on_its_pixel_with_y_up() {
    let mut one = SlamMap { poses: vec![Pose2::new(0.0, 0.0, 0.0)], ..Default::default() };
    one.observations.push(Vec2::new(1.0, 3.0), Vec2::zeros(), 3.0);
    one.observations.end_pose();
    let crop = WorldRect::new(Vec2::new(0.0, 0.0), Vec2::new(4.0, 4.0));
    let picture = map(&one, &MapPictureOptions { size_px: 400, crop, ..Default::default() });
    let frame = picture.layers[0].clip.unwrap();
    let (width, data) = pixels(&picture);
    let (x, y) = (frame.left as usize + 100, frame.top as usize + 100); // a quarter from the left and from the top
    let ink = |x: usize, y: usize| 255 - data[3 * (y * width + x) + 2]; // orange has no blue
    assert!(ink(x, y) > 40);
    for row in frame.top as usize + 3..frame.top as usize + 380 {
        for column in frame.left as usize + 20..frame.left as usize + 397 {
            let near = column.abs_diff(x) <= 3 && row.abs_diff(y) <= 3;
            assert!(near || ink(column, row) == 0, "ink at {column}, {row}, expected only near {x}, {y}");
        }
    }
}

#[test]
fn an_arrow_points_along_the_heading() {
    let one = SlamMap {
        poses: vec![Pose2::new(0.0, 0.0, std::f64::consts::FRAC_PI_2)],
        observations: hitl_slam::map::Observations::empty(1),
        ..Default::default()
    };
    let arrows = arrows(&map(&one, &MapPictureOptions::default()), Colour::INK);
    let tip = arrows[0][0];
    assert!(arrows[0][1..].iter().all(|corner| corner[1] > tip[1]), "up in the world is up in the picture");
}

#[test]
fn dense_poses_are_thinned_and_those_of_a_human_factor_are_blue() {
    let (_, after) = building::before_and_after(2000, 30);
    let picture = map(&after, &MapPictureOptions { size_px: 500, ..Default::default() });
    let (black, blue) = (arrows(&picture, Colour::INK), arrows(&picture, Colour::BLUE));
    assert!(black.len() > 30 && black.len() < 400, "{} black arrows", black.len());
    assert!(blue.len() > 5, "{} blue arrows", blue.len());
    let middles: Vec<[f32; 2]> = black.iter().chain(&blue).map(|a| a[2]).collect();
    for (k, p) in middles.iter().enumerate() {
        let near = middles[..k].iter().filter(|q| (q[0] - p[0]).hypot(q[1] - p[1]) < 3.0).count();
        assert!(near <= 1, "arrows on top of each other at {p:?}"); // the legend's own arrow aside
    }
}

#[test]
fn before_shows_the_strokes_where_its_own_poses_put_them() {
    let (before, after) = building::before_and_after(300, 90);
    let picture = before_after(&before, &after, &MapPictureOptions { size_px: 600, ..Default::default() });
    assert_eq!(
        texts(&picture).iter().filter(|t| t.contains("fter")).collect::<Vec<_>>(),
        [&"after · 2 corrections"]
    );
    let red = lines(&picture, Colour::RED);
    let strokes: Vec<_> =
        red.iter().filter(|l| l[0][1].max(l[1][1]) < picture.height() as f32 * 0.9).collect();
    assert_eq!(strokes.len(), 4, "two in each half");
    let middle = picture.width() as f32 / 2.0;
    let slope = |l: &&Vec<[f32; 2]>| ((l[1][1] - l[0][1]) / (l[1][0] - l[0][0])).abs();
    let blue_before = lines(&picture, Colour::BLUE).into_iter().find(|l| l[0][0] < middle).unwrap();
    assert!(slope(&&blue_before) > 0.1, "the second visit is bent in the map before");
    assert!(strokes.iter().filter(|l| l[0][0] > middle).all(|l| slope(l) < 1e-3));
}

#[test]
fn grid_labels_overlays_and_titles_appear_in_both_formats() {
    let (before, _) = building::before_and_after(100, 60);
    let overlay = Overlay {
        ends: [Vec2::new(8.0, 2.0), Vec2::new(1e9, 2.0)],
        label: "c1 <a>".into(),
        colour: Colour::RED,
        width_px: 4.0,
    };
    let options = MapPictureOptions {
        title: Some("before & after".into()),
        with_grid: true,
        overlays: vec![overlay],
        ..Default::default()
    };
    let picture = map(&before, &options);
    for text in ["before & after", "10", "−5", "c1 <a>", "10 m"] {
        assert!(texts(&picture).contains(&text), "{text} in {:?}", texts(&picture));
    }
    let svg = picture.to_svg();
    assert!(svg.contains(">before &amp; after</text>") && svg.contains(">c1 &lt;a&gt;</text>"));
    let red = &lines(&picture, Colour::RED)[0];
    assert!(red.iter().all(|p| p[0].abs() < 5000.0), "an end far outside is cut off: {red:?}");
}

#[test]
fn odd_maps_and_sizes_still_give_pictures() {
    let nothing = SlamMap::default();
    let far = SlamMap {
        poses: vec![
            Pose2::new(1e15, -1e15, 1.0),
            Pose2::new(f64::NAN, 0.0, 0.0),
            Pose2::new(1e300, 0.0, 0.0),
        ],
        observations: hitl_slam::map::Observations::empty(3),
        ..Default::default()
    };
    let corridor = SlamMap {
        poses: (0..50).map(|i| Pose2::new(f64::from(i) * 10.0, 0.0, 0.0)).collect(),
        observations: hitl_slam::map::Observations::empty(50),
        ..Default::default()
    };
    for odd in [&nothing, &far, &corridor] {
        for size_px in [0, 120] {
            let options = MapPictureOptions { size_px, with_grid: true, ..Default::default() };
            assert!(map(odd, &options).to_png().len() > 60);
            assert!(before_after(odd, odd, &options).to_svg().ends_with("</svg>\n"));
        }
    }
    assert!(WorldRect::new(Vec2::new(0.0, 0.0), Vec2::new(0.0, 1.0)).is_none());
    assert!(WorldRect::new(Vec2::new(0.0, f64::NAN), Vec2::new(1.0, 1.0)).is_none());
}

#[test]
fn a_few_stray_returns_do_not_shrink_the_map() {
    let mut stray = building::true_map(100, 100);
    let o = &mut stray.observations;
    o.points.push([500.0, 500.0]);
    o.normals.push([0.0, 0.0]);
    o.ranges_m.push(700.0);
    *o.starts.last_mut().unwrap() += 1;
    assert!(WorldRect::around(&stray).size().x < 40.0);
}

#[test]
fn the_svg_of_many_points_stays_small() {
    let big = building::true_map(700, 300);
    assert!(big.observations.len() > 150_000);
    let svg = map(&big, &MapPictureOptions::default()).to_svg();
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
}

#[test]
fn every_symbol_of_the_font_has_a_glyph_and_a_width() {
    let missing = text_width_px("\u{4E00}", 100.0);
    for c in (' '..='~').chain("°·–×σχ²±µ→θΔ−".chars()) {
        let width = text_width_px(&c.to_string(), 100.0);
        assert!(width > 20.0 && (width != missing || c == '?'), "{c}: {width}");
    }
    assert!((text_width_px("mm", 10.0) - 2.0 * text_width_px("m", 10.0)).abs() < 1e-4);
}

#[test]
fn plots_have_round_ticks_and_survive_values_without_a_place() {
    let points = vec![[0.0, 0.3], [50.0, f64::NAN], [100.0, 0.9], [150.0, 0.0]];
    let series =
        |mark| Series { label: "error".into(), points: points.clone(), intervals: vec![[0.2, 0.4]; 4], mark };
    for log_y in [false, true] {
        for mark in [Mark::Line, Mark::Dots, Mark::Bars] {
            let plot = Plot { series: vec![series(mark), series(mark)], log_y, ..Plot::default() };
            let picture = plot.draw();
            assert!(texts(&picture).contains(&"50") && texts(&picture).contains(&"error"));
            assert_eq!(picture.to_png(), plot.draw().to_png());
        }
    }
    assert!(Plot::default().draw().to_png().len() > 60, "an empty plot");
}

#[test]
fn an_ellipse_has_the_axes_of_the_covariance() {
    let mut one = SlamMap { poses: vec![Pose2::new(0.0, 0.0, 0.0)], ..SlamMap::default() };
    one.observations = Observations::empty(1);
    let crop = WorldRect::new(Vec2::new(-5.0, -5.0), Vec2::new(5.0, 5.0));
    // σ = 1 m along 30°, 0.2 m across.
    let (s, c) = (30.0_f64).to_radians().sin_cos();
    let covariance = [c * c + 0.04 * s * s, (1.0 - 0.04) * s * c, s * s + 0.04 * c * c];
    let options = MapPictureOptions {
        size_px: 1000,
        crop,
        position_covariances: Some(vec![covariance]),
        ..Default::default()
    };
    let picture = map(&one, &options);
    let rings: Vec<&Vec<[f32; 2]>> = picture
        .layers
        .iter()
        .filter(|l| l.clip.is_some())
        .flat_map(|l| &l.items)
        .filter_map(|i| match i {
            Item::Line { points, .. } => Some(points),
            _ => None,
        })
        .collect();
    assert_eq!(rings.len(), 1);
    let area = picture.area_of(&picture.layers[0]);
    let middle = [area.left + area.width / 2.0, area.top + area.height / 2.0];
    let metres = |p: &[f32; 2]| [(p[0] - middle[0]) / 100.0, (middle[1] - p[1]) / 100.0];
    for p in rings[0] {
        let [x, y] = metres(p).map(f64::from);
        let (along, across) = (c * x + s * y, c * y - s * x);
        let r = along.powi(2) + (across / 0.2).powi(2);
        assert!((r - 1.0).abs() < 0.02, "{x} {y}: {r}");
    }
}

/// A map of one pose that saw nothing.
fn lone_pose() -> SlamMap {
    let mut one = SlamMap { poses: vec![Pose2::IDENTITY], ..Default::default() };
    one.observations.end_pose();
    one
}

#[test]
fn errors_are_coloured_by_size_with_the_largest_on_top() {
    let one = lone_pose();
    // 100 errors of 1 to 100 cm: the bulk ends at 0.95 m, so the classes are quarters of a metre.
    let errors: Vec<(Vec2, f64)> = (1..=100).map(|k| (Vec2::zeros(), 0.01 * f64::from(k))).collect();
    let placed = PlacedErrors { what: "error".into(), errors };
    let picture = map(&one, &MapPictureOptions { errors: Some(placed), ..Default::default() });
    let counts: Vec<usize> = items(&picture)
        .filter_map(|i| if let Item::Shapes { outlines, .. } = i { Some(outlines) } else { None })
        .filter(|outlines| outlines.iter().all(|o| o.len() == 8))
        .map(Vec::len)
        .collect();
    assert_eq!(counts, [24, 25, 25, 25, 1], "small ones first");
    let words = texts(&picture);
    for label in ["error (m)", "< 0.25", "0.25+", "0.5+", "0.75+", "1+"] {
        assert!(words.contains(&label), "{label} in {words:?}");
    }
}

#[test]
fn errors_of_odd_size_are_drawn_without_a_fault() {
    let one = lone_pose();
    for sizes in [&[][..], &[0.0], &[0.0, f64::NAN], &[f64::INFINITY], &[1e-300, 1e300]] {
        let errors = sizes.iter().map(|&e| (Vec2::zeros(), e)).collect();
        let placed = PlacedErrors { what: "error".into(), errors };
        let picture =
            map(&one, &MapPictureOptions { size_px: 200, errors: Some(placed), ..Default::default() });
        assert!(texts(&picture).contains(&"error (m)"), "{sizes:?}");
        picture.to_png();
    }
}

#[test]
fn red_and_blue_strokes_that_were_only_laid_over_a_map_are_explained() {
    let one = lone_pose();
    let overlay = |colour| Overlay {
        ends: [Vec2::zeros(), Vec2::new(1.0, 0.0)],
        label: "1".into(),
        colour,
        width_px: 5.0,
    };
    let drawn = |overlays| map(&one, &MapPictureOptions { overlays, ..Default::default() });
    let both = drawn(vec![overlay(Colour::RED), overlay(Colour::BLUE)]);
    assert!(texts(&both).contains(&"stroke a") && texts(&both).contains(&"stroke b"), "{:?}", texts(&both));
    assert!(!texts(&drawn(vec![overlay(Colour::RED)])).contains(&"stroke a"));
}
