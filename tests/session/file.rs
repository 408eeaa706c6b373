//! The file of a session: what survives, what is refused.

use hitl_slam::map::Mode;
use hitl_slam::session::{Event, Session, Source, is_session, log_path, read};

use super::{Desk, any_event, done, wall};
use crate::support::{Dice, message};

#[test]
fn every_prefix_of_a_session_is_one_and_holds_every_whole_event() {
    let desk = Desk::new("prefix");
    let mut session = desk.open();
    for k in 0..2 {
        let event = wall(&session, k, Mode::Parallel);
        done(&mut session, event);
    }
    done(&mut session, Event::Enable("c1".into(), false));
    done(&mut session, Event::Undo);
    drop(session);
    let whole = std::fs::read(desk.log()).unwrap();
    let first = whole.iter().position(|&b| b == b'\n').unwrap() + 1;
    for cut in first..=whole.len() {
        std::fs::write(desk.log(), &whole[..cut]).unwrap();
        let content = read(&desk.log()).unwrap();
        let lines = whole[..cut].iter().filter(|&&b| b == b'\n').count();
        assert_eq!(content.entries.len(), lines - 1);
        let is_cut = whole[cut - 1] != b'\n';
        assert_eq!(content.remark.is_some(), is_cut, "cut at {cut}");
        if let Some(remark) = content.remark {
            let said = format!("session.jsonl:{}: dropped a cut-off last line", lines + 1);
            assert!(remark.contains(&said), "{remark}");
        }
    }
}

#[test]
fn a_killed_write_is_dropped_with_a_message_and_the_session_goes_on() {
    let desk = Desk::new("killed");
    let mut session = desk.open();
    let event = wall(&session, 0, Mode::Collinear);
    done(&mut session, event);
    let shown = desk.shown(&session);
    drop(session);
    let mut text = std::fs::read(desk.log()).unwrap();
    text.extend_from_slice(br#"{"at": 5, "event": "del"#);
    std::fs::write(desk.log(), text).unwrap();
    let opened = Session::open(desk.map.clone(), desk.source.clone(), &desk.log(), &mut |_, _| true);
    let (mut session, remarks) = opened.unwrap();
    assert!(remarks.len() == 1 && remarks[0].contains("session.jsonl:3: dropped"), "{remarks:?}");
    assert!(desk.shown(&session) == shown);
    let event = wall(&session, 1, Mode::Collinear);
    done(&mut session, event);
    assert!(desk.replayed() == desk.shown(&session), "nothing of the cut line is left in the file");
}

#[test]
fn a_session_killed_in_its_first_line_begins_anew() {
    let desk = Desk::new("first-line");
    std::fs::write(desk.log(), br#"{"event": "sess"#).unwrap();
    let mut session = desk.open();
    let event = wall(&session, 0, Mode::Collinear);
    done(&mut session, event);
    assert!(desk.replayed() == desk.shown(&session));
}

#[test]
fn every_event_reads_back_as_it_was() {
    let desk = Desk::new("round-trip");
    let dice = &mut Dice::new(5);
    let mut session = desk.open();
    for _ in 0..60 {
        let event = any_event(&session, dice);
        let at_s = 1_700_000_000 + dice.index(1000) as u64;
        let entry = hitl_slam::session::Entry { at_s, event };
        let back = hitl_slam::session::Entry::parse(entry.to_line().as_bytes()).unwrap();
        assert_eq!(back, entry);
        if session.state().corrections.len() < 2 {
            let event = wall(&session, 0, Mode::Parallel);
            done(&mut session, event);
        }
    }
}

#[test]
fn only_one_program_at_a_time_writes_a_session() {
    let desk = Desk::new("alone");
    let first = desk.open();
    let second = Session::open(desk.map.clone(), desk.source.clone(), &desk.log(), &mut |_, _| true);
    assert!(message(second.map(|_| ())).contains("another hitl has it open, expected to be alone"));
    drop(first);
    desk.open();
}

#[test]
fn a_session_about_another_map_is_refused_and_left_alone() {
    let desk = Desk::new("other");
    drop(desk.open());
    let before = std::fs::read(desk.log()).unwrap();
    let mut other = desk.map.clone();
    other.poses[5].x_m += 1.0;
    let path = desk.scratch.path("other.npz");
    hitl_slam::io::native::write(&path, &other).unwrap();
    let source = Source::of(&path).unwrap();
    let refused = Session::open(other, source.clone(), &desk.log(), &mut |_, _| true);
    assert!(
        message(refused.map(|_| ())).starts_with("session.jsonl:1: sha256: found a session about map.npz")
    );
    assert!(std::fs::read(desk.log()).unwrap() == before);
    assert!(is_session(&desk.log()) && !is_session(&path));
    assert_eq!(log_path(&desk.source), desk.log());
    assert_eq!(log_path(&source), desk.scratch.path("other.npz.session.jsonl"));
}

#[test]
fn a_damaged_line_is_named_with_what_was_expected() {
    let desk = Desk::new("damaged");
    let mut session = desk.open();
    let event = wall(&session, 0, Mode::Collinear);
    done(&mut session, event);
    drop(session);
    let good = std::fs::read_to_string(desk.log()).unwrap();
    for (line, said) in [
        ("nonsense", "session.jsonl:3: found text that is not JSON"),
        (
            r#"{"event": "dance", "at": 1}"#,
            "event: found \"dance\", expected an event that this version knows",
        ),
        (r#"{"event": "undo"}"#, "at: found nothing, expected whole seconds"),
        (
            r#"{"event": "reweight", "at": 1, "id": "c1", "weight": -1}"#,
            "weight: found -1, expected a number > 0",
        ),
        (
            r#"{"event": "delete", "at": 1, "id": "c9"}"#,
            "id: found \"c9\", expected a correction that there is",
        ),
        (r#"{"event": "redo", "at": 1}"#, "session.jsonl:3: redo: found nothing to redo"),
        (r#"{"event": "undo", "at": 1, "x": 1}"#, "x: found an unknown field"),
        (r#"{"event": "session", "at": 1}"#, "event: found a second beginning"),
    ] {
        let text = format!("{good}{line}\n");
        std::fs::write(desk.log(), &text).unwrap();
        let refused = Session::open(desk.map.clone(), desk.source.clone(), &desk.log(), &mut |_, _| true);
        let told = message(refused.map(|_| ()));
        assert!(told.contains(said), "{told}");
        assert_eq!(std::fs::read_to_string(desk.log()).unwrap(), text, "left as it was");
    }
}
