//! Who may ask, and what happens to requests that are not as they should be.

use std::thread;

use serde_json::json;

use super::{Served, room_folder};
use crate::cli::hitl_in;

#[test]
fn a_request_without_the_token_or_from_elsewhere_is_refused() {
    let (scratch, _) = room_folder("guard");
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    let (host, token) = (served.host(), served.token.clone());
    let status = |path: &str, headers: &[(&str, &str)]| served.ask("GET", path, headers, b"").status;
    let page = format!("/?token={token}");
    assert_eq!(status(&page, &[("Host", &host)]), 200);
    assert_eq!(status("/api/state", &[("Host", &host), ("x-hitl-token", &token)]), 200);
    let wrong = token.replace(|c: char| c.is_ascii_digit(), "0");
    for (path, headers) in [
        ("/", vec![("Host", host.as_str())]),
        ("/?token=", vec![("Host", &host)]),
        ("/api/state", vec![("Host", &host)]),
        ("/api/points", vec![("Host", &host), ("x-hitl-token", "")]),
        ("/api/state", vec![("Host", &host), ("x-hitl-token", &wrong)]),
        (&format!("/api/state?token={token}"), vec![("Host", &host)]),
        ("/api/state", vec![("x-hitl-token", &token)]),
        ("/api/state", vec![("Host", "evil.example"), ("x-hitl-token", &token)]),
        ("/api/state", vec![("Host", "127.0.0.1.evil.example"), ("x-hitl-token", &token)]),
        ("/api/state", vec![("Host", &host), ("Origin", "http://evil.example"), ("x-hitl-token", &token)]),
        ("/api/state", vec![("Host", &host), ("Origin", "null"), ("x-hitl-token", &token)]),
        ("/api/state", vec![("Host", &host), ("Origin", "http://127.0.0.1:1"), ("x-hitl-token", &token)]),
        (&page, vec![("Host", "evil.example")]),
        ("/no/such/thing", vec![("Host", &host)]),
    ] {
        assert_eq!(status(path, &headers), 403, "{path} {headers:?}");
    }
    let origin = format!("http://{host}");
    assert_eq!(status("/api/state", &[("Host", &host), ("Origin", &origin), ("x-hitl-token", &token)]), 200);
    assert_eq!(
        status("/api/state", &[("Host", "localhost:8000"), ("x-hitl-token", &token)]),
        200,
        "a tunnel"
    );
    let head = served.ask("GET", &page, &[("Host", &host)], b"").head.to_lowercase();
    for said in [
        "content-security-policy: default-src 'none'",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
    ] {
        assert!(head.contains(said), "{said} is not in {head}");
    }
    assert_eq!(served.interrupt(), Some(0), "Ctrl-C ends it cleanly");
}

#[test]
fn two_servers_have_different_tokens_and_only_one_may_write_a_session() {
    let (scratch, _) = room_folder("two");
    let first = Served::start(&scratch.path(""), &["map.npz"]);
    let second = hitl_in(&scratch.path(""), "serve --no-open map.npz");
    assert_eq!(second.code, Some(2));
    assert!(
        second.stderr.contains("session.jsonl: found that another hitl has it open"),
        "{}",
        second.stderr
    );
    let other = Served::start(&scratch.path(""), &["map.npz", "--session", "other.jsonl"]);
    assert!(first.token.len() == 32 && first.token != other.token);
}

#[test]
fn wrong_usage_is_said_before_anything_is_served() {
    let (scratch, _) = room_folder("usage");
    scratch.file("bad.npz", b"PK nothing of the kind");
    for (arguments, said) in [
        ("serve --no-open nowhere.npz", "nowhere.npz: found no such file"),
        ("serve --no-open bad.npz", "bad.npz: found a damaged or cut-off archive"),
        ("serve --no-open map.npz --session /proc/none/s.jsonl", "s.jsonl: found that it cannot be written"),
        ("serve --no-open --session s.jsonl", "<INPUT>: found nothing"),
        ("replay nowhere.jsonl -o x.npz", "nowhere.jsonl: found no such file"),
        ("replay map.npz -o x.npz", "map.npz"),
        ("replay map.npz -o x.unknown", "x.unknown: found no known extension"),
    ] {
        let run = hitl_in(&scratch.path(""), arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(said) && run.stderr.lines().count() == 1, "{arguments}: {}", run.stderr);
    }
}

#[test]
fn malformed_requests_get_a_line_that_says_what_was_expected() {
    let (scratch, _) = room_folder("malformed");
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    let revision = served.state()["revision"].as_u64().unwrap();
    let before = std::fs::read(scratch.path("session.jsonl")).unwrap();
    for (path, body) in [
        ("/api/act", "".to_owned()),
        ("/api/act", "[]".into()),
        ("/api/act", "{".into()),
        ("/api/act", "{\"event\": 5}".into()),
        ("/api/act", format!("{}{}", "[".repeat(30_000), "]".repeat(30_000))),
        ("/api/act", json!({"event": "dance", "revision": revision}).to_string()),
        ("/api/act", json!({"event": "correct", "revision": revision}).to_string()),
        (
            "/api/act",
            json!({"event": "reweight", "id": "c1", "weight": -1, "revision": revision}).to_string(),
        ),
        ("/api/act", json!({"event": "undo"}).to_string()),
        (
            "/api/act",
            json!({"event": "straighten", "stroke": [[0, 0], [0, 0]], "revision": revision}).to_string(),
        ),
        ("/api/catch", json!({"stroke": [[0, 0], [1e300, 0]], "revision": "x"}).to_string()),
        ("/api/catch", json!({"stroke": [[0, 0], ["a", 0]], "revision": revision}).to_string()),
        ("/api/preview", json!({"mode": "knitted", "a": 1, "b": 2, "revision": revision}).to_string()),
        (
            "/api/preview",
            json!({"mode": "parallel", "a": [[0, 0], [1, 0]], "revision": revision}).to_string(),
        ),
        ("/api/cancel", "{}".into()),
    ] {
        let reply = served.post(path, &body);
        assert_eq!(reply.status, 400, "{path} {}", &body[..body.len().min(80)]);
        assert!(reply.json()["error"].as_str().is_some_and(|e| !e.contains('\n')));
    }
    let old = json!({"event": "undo", "revision": revision + 999}).to_string();
    assert_eq!(served.post("/api/act", old).status, 409, "a map that is no longer on screen");
    let nothing = json!({"event": "undo", "revision": revision}).to_string();
    assert_eq!(served.post("/api/act", nothing).status, 422, "nothing to undo");
    assert_eq!(served.post("/api/act", vec![b' '; 1 << 17]).status, 413);
    assert_eq!(served.get("/api/export?format=../../etc/passwd").status, 400);
    assert_eq!(served.get("/../../etc/passwd").status, 404);
    for garbage in [
        &b"\0\0\0\0\r\n\r\n"[..],
        b"GET / HTTP/9.9\r\n\r\n",
        b"POST /api/act HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n",
    ] {
        if let Ok(reply) = served.raw(garbage) {
            assert!((400..600).contains(&reply.status), "{}", reply.head);
        }
    }
    assert_eq!(served.get("/api/state").status, 200);
    assert!(std::fs::read(scratch.path("session.jsonl")).unwrap() == before);
}

#[test]
fn a_dropped_file_cannot_leave_its_folder_and_a_bad_one_leaves_no_trace() {
    let (scratch, path) = room_folder("drop");
    let good = std::fs::read(path).unwrap();
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    let shown = served.state()["map"]["number"].clone();
    for name in [
        "../escape.npz",
        "..%2Fescape.npz",
        "a/b.npz",
        "%2Fetc%2Fescape",
        ".hidden",
        "",
        "..",
        "a%00b.npz",
        "%zz",
        "c:\\x.npz",
        "%ff.npz",
    ] {
        let reply = served.upload(name, &good);
        assert_eq!(reply.status, 400, "{name}");
    }
    let reply = served.upload("broken.log", b"this is no map at all\n");
    assert_eq!(reply.status, 422);
    let told = reply.json()["error"].as_str().unwrap().to_owned();
    assert!(told.starts_with("broken.log"), "{told}");
    assert!(!scratch.path("hitl-maps").exists() && !scratch.path("../escape.npz").exists());
    assert_eq!(served.state()["map"]["number"], shown, "what was open stays open");
    assert_eq!(served.upload("r%C3%B6om.npz", &good).status, 200);
    assert!(scratch.path("hitl-maps/röom.npz").exists() && scratch.path("hitl-maps/session.jsonl").exists());
    assert_ne!(served.state()["map"]["number"], shown);
    assert_eq!(served.commit(0, "collinear").status, 200);
    // The same file again is the same map, with its session; another one of that name is not.
    assert_eq!(served.upload("r%C3%B6om.npz", &good).status, 200);
    assert_eq!(served.state()["corrections"].as_array().unwrap().len(), 1);
    let mut other = hitl_slam::io::native::read(&scratch.path("map.npz")).unwrap().value;
    other.poses[3].x_m += 0.5;
    hitl_slam::io::native::write(&scratch.path("other.npz"), &other).unwrap();
    let other = std::fs::read(scratch.path("other.npz")).unwrap();
    assert_eq!(served.upload("r%C3%B6om.npz", &other).status, 200);
    assert!(scratch.path("hitl-maps/röom-2.npz").exists());
    assert!(scratch.path("hitl-maps/röom-2.npz.session.jsonl").exists());
}

#[test]
fn a_thousand_requests_at_once_are_all_answered_within_bounded_memory() {
    let (scratch, _) = room_folder("thousand");
    let served = Served::start(&scratch.path(""), &["map.npz"]);
    assert_eq!(served.commit(0, "collinear").status, 200);
    let revision = served.state()["revision"].clone();
    let look = json!({"stroke": [[-1.0, -4.0], [1.0, -4.0]], "revision": revision}).to_string();
    served.get("/api/points");
    let before = served.resident_mb();
    let ask = |k: usize| match k % 5 {
        0 => served.get("/api/state").status,
        1 => served.post("/api/catch", &look).status,
        2 => served.get("/api/poses").status,
        3 => served.act(json!({"event": "reweight", "id": "c1", "weight": 1 + k})).status,
        _ => served.get("/api/points").status,
    };
    let answers: Vec<u16> = thread::scope(|scope| {
        let ask = &ask;
        let all: Vec<_> = (0..1000).map(|k| scope.spawn(move || ask(k))).collect();
        all.into_iter().map(|one| one.join().unwrap()).collect()
    });
    let refused = answers.iter().filter(|&&s| s == 409).count();
    assert!(answers.iter().all(|s| [200, 409].contains(s)), "{answers:?}");
    // What names a map that is no longer on screen is refused: strokes and changes, two in five.
    assert!(refused <= 400, "{refused} refused");
    let more = served.resident_mb() - before;
    assert!(more < 300.0, "{more} MB more");
    assert_eq!(served.state()["corrections"].as_array().unwrap().len(), 1);
}
