//! Nothing that was acknowledged is ever lost, and a replay is what was on screen.

use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

use hitl_slam::io::native;
use serde_json::json;

use super::{Served, room_folder};
use crate::cli::hitl_in;
use crate::support::Dice;

const MODES: [&str; 4] = ["colocation", "collinear", "perpendicular", "parallel"];

/// Does something that a person might do; true if it was acknowledged.
fn something(served: &Served, dice: &mut Dice) -> bool {
    let state = served.state();
    let ids: Vec<&str> =
        state["corrections"].as_array().unwrap().iter().filter_map(|c| c["id"].as_str()).collect();
    let id = ids.get(dice.index(ids.len().max(1))).copied().unwrap_or("nobody");
    let closures = served.get("/api/closures").json();
    let names = |of: &str| -> Vec<String> {
        closures[of]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|f| f["name"].as_str().map(str::to_owned))
            .collect()
    };
    let (found, refused) = (names("factors"), names("refused"));
    let name =
        |of: &[String], dice: &mut Dice| of.get(dice.index(of.len().max(1))).cloned().unwrap_or("1-2".into());
    let reply = match dice.index(12) {
        9 => served.act(json!({"event": "match"})),
        10 => served.act(json!({"event": "refuse", "name": name(&found, dice)})),
        11 => served.act(json!({"event": "allow", "name": name(&refused, dice)})),
        0..=3 => served.commit(dice.index(4), MODES[dice.index(4)]),
        4 => served.act(json!({"event": "undo"})),
        5 => served.act(json!({"event": "redo"})),
        6 => served.act(json!({"event": "enable", "id": id, "enabled": dice.index(2) == 0})),
        7 => served.act(json!({"event": "reweight", "id": id, "weight": dice.uniform(0.2, 4.0)})),
        _ => served.act(json!({"event": "delete", "id": id})),
    };
    assert!([200, 400, 422].contains(&reply.status), "{}", reply.head);
    reply.status == 200
}

/// The map that the page could save now.
fn exported(served: &Served) -> Vec<u8> {
    let reply = served.get("/api/export?format=npz");
    assert_eq!(reply.status, 200);
    reply.body
}

fn replayed(folder: &Path) -> Vec<u8> {
    let run = hitl_in(folder, "replay session.jsonl -o replayed.npz");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    std::fs::read(folder.join("replayed.npz")).unwrap()
}

#[test]
fn a_hundred_sessions_killed_at_any_moment_lose_nothing_and_replay_to_the_byte() {
    for seed in 0..100 {
        let dice = &mut Dice::new(seed);
        let (scratch, _) = room_folder(&format!("kill-{seed}"));
        let folder = scratch.path("");
        let log = scratch.path("session.jsonl");
        let mut acknowledged = 0;
        for _ in 0..2 {
            let served = Served::start(&folder, &["map.npz"]);
            let events = std::fs::read_to_string(&log).unwrap().lines().count() - 1;
            assert!(events >= acknowledged, "seed {seed}: {events} events of {acknowledged} acknowledged");
            assert!(events <= acknowledged + 1, "seed {seed}: more than was asked for");
            acknowledged = events;
            for _ in 0..1 + dice.index(4) {
                acknowledged += usize::from(something(&served, dice));
            }
            if dice.index(2) == 0 {
                let shown = exported(&served);
                assert!(replayed(&folder) == shown, "seed {seed}: the replay is another map");
            }
            // Killed while it does nothing, or in the middle of something that is then never acknowledged.
            if dice.index(2) == 0 {
                let revision = served.state()["revision"].clone();
                let event = if dice.index(2) == 0 { "undo" } else { "redo" };
                let body = json!({"event": event, "revision": revision}).to_string();
                let mut stream = TcpStream::connect(("127.0.0.1", served.port)).unwrap();
                let request = format!(
                    "POST /api/act HTTP/1.0\r\nHost: {}\r\nx-hitl-token: {}\r\nContent-Length: {}\r\n\r\n{body}",
                    served.host(),
                    served.token,
                    body.len()
                );
                stream.write_all(request.as_bytes()).unwrap();
                std::thread::sleep(Duration::from_micros(dice.index(6000) as u64));
            }
            served.kill();
            // A write that was cut in the middle.
            if dice.index(3) == 0 {
                let mut text = std::fs::read(&log).unwrap();
                text.extend_from_slice(&br#"{"at":1,"event":"delete","id":"c1"}"#[..1 + dice.index(30)]);
                std::fs::write(&log, text).unwrap();
            }
        }
        let served = Served::start(&folder, &["map.npz"]);
        assert!(exported(&served) == replayed(&folder), "seed {seed}");
    }
}

#[test]
fn correct_follows_a_session_in_which_visits_were_matched_to_the_byte() {
    let (scratch, _) = room_folder("matched");
    let folder = scratch.path("");
    let served = Served::start(&folder, &["map.npz"]);
    let revision = || json!({"revision": served.state()["revision"]}).to_string();
    for k in 0..2 {
        assert_eq!(served.commit(k, "collinear").status, 200);
        assert_eq!(served.post("/api/match", revision()).status, 200);
        assert_eq!(served.state()["matching"]["is_current"], false, "found, and not yet shown");
        assert_eq!(served.act(json!({"event": "match"})).status, 200);
        assert_eq!(served.state()["matching"]["is_current"], true);
    }
    let name = served.get("/api/closures").json()["factors"][0]["name"].as_str().unwrap().to_owned();
    assert_eq!(served.act(json!({"event": "refuse", "name": name})).status, 200);
    assert_eq!(served.commit(2, "parallel").status, 200);
    assert_eq!(served.act(json!({"event": "match"})).status, 200);
    assert_eq!(served.post("/api/match", r#"{"revision": 1}"#).status, 409, "of a map that is gone");
    let shown = exported(&served);
    assert!(replayed(&folder) == shown);
    let run = hitl_in(&folder, "correct map.npz -c session.jsonl -o by-correct.npz --report -");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(std::fs::read(scratch.path("by-correct.npz")).unwrap() == shown);
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let factors = report["automatic_factors"].as_array().unwrap();
    assert!(!factors.is_empty() && factors.iter().all(|f| f["name"] != name.as_str()));
    // The strokes alone, if that is what is wanted.
    let run = hitl_in(&folder, "correct map.npz -c session.jsonl --no-reassociate -o alone.npz");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(native::read(&scratch.path("alone.npz")).unwrap().value.automatic_factors.is_empty());
}

#[test]
fn correct_accepts_a_session_and_gives_the_map_that_was_on_screen() {
    let (scratch, _) = room_folder("correct");
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    for k in 0..3 {
        assert_eq!(served.commit(k, "collinear").status, 200);
    }
    assert_eq!(served.act(json!({"event": "reweight", "id": "c2", "weight": 2.5})).status, 200);
    assert_eq!(served.act(json!({"event": "enable", "id": "c1", "enabled": false})).status, 200);
    assert_eq!(served.act(json!({"event": "straighten", "stroke": [[-1.0, -4.0], [1.0, -3.9]]})).status, 200);
    let shown = exported(&served);
    assert_eq!(served.interrupt(), Some(0));
    let run =
        hitl_in(&scratch.path(""), "correct map.npz -c session.jsonl --no-reassociate -o by-correct.npz");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(std::fs::read(scratch.path("by-correct.npz")).unwrap() == shown);
    assert!(replayed(&scratch.path("")) == shown);
    let moved = native::read(&scratch.path("by-correct.npz")).unwrap().value;
    assert_eq!(moved.human_factors.len(), 2);
    // The corrections alone are a file of corrections.
    let lone = std::fs::read_to_string(scratch.path("session.jsonl")).unwrap();
    std::fs::rename(scratch.path("map.npz"), scratch.path("moved.npz")).unwrap();
    let run = hitl_in(&scratch.path(""), "replay session.jsonl -o x.npz");
    assert!(run.code == Some(2) && run.stderr.contains("map.npz: found no such file"), "{}", run.stderr);
    let run = hitl_in(&scratch.path(""), "replay session.jsonl -o x.npz --map moved.npz");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let run = hitl_in(&scratch.path(""), "replay session.jsonl -o y.npz --map by-correct.npz");
    assert!(run.code == Some(2) && run.stderr.contains("session.jsonl:1: sha256: "), "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(scratch.path("session.jsonl")).unwrap(), lone);
}

#[test]
fn every_export_of_the_page_is_what_hitl_export_writes() {
    let (scratch, _) = room_folder("exports");
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    assert_eq!(served.commit(1, "collinear").status, 200);
    std::fs::write(scratch.path("now.npz"), exported(&served)).unwrap();
    for (format, ending) in [
        ("g2o", "g2o"),
        ("toro", "graph"),
        ("stfs", "stfs.covars"),
        ("tum", "tum"),
        ("clf", "clf"),
        ("ply", "ply"),
    ] {
        let reply = served.get(&format!("/api/export?format={format}"));
        assert_eq!(reply.status, 200, "{format}");
        assert!(reply.head.contains(&format!("filename=\"map-corrected.{ending}\"")), "{}", reply.head);
        let run = hitl_in(&scratch.path(""), &format!("export now.npz -o by-hand/map-corrected.{ending}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let by_hand = std::fs::read(scratch.path(&format!("by-hand/map-corrected.{ending}"))).unwrap();
        assert!(by_hand == reply.body || format == "stfs" && by_hand.len() == reply.body.len(), "{format}");
    }
    let zipped = served.get("/api/export?format=pgm");
    assert!(zipped.status == 200 && zipped.body.starts_with(b"PK"));
    let lines = String::from_utf8(served.get("/api/export?format=corrections").body).unwrap();
    scratch.file("c.jsonl", &lines);
    let run = hitl_in(&scratch.path(""), "correct map.npz -c c.jsonl --no-reassociate -o again.npz");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(std::fs::read(scratch.path("again.npz")).unwrap() == exported(&served));
    let picture = served.get("/api/picture");
    assert!(picture.status == 200 && picture.body.starts_with(b"\x89PNG"));
    assert!(!scratch.path("hitl-maps").exists(), "exports leave nothing behind");
}
