//! Strokes as they are drawn on the map on screen: what they are warned of, what they hang on.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::interpret;
use hitl_slam::map::{Mode, SlamMap, Stroke};
use hitl_slam::session::{Event, Session, Source};

use super::{Desk, done, wall};

/// Where wall `k` is drawn in the first round, on the map on screen.
fn drawn(session: &Session, k: usize) -> [Vec2; 2] {
    let Event::Correct(c, _) = wall(session, k, Mode::Parallel) else { unreachable!() };
    let Stroke::Pose { pose, points } = c.a else { unreachable!() };
    let world_from_robot = session.solved().map().poses[pose];
    points.map(|p| world_from_robot.transform_point(p))
}

/// Both rounds through the room on the same poses, the second one moved by this.
fn twice(desk: &Desk, moved: Vec2) -> Session {
    let mut map: SlamMap = desk.map.clone();
    let round = map.poses.len() / 2;
    for k in 0..round {
        let p = map.poses[k];
        map.poses[round + k] = Pose2::new(p.x_m + moved.x, p.y_m + moved.y, p.theta_rad);
    }
    let path = desk.scratch.path("twice.npz");
    hitl_slam::io::native::write(&path, &map).unwrap();
    let log = desk.scratch.path("twice.jsonl");
    Session::open(map, Source::of(&path).unwrap(), &log, &mut |_, _| true).unwrap().0
}

#[test]
fn a_stroke_on_two_walls_or_on_few_points_is_warned_of_and_a_good_one_is_not() {
    let desk = Desk::new("warned");
    let good = twice(&desk, Vec2::zeros());
    let stroke = drawn(&good, 0);
    assert_eq!(good.catch(stroke).unwrap().1, None);
    let middle = (stroke[0] + stroke[1]) / 2.0;
    let short = stroke.map(|p| middle + 0.05 * (p - middle));
    if let Ok((caught, warning)) = good.catch(short) {
        assert!(caught.points.len() < 200, "{}", caught.points.len());
        assert!(warning.is_none_or(|w| w.starts_with("few points")));
    }
    drop(good);
    std::fs::remove_file(desk.scratch.path("twice.jsonl")).unwrap();
    let double = twice(&desk, Vec2::new(0.0, -0.09));
    let stroke = drawn(&double, 0).map(|p| p + Vec2::new(0.0, -0.045));
    let (_, warning) = double.catch(stroke).unwrap();
    let warning = warning.expect("a warning");
    assert!(warning.starts_with("two walls, ") && warning.contains("9 cm apart"), "{warning}");
}

#[test]
fn a_stroke_hangs_on_a_pose_that_saw_it_and_comes_back_where_it_was_drawn() {
    let desk = Desk::new("anchor");
    let mut session = desk.open();
    let Event::Correct(c, _) = wall(&session, 1, Mode::Collinear) else { unreachable!() };
    done(&mut session, Event::Straighten(Some(c.a)));
    let ends = drawn(&session, 2);
    let seen = session.catch(ends).unwrap().0;
    let stroke = session.anchor(ends);
    let Stroke::Pose { pose, .. } = stroke else { panic!("{stroke:?}") };
    let most = seen.poses.iter().map(|p| p.1).max();
    assert_eq!(seen.poses.iter().find(|p| p.0 == pose).map(|p| p.1), most);
    let map = session.solved().map();
    let back = interpret::in_world(&map, &map.poses, &stroke).unwrap();
    assert!((0..2).all(|k| (back[k] - ends[k]).norm() < 1e-9));
    // Where nothing is seen: the nearest pose.
    let far = [Vec2::new(300.0, 0.0), Vec2::new(301.0, 0.0)];
    let Stroke::Pose { pose, .. } = session.anchor(far) else { unreachable!() };
    let distance = |p: &Pose2| (p.translation() - far[0]).norm();
    let nearest = map.poses.iter().map(distance).fold(f64::INFINITY, f64::min);
    assert!(distance(&map.poses[pose]) < nearest + 1.0);
}
