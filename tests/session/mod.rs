mod file;
mod matching;
mod strokes;
mod undo;

use std::path::PathBuf;

use hitl_slam::geometry::Pose2;
use hitl_slam::io::native;
use hitl_slam::map::{Correction, Mode, SlamMap};
use hitl_slam::session::{Answer, Event, EventResult, Session, Source, read, replay};

use crate::support::{Dice, Scratch, room};

/// A map on disk, and the session beside it.
pub struct Desk {
    pub scratch: Scratch,
    pub map: SlamMap,
    pub source: Source,
}

impl Desk {
    pub fn new(test: &str) -> Self {
        let scratch = Scratch::new(&format!("session-{test}"));
        let map = room::map(3);
        let path = scratch.path("map.npz");
        native::write(&path, &map).unwrap();
        // As it reads back: what the program would start from.
        let map = native::read(&path).unwrap().value;
        Desk { scratch, map, source: Source::of(&path).unwrap() }
    }

    pub fn log(&self) -> PathBuf {
        self.scratch.path("session.jsonl")
    }

    pub fn open(&self) -> Session {
        Session::open(self.map.clone(), self.source.clone(), &self.log(), &mut |_, _| true).unwrap().0
    }

    /// The bytes of the map that a session shows.
    pub fn shown(&self, session: &Session) -> Vec<u8> {
        self.bytes(&session.solved().map())
    }

    pub fn bytes(&self, map: &SlamMap) -> Vec<u8> {
        let path = self.scratch.path("bytes.npz");
        native::write(&path, map).unwrap();
        std::fs::read(path).unwrap()
    }

    /// The bytes of the map that a replay of the file gives.
    pub fn replayed(&self) -> Vec<u8> {
        let content = read(&self.log()).unwrap();
        let log = self.log();
        let (solved, _) = replay(self.map.clone(), &self.source, &content, &log, &mut |_, _| true).unwrap();
        self.bytes(&solved.map())
    }
}

/// The room's four walls under the next free names of a session.
pub fn wall(session: &Session, k: usize, mode: Mode) -> Event {
    let correction = room::corrections([mode; 4])[k].clone();
    Event::Correct(Correction { id: session.history().free_id(), ..correction }, EventResult::default())
}

pub fn act(session: &mut Session, event: Event) -> Answer {
    session.act(event, 1_700_000_000, &mut |_, _| true).unwrap()
}

pub fn done(session: &mut Session, event: Event) {
    let name = event.name();
    assert_eq!(act(session, event), Answer::Done, "{name}");
}

/// Something a person might do next.
pub fn any_event(session: &Session, dice: &mut Dice) -> Event {
    let corrections = &session.state().corrections;
    let id = |dice: &mut Dice| {
        let k = dice.index(corrections.len().max(1));
        corrections.get(k).map_or("nobody".into(), |c| c.id.clone())
    };
    match dice.index(13) {
        10 => Event::Match(Default::default()),
        11 | 12 => {
            let factors = &session.solved().corrector().map().automatic_factors;
            let refused = &session.state().refused;
            match (factors.get(dice.index(factors.len().max(1))), refused.first()) {
                (_, Some((i, j))) if dice.index(2) == 0 => Event::Allow(*i, *j),
                (Some(a), _) => Event::Refuse(a.factor.i, a.factor.j),
                _ => Event::Refuse(3, 64),
            }
        }
        0..=3 => wall(session, dice.index(4), Mode::ALL[dice.index(4)]),
        4 => Event::Undo,
        5 => Event::Redo,
        6 => Event::Enable(id(dice), dice.index(2) == 0),
        7 => Event::Reweight(id(dice), dice.uniform(0.1, 5.0)),
        8 => Event::Delete(id(dice)),
        _ => match wall(session, dice.index(4), Mode::Parallel) {
            Event::Correct(c, _) => Event::Straighten((dice.index(3) > 0).then_some(c.a)),
            other => other,
        },
    }
}

/// The angle of a direction to the nearest axis, radians.
pub fn off_axis(pose: Pose2, direction_rad: f64) -> f64 {
    let angle = (pose.theta_rad + direction_rad).rem_euclid(std::f64::consts::FRAC_PI_2);
    angle.min(std::f64::consts::FRAC_PI_2 - angle)
}
