//! What takes long: it says how far it is, it can be given up over HTTP, and the page is answered meanwhile.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{Reply, Served, room_folder};
use crate::support::Scratch;

const ACES: &[u8] = include_bytes!("../../data/aces.clf.bz2");

/// Waits until a work of this name is going on, with its progress if `begun`.
fn work(served: &Served, what: &str, begun: bool) -> Value {
    let start = Instant::now();
    loop {
        let works = served.state()["works"].as_array().unwrap().clone();
        let found = works.into_iter().find(|w| w["what"].as_str().is_some_and(|w| w.starts_with(what)));
        if let Some(work) = found.filter(|w| !begun || w["done"].as_u64() > Some(0)) {
            return work;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "\"{what}\" never began");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Asks for something long, gives it up as soon as it is there (has done something, if `begun`), and hands back what was answered.
fn given_up(served: &Served, what: &str, begun: bool, ask: impl FnOnce() -> Reply + Send) -> Reply {
    std::thread::scope(|scope| {
        let asked = scope.spawn(ask);
        let id = work(served, what, begun)["id"].clone();
        let at = Instant::now();
        assert_eq!(
            served.post("/api/cancel", json!({"id": id}).to_string()).json(),
            json!({"cancelled": true})
        );
        let reply = asked.join().unwrap();
        assert!(at.elapsed() < Duration::from_secs(20), "it took {:?} to give up", at.elapsed());
        let works = served.state()["works"].clone();
        assert_eq!(works, json!([]), "nothing is left running");
        reply
    })
}

fn error(reply: &Reply) -> String {
    reply.json()["error"].as_str().unwrap().to_owned()
}

/// A session with the shipped corrections of ACES, changed like this.
fn session_of_aces(map: &Path, change: impl FnOnce(&mut Vec<Value>)) -> String {
    let sha256 = hitl_slam::session::Source::of(map).unwrap().sha256;
    let header = json!({"event": "session", "version": "0.1.0", "map": "aces.clf.bz2", "sha256": sha256});
    let lines = include_str!("../../data/aces.corrections.jsonl").lines();
    let mut corrections: Vec<Value> = lines.map(|line| serde_json::from_str(line).unwrap()).collect();
    change(&mut corrections);
    for correction in &mut corrections {
        (correction["event"], correction["at"]) = (json!("correct"), json!(1_790_000_000));
    }
    [&[header][..], &corrections].concat().iter().map(|line| format!("{line}\n")).collect()
}

#[test]
fn opening_a_log_by_scan_matching_is_given_up_and_leaves_what_was_open() {
    let (scratch, _) = room_folder("give-up-open");
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    let before = served.state()["map"].clone();
    let upload = || {
        let headers = [
            ("Host", served.host()),
            ("x-hitl-token", served.token.clone()),
            ("x-hitl-name", "aces.clf.bz2".into()),
            ("x-hitl-start", "scan-match".into()),
        ];
        served.ask("POST", "/api/open", &headers.each_ref().map(|(a, b)| (*a, b.as_str())), ACES)
    };
    let reply = given_up(&served, "matching the scans of aces.clf.bz2", true, upload);
    assert_eq!((reply.status, error(&reply).as_str()), (409, "given up: nothing has changed"));
    assert_eq!(served.state()["map"], before);
    assert!(!scratch.path("hitl-maps").exists(), "nothing is left behind");
}

#[test]
fn matching_visits_is_given_up_by_the_person_or_by_a_change_of_the_map_and_nothing_waits_for_it() {
    let scratch = Scratch::new("serve-give-up-match");
    scratch.file("aces.clf.bz2", ACES);
    let served = Served::start(&scratch.path(""), &["aces.clf.bz2"]);
    let log = scratch.path("session.jsonl");
    let revision = || json!({"revision": served.state()["revision"]}).to_string();
    let poses = served.get("/api/poses").body;
    let reply = given_up(&served, "matching visits", true, || served.post("/api/match", revision()));
    assert_eq!((reply.status, error(&reply).as_str()), (409, "given up"));
    assert!(served.get("/api/poses").body == poses);
    assert_eq!(std::fs::read_to_string(&log).unwrap().lines().count(), 1, "nothing was written down");

    // A change of the map: what was going to be found is of no use any more.
    std::thread::scope(|scope| {
        let asked = scope.spawn(|| served.post("/api/match", revision()));
        work(&served, "matching visits", true);
        let stroke = json!({"event": "straighten", "stroke": [[-0.9, -1.5], [-3.4, -1.5]]});
        let at = Instant::now();
        assert_eq!(served.act(stroke).status, 200);
        assert!(at.elapsed() < Duration::from_secs(2), "an event waited {:?} for the matching", at.elapsed());
        let reply = asked.join().unwrap();
        assert_eq!(
            (reply.status, error(&reply).as_str()),
            (409, "the map has changed meanwhile: look again")
        );
    });

    // As an event it is waited for, and can be given up, too.
    let reply = given_up(&served, "solving", true, || served.act(json!({"event": "match"})));
    assert_eq!((reply.status, error(&reply).as_str()), (409, "given up: nothing has changed"));
    assert_eq!(std::fs::read_to_string(&log).unwrap().lines().count(), 2);
}

#[test]
fn a_suggestion_comes_as_two_strokes_with_their_poses_changes_nothing_and_is_given_up() {
    let scratch = Scratch::new("serve-suggest");
    scratch.file("aces.clf.bz2", ACES);
    let served = Served::start(&scratch.path(""), &["aces.clf.bz2"]);
    let revision = served.state()["revision"].clone();
    let ask = || served.post("/api/suggest", json!({"revision": revision}).to_string());
    let reply = given_up(&served, "looking where a stroke would help", false, ask);
    assert_eq!((reply.status, error(&reply)), (409, "given up".into()));

    let before = served.get("/api/poses").body;
    let suggestion = ask().json()["suggestion"].clone();
    assert_eq!(served.get("/api/poses").body, before, "the map is as it was");
    assert!(suggestion["reason"].as_str().unwrap().contains("pose"), "{suggestion}");
    let [a, b] = [0, 1].map(|k| suggestion["strokes"][k].clone());
    let mut asked = json!({"mode": suggestion["mode"], "weight": suggestion["weight"], "a": a, "b": b,
        "anchors": suggestion["anchors"], "revision": revision});
    let preview = served.post("/api/preview", asked.to_string()).packed();
    assert_eq!(preview["accepted"], true, "{preview}");
    let committed = served.post("/api/commit", asked.to_string());
    assert_eq!(committed.status, 200);
    let log = std::fs::read_to_string(scratch.path("session.jsonl")).unwrap();
    let correction: Value = serde_json::from_str(log.lines().last().unwrap()).unwrap();
    assert_eq!(json!([correction["a"]["pose"], correction["b"]["pose"]]), suggestion["anchors"]);

    asked["revision"] = served.state()["revision"].clone();
    for bad in [json!([0, 1_000_000]), json!([0]), json!("c1")] {
        asked["anchors"] = bad;
        let refused = served.post("/api/preview", asked.to_string());
        assert_eq!(refused.status, 400);
        assert!(error(&refused).starts_with("anchors: found"), "{}", error(&refused));
    }
    let outdated = ask();
    assert_eq!(outdated.status, 409, "{}", error(&outdated));
}

#[test]
fn a_cross_check_is_given_up() {
    if !hitl_slam::joint::Backend::Ceres.available() {
        crate::support::both_backends::skipped("built without Ceres");
        return;
    }
    let scratch = Scratch::new("serve-give-up-crosscheck");
    let map = scratch.file("aces.clf.bz2", ACES);
    scratch.file("session.jsonl", session_of_aces(&map, |_| {}));
    let served = Served::start(&scratch.path(""), &["aces.clf.bz2"]);
    assert_eq!(served.state()["corrections"].as_array().unwrap().len(), 8);
    let reply = given_up(&served, "cross-checking", false, || served.post("/api/crosscheck", ""));
    assert_eq!((reply.status, error(&reply).as_str()), (409, "given up"));
}

#[test]
fn a_correction_that_contradicts_the_rest_is_named_after_the_map_is_shown_and_until_it_is_gone() {
    let scratch = Scratch::new("serve-judge");
    let map = scratch.file("aces.clf.bz2", ACES);
    scratch.file(
        "session.jsonl",
        session_of_aces(&map, |corrections| {
            let north = corrections.iter().find(|c| c["id"] == "north-junction").unwrap()["b"].clone();
            corrections.iter_mut().find(|c| c["id"] == "east-junction").unwrap()["b"] = north;
        }),
    );
    let served = Served::start(&scratch.path(""), &["aces.clf.bz2"]);
    let named = || -> Vec<String> {
        let state = served.state();
        assert_eq!(state["unjudged"], Value::Null);
        let has = |c: &&Value| !c["conflicts"].as_array().unwrap().is_empty();
        let all = state["corrections"].as_array().unwrap().clone();
        all.iter().filter(has).filter_map(|c| c["id"].as_str().map(str::to_owned)).collect()
    };
    let becomes = |wanted: &[&str]| {
        let start = Instant::now();
        while named() != wanted {
            assert!(start.elapsed() < Duration::from_secs(30), "{:?} instead of {wanted:?}", named());
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    assert!(named().contains(&"east-junction".to_owned()), "{:?}", named());
    let off = json!({"event": "enable", "id": "east-junction", "enabled": false});
    assert_eq!(served.act(off).status, 200);
    becomes(&[]);
    assert_eq!(served.act(json!({"event": "undo"})).status, 200);
    let start = Instant::now();
    while !named().contains(&"east-junction".to_owned()) {
        assert!(start.elapsed() < Duration::from_secs(30), "it is named again");
        std::thread::sleep(Duration::from_millis(5));
    }
}
