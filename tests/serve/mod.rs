//! `hitl serve` as a browser meets it, and as an attacker does.

mod guard;
mod long_work;
mod survival;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use crate::support::{Scratch, room};

/// A running server, killed at the end.
pub struct Served {
    child: Child,
    pub port: u16,
    pub token: String,
}

/// What came back.
pub struct Reply {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Reply {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.body)))
    }

    /// The head of a packed answer.
    pub fn packed(&self) -> Value {
        let n = u32::from_le_bytes(self.body[..4].try_into().unwrap()) as usize;
        serde_json::from_slice(&self.body[4..4 + n]).unwrap()
    }
}

impl Served {
    /// Starts `hitl serve ARGUMENTS` in a folder and waits until it says where it is.
    pub fn start(folder: &Path, arguments: &[&str]) -> Served {
        let mut child = Command::new(env!("CARGO_BIN_EXE_hitl"))
            .current_dir(folder)
            .args([&["serve", "--no-open"], arguments].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://127.0.0.1:").unwrap_or_else(|| panic!("{line:?}"));
        let (port, token) = address.split_once("/?token=").unwrap();
        Served { child, port: port.parse().unwrap(), token: token.into() }
    }

    /// SIGKILL: nothing is said good-bye to.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Ctrl-C; the exit code.
    pub fn interrupt(mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        self.child.wait().unwrap().code()
    }

    pub fn resident_mb(&self) -> f64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find(|l| l.starts_with("VmRSS:")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1e3
    }

    /// Sends a request as it stands and reads all that comes back.
    pub fn raw(&self, request: &[u8]) -> std::io::Result<Reply> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        stream.set_read_timeout(Some(Duration::from_secs(60)))?;
        // A server that has refused may close before it has read everything.
        let _ = stream.write_all(request);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").ok_or(std::io::ErrorKind::UnexpectedEof)?;
        let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
        Ok(Reply { status, head, body: bytes[end + 4..].to_vec() })
    }

    /// A request with these headers beside the usual ones.
    pub fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Reply {
        let mut request = format!("{method} {path} HTTP/1.0\r\nContent-Length: {}\r\n", body.len());
        for (name, value) in headers {
            request += &format!("{name}: {value}\r\n");
        }
        request += "\r\n";
        self.raw(&[request.as_bytes(), body].concat()).unwrap()
    }

    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    pub fn get(&self, path: &str) -> Reply {
        self.ask("GET", path, &[("Host", &self.host()), ("x-hitl-token", &self.token)], b"")
    }

    pub fn post(&self, path: &str, body: impl AsRef<[u8]>) -> Reply {
        self.ask("POST", path, &[("Host", &self.host()), ("x-hitl-token", &self.token)], body.as_ref())
    }

    pub fn upload(&self, name: &str, body: &[u8]) -> Reply {
        let headers =
            [("Host", self.host()), ("x-hitl-token", self.token.clone()), ("x-hitl-name", name.to_owned())];
        self.ask("POST", "/api/open", &headers.each_ref().map(|(a, b)| (*a, b.as_str())), body)
    }

    pub fn state(&self) -> Value {
        self.get("/api/state").json()
    }

    /// Lets an event happen on the map that is on screen.
    pub fn act(&self, mut event: Value) -> Reply {
        event["revision"] = self.state()["revision"].clone();
        self.post("/api/act", event.to_string())
    }

    /// Commits wall `k` of the room, as seen in both rounds.
    pub fn commit(&self, k: usize, mode: &str) -> Reply {
        let map = room::corrections([hitl_slam::map::Mode::Parallel; 4]);
        let poses = self.get("/api/poses");
        let at = 4 + u32::from_le_bytes(poses.body[..4].try_into().unwrap()) as usize;
        let number =
            |k: usize| f64::from_le_bytes(poses.body[at + 8 * k..at + 8 * k + 8].try_into().unwrap());
        let world = |stroke: &hitl_slam::map::Stroke| {
            let hitl_slam::map::Stroke::Pose { pose, points } = stroke else { unreachable!() };
            let p =
                hitl_slam::geometry::Pose2::new(number(3 * pose), number(3 * pose + 1), number(3 * pose + 2));
            points.map(|q| <[f64; 2]>::from(p.transform_point(q)))
        };
        let body = json!({"mode": mode, "a": world(&map[k].a), "b": world(&map[k].b), "revision": poses.packed()["revision"]});
        self.post("/api/commit", body.to_string())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A folder with the room's map in it.
pub fn room_folder(test: &str) -> (Scratch, PathBuf) {
    let scratch = Scratch::new(&format!("serve-{test}"));
    let path = scratch.path("map.npz");
    hitl_slam::io::native::write(&path, &room::map(3)).unwrap();
    (scratch, path)
}
