//! What `hitl export` writes, read back.

use hitl_slam::geometry::Pose2;
use hitl_slam::io::{self, carmen, carmen_log, occupancy, ply};

use crate::building::true_map;
use crate::support::{Scratch, small_log};

#[test]
fn a_carmen_log_of_a_map_comes_back_with_its_poses_odometry_and_returns() {
    let scratch = Scratch::new("export-carmen");
    let mut map = hitl_slam::simulate::run(
        hitl_slam::simulate::Scenario::LostPoses,
        &hitl_slam::simulate::Settings::default(),
    )
    .unwrap()
    .map;
    let odometry = map.poses.clone();
    map.poses
        .iter_mut()
        .enumerate()
        .for_each(|(k, p)| *p = p.compose(Pose2::new(0.001 * k as f64, 0.0, 0.1)));
    let path = scratch.path("a.clf");
    carmen_log::write(&path, &carmen_log::of_map(&map)).unwrap();
    assert!(std::fs::read_to_string(&path).unwrap().contains("\nFLASER 181 "));
    let log = carmen::read(&path).unwrap().value;
    assert_eq!(log.scans.len(), map.poses.len());
    // The offset of corrected poses from the odometry is no constant: the PARAM says where the laser sits.
    assert!((log.robot_from_laser.x_m - 0.15).abs() < 1e-9);
    for (i, scan) in log.scans.iter().enumerate() {
        let wanted = [(map.poses[i], scan.world_from_robot)];
        // Odometry starts at the corrected first pose; only its motion means anything.
        let steps = odometry[0].between(odometry[i]);
        let got = log.scans[0].odometry_from_robot.between(scan.odometry_from_robot);
        for (p, q) in wanted.into_iter().chain([(steps, got)]) {
            let off = p.between(q);
            assert!(off.translation().norm() < 1e-9 && off.theta_rad.abs() < 1e-9, "scan {i}: {off:?}");
        }
        let returns = scan.ranges_m.iter().filter(|&&r| f64::from(r) < scan.max_range_m).count();
        assert_eq!(returns, map.observations.range(i).len());
    }
}

#[test]
fn a_corrected_log_keeps_every_range_and_the_odometry_of_its_source() {
    let scratch = Scratch::new("export-log");
    let source = scratch.file("a.log", small_log(12));
    let log = carmen::read(&source).unwrap().value;
    let mut trajectory = hitl_slam::map::Trajectory::default();
    for (k, scan) in log.scans.iter().enumerate() {
        trajectory.stamps_s.push(scan.stamp_s);
        trajectory.poses.push(Pose2::new(k as f64, 2.0, 0.3 * k as f64));
    }
    let path = scratch.path("b.log");
    carmen_log::write(&path, &carmen_log::corrected(&log, &trajectory).unwrap()).unwrap();
    let back = carmen::read(&path).unwrap().value;
    for ((old, new), pose) in log.scans.iter().zip(&back.scans).zip(&trajectory.poses) {
        assert_eq!((&old.ranges_m, old.stamp_s), (&new.ranges_m, new.stamp_s));
        assert_eq!(old.odometry_from_robot, new.odometry_from_robot);
        assert!(pose.between(new.world_from_robot).translation().norm() < 1e-9);
    }
    trajectory.stamps_s.iter_mut().for_each(|s| *s += 1e6);
    assert!(carmen_log::corrected(&log, &trajectory).is_err());
}

#[test]
fn a_ply_has_every_point_in_the_world() {
    let scratch = Scratch::new("export-ply");
    let map = true_map(20, 30);
    let path = scratch.path("a.ply");
    ply::write(&path, &map).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, body) = text.split_once("end_header\n").unwrap();
    assert!(head.contains(&format!("element vertex {}\n", map.observations.len())));
    let rows: Vec<Vec<f64>> =
        body.lines().map(|l| l.split(' ').map(|n| n.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), map.observations.len());
    for (k, row) in rows.iter().enumerate() {
        let p = map.poses[map.observations.pose_of(k)].transform_point(map.observations.point(k));
        assert_eq!((row[0], row[1], row[6] as usize), (p.x, p.y, map.observations.pose_of(k)));
    }
}

#[test]
fn an_occupancy_grid_is_black_at_the_returns_white_at_the_robot_and_turned_as_told() {
    let scratch = Scratch::new("export-pgm");
    let map = true_map(200, 180);
    for yaw_rad in [0.0, 0.6, -2.0] {
        let grid = occupancy::draw(&map, 0.05, yaw_rad).unwrap();
        let path = scratch.path("a.pgm");
        occupancy::write(&path, &grid).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let head = format!("P5\n{} {}\n255\n", grid.columns, grid.rows);
        assert!(bytes.starts_with(head.as_bytes()));
        let raster = &bytes[head.len()..];
        assert_eq!(raster.len(), grid.columns * grid.rows);
        let yaml = std::fs::read_to_string(scratch.path("a.yaml")).unwrap();
        let field = |name: &str| yaml.lines().find_map(|l| l.strip_prefix(name)).unwrap().trim().to_owned();
        assert_eq!((field("image:"), field("resolution:")), ("a.pgm".into(), "0.05".into()));
        let origin = field("origin:");
        let origin: Vec<f64> =
            origin.trim_matches(['[', ']']).split(',').map(|n| n.trim().parse().unwrap()).collect();
        assert_eq!(origin[2], 0.0, "the rotation is in the raster");
        // As the map server reads it: the first row is the top.
        let at = |p: hitl_slam::geometry::Vec2| {
            let (x, y) = ((p.x - origin[0]) / 0.05, (p.y - origin[1]) / 0.05);
            raster[(grid.rows - 1 - y as usize) * grid.columns + x as usize]
        };
        let turn = Pose2::new(0.0, 0.0, yaw_rad);
        let black = (0..map.observations.len()).filter(|&k| {
            let p = map.poses[map.observations.pose_of(k)].transform_point(map.observations.point(k));
            at(turn.transform_point(p)) == occupancy::OCCUPIED
        });
        let share = black.count() as f64 / map.observations.len() as f64;
        assert!(share > 0.85, "yaw {yaw_rad}: only {share} of the returns are black");
        assert!(map.poses.iter().all(|p| at(turn.transform_point(p.translation())) != occupancy::OCCUPIED));
        assert_eq!(raster[0], occupancy::UNKNOWN);
    }
}

#[test]
fn walls_and_pairs_come_back_as_written_and_a_fault_names_its_line() {
    let scratch = Scratch::new("export-walls");
    let s = hitl_slam::simulate::run(hitl_slam::simulate::Scenario::Loop, &Default::default()).unwrap();
    let (walls, pairs) = (scratch.path("walls.csv"), scratch.path("pairs.csv"));
    io::walls::write(&walls, &s.walls).unwrap();
    io::walls::write_pairs(&pairs, &s.pairs).unwrap();
    assert_eq!(io::walls::read_pairs(&pairs).unwrap().value, s.pairs);
    let back = io::walls::read(&walls).unwrap().value;
    assert_eq!(back.len(), s.walls.len());
    for (a, b) in back.iter().zip(&s.walls) {
        assert_eq!(a.name, b.name);
        assert!((a.segment.centre - b.segment.centre).norm() < 1e-12);
    }
    for (text, place) in [
        ("name,x1_m,y1_m,x2_m,y2_m\na,1,2,3\n", ":2: found 4 fields"),
        ("name,x1_m,y1_m,x2_m,y2_m\na,1,2,3,x\n", ":2: y2_m: found 'x'"),
        ("a,b\n", ":1: found 'a,b', expected the header"),
        ("name,x1_m,y1_m,x2_m,y2_m\n", "found no line of values"),
    ] {
        let path = scratch.file("bad.csv", text);
        let error = io::walls::read(&path).unwrap_err().to_string();
        assert!(error.contains(place), "{error}");
    }
    let path = scratch.file("bad.csv", "a,b,measure\nx,y,width\n");
    assert!(io::walls::read_pairs(&path).unwrap_err().to_string().contains("expected angle or distance"));
}
