//! `relcp run --live` over plain connections, without a browser.

use crate::place::{self, Place};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::Duration;

/// Longer than any answer takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);
/// Looks at the status of a run before it counts as hung.
const MOST_LOOKS: usize = 60_000;
/// One cell that grows to eight.
const COLONY: [&str; 8] =
    ["colony", "--set", "time.dt=0.02", "--set", "time.end=2.4", "--set", "growth.reorientation_degrees=20", "--quiet"];

/// A run that waits for its page.
struct Live {
    child: Child,
    port: u16,
    token: String,
    err: BufReader<ChildStderr>,
}

/// An answer: status, headers, body.
struct Answer {
    status: u16,
    headers: BTreeMap<String, String>,
    body: Vec<u8>,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&self.body)))
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Live {
    fn start(place: &Place, arguments: &[&str]) -> Live {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin("relcp"))
            .current_dir(&place.0)
            .args(["run", "--live", "--backend", "cpu", "--out", "run"])
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut err = BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        let address = loop {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "it ended: {said}");
            said.push_str(&line);
            if let Some((_, address)) = line.trim().split_once("http://127.0.0.1:") {
                break address.to_owned();
            }
        };
        let (port, token) = address.split_once('/').unwrap();
        Live { child, port: port.parse().unwrap(), token: token.trim_end_matches('/').into(), err }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends these lines of a head, and a body.
    fn send(&self, lines: &[&str], body: &[u8]) -> Answer {
        let mut stream = self.connect();
        stream.write_all(format!("{}\r\n\r\n", lines.join("\r\n")).as_bytes()).unwrap();
        // The answer may come before the body has gone.
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let mut lines = head.lines();
        let status = lines.next().unwrap().split(' ').nth(1).unwrap().parse().unwrap();
        let headers = lines.map(|line| line.split_once(": ").unwrap());
        let headers: BTreeMap<_, _> = headers.map(|(name, value)| (name.to_lowercase(), value.to_owned())).collect();
        let body = bytes[end + 4..].to_vec();
        assert_eq!(headers["content-length"], body.len().to_string());
        Answer { status, headers, body }
    }

    fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}", self.port)
    }

    fn get(&self, place: &str) -> Answer {
        self.send(&[&format!("GET /{}/{place} HTTP/1.1", self.token), &self.host()], b"")
    }

    fn post(&self, place: &str, body: &Value) -> Answer {
        self.post_text(place, &body.to_string())
    }

    fn post_text(&self, place: &str, body: &str) -> Answer {
        let (length, kind) = (format!("Content-Length: {}", body.len()), "Content-Type: application/json");
        let line = format!("POST /{}/{place} HTTP/1.1", self.token);
        self.send(&[&line, &self.host(), &length, kind], body.as_bytes())
    }

    #[track_caller]
    fn control(&self, what: &Value) -> Value {
        let answer = self.post("control", what);
        assert_eq!(answer.status, 200, "{what}: {}", answer.json());
        answer.json()
    }

    fn steps(&self, count: u64) {
        self.control(&json!({"do": "step", "steps": count}));
        self.wait_for("paused");
    }

    fn wait_for(&self, phase: &str) {
        let looks = (0..MOST_LOOKS).any(|_| {
            std::thread::sleep(Duration::from_millis(2));
            self.get("status").json()["phase"] == phase
        });
        assert!(looks, "it is never {phase}");
    }

    /// The newest state after a step: the news, its description, and its columns by name.
    fn next(&self, step: Option<u64>) -> (Value, Value, BTreeMap<String, Vec<u32>>) {
        let has = step.map_or(String::new(), |step| format!("&step={step}"));
        let mut version = 0;
        loop {
            let answer = self.get(&format!("next?version={version}{has}"));
            assert_eq!(answer.status, 200);
            let (news, rest) = document(&answer.body);
            if news["state"] == true {
                let (header, rest) = document(rest);
                let (table, rest) = columns(rest, &header["table"]["columns"]);
                let (mut read, rest) = columns(rest, &header["states"][0]["columns"]);
                assert!(rest.is_empty());
                read.extend(table);
                return (news, header, read);
            }
            version = news["status"]["version"].as_u64().unwrap();
        }
    }

    /// Waits for its end: its exit status, and what it wrote.
    fn end(mut self) -> (Option<i32>, String) {
        let mut said = String::new();
        self.err.read_to_string(&mut said).unwrap();
        (self.child.wait().unwrap().code(), said)
    }
}

fn document(bytes: &[u8]) -> (Value, &[u8]) {
    let (length, rest) = bytes.split_first_chunk::<4>().unwrap();
    let (text, rest) = rest.split_at(u32::from_le_bytes(*length) as usize);
    (serde_json::from_slice(text).unwrap(), rest)
}

/// Columns of whole numbers, each as its lowest bytes, then the next: the inverse of `src/view/columns.rs`.
fn columns<'a>(mut bytes: &'a [u8], layout: &Value) -> (BTreeMap<String, Vec<u32>>, &'a [u8]) {
    let mut found = BTreeMap::new();
    for column in layout.as_array().unwrap() {
        let [count, planes] = [1, 2].map(|k| column[k].as_u64().unwrap() as usize);
        let mut values = vec![0_u32; count];
        for plane in 0..planes {
            let (part, rest) = bytes.split_at(count);
            values.iter_mut().zip(part).for_each(|(value, byte)| *value |= u32::from(*byte) << (8 * plane));
            bytes = rest;
        }
        found.insert(column[0].as_str().unwrap().to_owned(), values);
    }
    (found, bytes)
}

fn hash(place: &Place, folder: &str) -> String {
    let summary = place.json(&format!("{folder}/summary.json"));
    assert_eq!(summary["status"], "done", "{summary}");
    summary["state_hash"].as_str().unwrap().to_owned()
}

/// Runs the scene of a folder from its start, into another one.
fn again(place: &Place, folder: &str, other: &str) -> String {
    let scene = format!("{folder}/scene.json");
    place.relcp(&["run", &scene, "--backend", "cpu", "--quiet", "--out", other]).expect(0);
    hash(place, other)
}

#[test]
fn only_who_knows_the_token_and_comes_from_this_computer_is_answered() {
    let place = Place::new();
    let live = Live::start(&place, &["rods.json", "--quiet"]);
    assert_eq!((live.token.len(), live.get("").status), (32, 200));
    let page = live.get("");
    let text = String::from_utf8(page.body.clone()).unwrap();
    assert!(text.contains("startLive();") && text.contains("connect-src 'self'") && !text.contains("/*SCRIPT*/"));
    assert!(page.headers["content-security-policy"].contains("frame-ancestors 'none'"));
    assert_eq!(page.headers["referrer-policy"], "no-referrer");
    assert!(!page.headers.contains_key("access-control-allow-origin"));

    let (host, port) = (live.host(), live.port);
    let status = |line: &str, headers: &[&str]| live.send(&[&[line], headers].concat(), b"").status;
    let line = |method: &str, place: &str| format!("{method} /{}/{place} HTTP/1.1", live.token);
    let mut wrong = live.token.clone().into_bytes();
    wrong[31] = if wrong[31] == b'0' { b'1' } else { b'0' };
    let wrong = String::from_utf8(wrong).unwrap();
    for place in ["/", "/status", "//status", &format!("/{wrong}/status"), &format!("/{}", live.token), "/../status"] {
        assert_eq!(status(&format!("GET {place} HTTP/1.1"), &[&host]), 403, "{place}");
    }
    let here = line("GET", "status");
    assert_eq!(status(&here, &[&format!("Host: localhost:{port}")]), 200);
    for host in ["Host: example.org", "Host: 127.0.0.1", "Host: 127.0.0.1:1", "Host: 127.0.0.1.example.org:80", "X: 1"]
    {
        assert_eq!(status(&here, &[host]), 403, "{host}");
    }
    assert_eq!(status(&here, &[&host, &host]), 400);
    assert_eq!(status(&here, &[&host, &format!("Origin: http://127.0.0.1:{port}")]), 200);
    for origin in ["http://example.org", "null", "http://127.0.0.1", &format!("https://127.0.0.1:{port}"), ""] {
        assert_eq!(status(&here, &[&host, &format!("Origin: {origin}")]), 403, "{origin}");
    }
    assert_eq!(status(&line("GET", "scene.json"), &[&host]), 404);
    assert_eq!(status(&line("GET", "../../Cargo.toml"), &[&host]), 404);
    for method in ["PUT", "DELETE", "HEAD", "OPTIONS", "TRACE"] {
        let refused = live.send(&[&line(method, "status"), &host], b"");
        assert_eq!((refused.status, refused.headers["allow"].as_str()), (405, "GET"), "{method}");
        assert_eq!(status(&line(method, "control"), &[&host]), 405, "{method}");
    }
    let play = b"{\"do\": \"play\"}";
    let length = format!("Content-Length: {}", play.len());
    let control = line("POST", "control");
    for kind in ["Content-Type: text/plain", "Content-Type: application/x-www-form-urlencoded", "X: 1"] {
        assert_eq!(live.send(&[&control, &host, &length, kind], play).status, 415, "{kind}");
    }
    let kind = "Content-Type: application/json";
    assert_eq!(live.send(&[&control, &host, kind], b"").status, 411);
    let much = vec![b' '; 100_000];
    assert_eq!(live.send(&[&control, &host, kind, "Content-Length: 100000"], &much).status, 413);
    assert_eq!(live.send(&[&here, &host, &format!("X: {}", "x".repeat(40_000))], b"").status, 431);
    assert_eq!(live.get("status").json()["phase"], "paused");
    live.control(&json!({"do": "end"}));
    assert_eq!(live.end().0, Some(0));
}

#[test]
fn half_requests_and_many_connections_stop_neither_the_run_nor_its_page() {
    let place = Place::new();
    let live = Live::start(&place, &COLONY);
    let mut held: Vec<TcpStream> = (0..200).map(|_| live.connect()).collect();
    for (k, stream) in held.iter_mut().enumerate() {
        let half =
            ["", "G", "GET / HT", "POST /x HTTP/1.1\r\nContent-Length: 60000\r\n\r\n{", "\u{0}\u{1}\r\n\r\n"][k % 5];
        stream.write_all(half.as_bytes()).unwrap();
    }
    assert_eq!(live.get("status").status, 200);
    live.steps(3);
    live.control(&json!({"do": "speed", "steps_a_second": 100}));
    live.control(&json!({"do": "play"}));
    // A page that is opened while the run plays has states at once, and then later ones.
    let first = live.next(None).1["states"][0]["step"].as_u64();
    let second = live.next(first).1["states"][0]["step"].as_u64();
    assert!(first >= Some(3) && second > first, "{first:?} {second:?}");
    assert!(live.next(None).1["states"][0]["step"].as_u64() > second);
    live.control(&json!({"do": "speed", "steps_a_second": null}));
    // Who waits for a state and goes.
    for _ in 0..20 {
        let mut stream = live.connect();
        write!(stream, "GET /{}/next?version=99999&step=99999 HTTP/1.1\r\n{}\r\n\r\n", live.token, live.host())
            .unwrap();
    }
    // A half request that waits is told so, one that says nothing is not.
    let mut waits = live.connect();
    waits.write_all(b"GET / HTTP").unwrap();
    let mut said = Vec::new();
    waits.read_to_end(&mut said).unwrap();
    assert!(said.starts_with(b"HTTP/1.1 408") || said.is_empty(), "{}", String::from_utf8_lossy(&said));
    assert_eq!(live.end().0, Some(0));
    drop(held);
    assert_eq!(hash(&place, "run"), again(&place, "run", "again"));
}

#[test]
fn a_run_that_was_steered_is_repeated_to_the_same_bits() {
    let place = Place::new();
    let live = Live::start(&place, &COLONY);
    assert_eq!(live.get("status").json()["phase"], "paused");
    let (news, header, read) = live.next(None);
    assert_eq!((&header["states"][0]["step"], &header["states"][0]["bodies"]), (&json!(0), &json!(1)));
    assert_eq!((read["x"].len(), &news["points"]), (1, &json!([])));
    live.steps(1);
    let (news, header, _) = live.next(Some(0));
    assert_eq!((&header["states"][0]["step"], news["points"].as_array().unwrap().len()), (&json!(1), 1));
    live.steps(49);

    // Bad values are answered by the scene's reader, and change nothing.
    let scene = fs::read(place.at("run/scene.json")).unwrap();
    let keys = live.get("keys").json();
    for (set, says) in [
        (json!({"growth.rate": -1}), "growth.rate"),
        (json!({"growth.rate": "fast"}), "growth.rate"),
        (json!({"growth.rat": 1}), "the nearest is `rate`"),
        (json!({"time.end": 5}), "cannot change during a run"),
        (json!({"planar": false}), "cannot change during a run"),
        (json!({"growth.rate": 1, "bodies.0.position": [0, 0, 1]}), "cannot change during a run"),
        (json!({"": 1}), "dotted key"),
        (json!({}), "no key"),
        (json!([1]), "not understood"),
    ] {
        let refused = live.post("change", &set);
        let said = format!("{} {}", refused.json()["error"], refused.json()["help"]);
        assert!(refused.status == 400 && said.contains(says), "{set}: {said}");
    }
    for what in [json!({"do": "jump"}), json!({"do": "step", "steps": 0}), json!({"do": "speed", "steps_a_second": 0})]
    {
        assert_eq!(live.post("control", &what).status, 400, "{what}");
    }
    for (to, body, says) in [
        ("change", r#"{"growth.rate": 1, "growth.rate": 2}"#, "growth.rate"),
        ("change", r#"{"walls": [], "time": {"dt": 1, "dt": 2}}"#, "dt"),
        ("control", r#"{"do": "play", "do": "pause"}"#, "do"),
        ("control", r#"{"do": "step", "steps": 1, "steps": 2}"#, "steps"),
        ("bodies", r#"{"remove": [0], "remove": [0]}"#, "remove"),
        ("bodies", r#"{}"#, "no body"),
        ("bodies", r#"{"remove": [-1]}"#, "remove[0]"),
        ("bodies", r#"{"remove": [77]}"#, "id 77: no body has it now"),
        ("bodies", r#"{"add": [{"shape": {"sphere": {"radius": 1}}}]}"#, "position"),
        ("bodies", r#"{"add": [{"shape": {"sphere": {"radius": -1}}, "position": [9, 0, 0]}]}"#, "changes.0.add.0"),
        ("hand", r#"{"body": 77, "target": [0, 0, 0]}"#, "no body has the id 77"),
        ("hand", r#"{"body": 0, "target": [0, 1e999, 0]}"#, "not understood"),
        ("hand", r#"{"body": 0, "target": [0, 0]}"#, "target"),
    ] {
        let refused = live.post_text(to, body);
        let said = format!("{} {}", refused.json()["error"], refused.json()["help"]);
        assert!(refused.status == 400 && said.contains(says), "{to} {body}: {said}");
    }
    assert_eq!((fs::read(place.at("run/scene.json")).unwrap(), live.get("keys").json()), (scene, keys));

    let changed = live.post("change", &json!({"growth.rate": 1.7, "time.dt": 0.01}));
    assert_eq!((changed.status, &changed.json()["changes"]), (200, &json!(1)));
    assert!(live.get("keys").json().as_array().unwrap().contains(&json!(["growth.rate", 1.7])));
    live.steps(10);
    // Two changes at one state act in their order.
    for rate in [2.5, 0.8] {
        assert_eq!(live.post("change", &json!({"growth.rate": rate})).status, 200);
    }
    live.control(&json!({"do": "speed", "steps_a_second": 1e6}));
    live.control(&json!({"do": "play"}));
    assert_eq!(live.end().0, Some(0));
    let changes = place.json("run/scene.json")["changes"].clone();
    let times: Vec<f64> = changes.as_array().unwrap().iter().map(|change| change["at"].as_f64().unwrap()).collect();
    assert!((times[0] - 1.0).abs() < 1e-12 && (times[1] - 1.1).abs() < 1e-12 && times[1] == times[2], "{changes}");
    assert_eq!(hash(&place, "run"), again(&place, "run", "again"));
    assert_eq!(crate::rows(&place.at("run")), crate::rows(&place.at("again")));
    place.relcp(&[&["run"], &COLONY[..], &["--out", "plain", "--backend", "cpu"]].concat()).expect(0);
    assert_ne!(hash(&place, "run"), hash(&place, "plain"));
}

#[test]
fn bodies_that_are_dragged_placed_and_removed_are_so_again_to_the_same_bits_also_after_a_kill() {
    let place = Place::new();
    for kill in [false, true] {
        let _ = fs::remove_dir_all(place.at("run"));
        let mut live = Live::start(&place, &COLONY);
        // Between two divisions.
        live.steps(40);
        let (_, header, read) = live.next(None);
        let bodies = header["states"][0]["bodies"].as_u64().unwrap();
        let id = read["id"][0];
        let ok = |to: &str, body: Value| {
            let answer = live.post(to, &body);
            assert_eq!(answer.status, 200, "{to} {body}: {}", answer.json());
            answer.json()["changes"].as_u64().unwrap()
        };
        assert_eq!(ok("hand", json!({"body": id, "point": [0, 0, 1], "target": [3, 2, 0]})), 1);
        // Nothing new.
        assert_eq!(ok("hand", json!({"body": id, "point": [0, 0, 1], "target": [3, 2, 0]})), 1);
        live.steps(5);
        assert_eq!(ok("hand", json!({"body": id, "point": [0, 0, 1], "target": [4, 2, 0]})), 2);
        live.steps(5);
        let rod = json!({"shape": {"spherocylinder": {"diameter": 1, "length": 2}}, "position": [8, 0, 3], "axis": [1, 0, 0]});
        assert_eq!(ok("bodies", json!({"add": [rod]})), 3);
        // The page sees it at once, in the state of the same step; its z is that of the plane.
        let (_, header, read) = live.next(None);
        let state = &header["states"][0];
        assert_eq!((&state["step"], &state["bodies"]), (&json!(50), &json!(bodies + 1)));
        let placed = *read["id"].iter().max().unwrap();
        live.steps(3);
        assert_eq!(ok("hand", json!({"body": id})), 4);
        assert_eq!(ok("hand", json!({"body": id})), 4);
        live.steps(1);
        assert_eq!(ok("bodies", json!({"remove": [placed]})), 5);
        let (_, header, _) = live.next(None);
        assert_eq!(header["states"][0]["bodies"], json!(bodies));
        assert_eq!(ok("hand", json!({"body": id, "target": [-4, 0, 0]})), 6);
        let run = "run";
        if kill {
            live.steps(2);
            live.child.kill().unwrap();
            live.child.wait().unwrap();
            drop(live);
            place.relcp(&["run", "--resume", "--backend", "cpu", "--quiet", "--out", run]).expect(0);
        } else {
            live.steps(2);
            live.control(&json!({"do": "end"}));
            assert_eq!(live.end().0, Some(0));
            // Who ends the run lets go.
            let forces = place.json("run/final.json")["forces"].clone();
            assert!(
                !forces.to_string().contains("pull")
                    || place.json("run/scene.json")["changes"].as_array().unwrap().len() == 7
            );
        }
        let other = format!("again-{kill}");
        assert_eq!(hash(&place, run), again(&place, run, &other));
        assert_eq!(crate::rows(&place.at(run)), crate::rows(&place.at(&other)));
    }
}

#[test]
fn a_hand_that_falls_silent_lets_go() {
    let place = Place::new();
    let live = Live::start(&place, &COLONY);
    live.steps(2);
    assert_eq!(live.post("hand", &json!({"body": 0, "target": [1, 0, 0]})).json()["changes"], 1);
    let gone = (0..MOST_LOOKS).any(|_| {
        std::thread::sleep(Duration::from_millis(20));
        live.get("status").json()["changes"] == 2
    });
    assert!(gone);
    live.control(&json!({"do": "end"}));
    assert_eq!(live.end().0, Some(0));
    assert_eq!(place.json("run/scene.json")["changes"][1]["set"], json!({"forces": []}));
}

#[test]
fn connections_that_say_nothing_do_not_lock_a_page_out() {
    let place = Place::new();
    let live = Live::start(&place, &COLONY);
    let held: Vec<TcpStream> = (0..400).map(|_| live.connect()).collect();
    for _ in 0..20 {
        assert_eq!(live.get("status").status, 200);
    }
    live.steps(1);
    // The oldest were closed for the newest.
    let closed = |mut stream: &TcpStream| {
        stream.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
        matches!(stream.read(&mut [0]), Ok(0))
    };
    assert!(held[..200].iter().all(closed));
    live.control(&json!({"do": "end"}));
    assert_eq!(live.end().0, Some(0));
}

#[test]
fn a_file_that_cannot_be_written_is_told_to_the_page_and_to_the_caller() {
    let place = Place::new();
    let live = Live::start(&place, &[&COLONY[..], &["--set", "output.every=0.2"]].concat());
    live.steps(5);
    // As on a full disk, no state can be written from here on.
    fs::remove_dir_all(place.at("run/states")).unwrap();
    fs::write(place.at("run/states"), "").unwrap();
    // A page watches.
    let mut told = live.next(None).0["status"].clone();
    live.control(&json!({"do": "play"}));
    while told["phase"] != "ended" {
        let answer = live.get(&format!("next?version={}&step=5", told["version"]));
        told = document(&answer.body).0["status"].clone();
    }
    let message = told["message"].as_str().unwrap();
    assert!(message.starts_with("stopped: ") && message.contains("states"), "{message}");
    let (status, said) = live.end();
    assert!(status == Some(4) && said.contains("states"), "{status:?} {said}");
}

#[test]
fn a_steered_run_that_is_killed_goes_on_to_the_same_bits() {
    let place = Place::new();
    for (name, after) in [("later", 30), ("at-once", 0), ("between", 0)] {
        let _ = fs::remove_dir_all(place.at("run"));
        let mut live = Live::start(&place, &COLONY);
        live.steps(40);
        assert_eq!(live.post("change", &json!({"growth.rate": 1.5})).status, 200);
        live.steps(5);
        let checkpoint = fs::read(place.at("run/checkpoint.npz")).unwrap();
        assert_eq!(live.post("change", &json!({"growth.rate": 0.5})).status, 200);
        if after > 0 {
            live.steps(after);
        }
        live.child.kill().unwrap();
        live.child.wait().unwrap();
        drop(live);
        if name == "between" {
            // Killed when the scene had the change, and the checkpoint not yet.
            fs::write(place.at("run/checkpoint.npz"), checkpoint).unwrap();
            fs::remove_file(place.at("run/checkpoint.previous.npz")).unwrap();
        }
        let expected = again(&place, "run", name);
        place.relcp(&["run", "--resume", "--backend", "cpu", "--quiet", "--out", "run"]).expect(0);
        assert_eq!(hash(&place, "run"), expected, "{name}");
        assert_eq!(crate::rows(&place.at("run")), crate::rows(&place.at(name)), "{name}");
    }
}

#[test]
fn the_end_is_where_its_user_says_and_the_run_goes_on_from_there() {
    let place = Place::new();
    let more = ["--set", "output.step_stride=7", "--set", "output.measures=[\"radius\"]"];
    let live = Live::start(&place, &[&COLONY[..], &more].concat());
    live.steps(60);
    live.control(&json!({"do": "end"}));
    assert_eq!(live.end().0, Some(0));
    let summary = place.json("run/summary.json");
    assert_eq!((&summary["steps"], &summary["completed"]), (&json!(60), &json!(true)));
    assert!(place.at("run/final.json").is_file());
    assert_eq!(hash(&place, "run"), again(&place, "run", "again"));
    let measures = |folder: &str| fs::read(place.at(&format!("{folder}/measures.csv"))).unwrap();
    assert_eq!(crate::rows(&place.at("run")), crate::rows(&place.at("again")));
    assert_eq!(measures("run"), measures("again"));
    place.relcp(&["run", "--resume", "--until", "2.4", "--backend", "cpu", "--quiet", "--out", "run"]).expect(0);
    place.relcp(&[&["run"], &COLONY[..], &more, &["--out", "plain", "--backend", "cpu"]].concat()).expect(0);
    assert_eq!(hash(&place, "run"), hash(&place, "plain"));
}

#[test]
fn a_page_has_the_places_of_the_recorded_state() {
    let place = Place::new();
    let live = Live::start(&place, &COLONY);
    live.steps(110);
    let (_, header, read) = live.next(None);
    live.control(&json!({"do": "end"}));
    assert_eq!(live.end().0, Some(0));
    let scene = place.json("run/final.json");
    let bodies = scene["bodies"].as_array().unwrap();
    assert!(bodies.len() > 2 && read["x"].len() == bodies.len());
    let step = header["length_step"].as_f64().unwrap();
    let signed = |value: u32| f64::from((value >> 1) as i32 ^ -((value & 1) as i32));
    for (k, axis) in ["x", "y"].iter().enumerate() {
        let [middle, origin] = ["middle", "origin"].map(|name| header[name][k].as_f64().unwrap());
        for (i, body) in bodies.iter().enumerate() {
            let at = origin + (signed(read[*axis][i]) - middle) * step;
            let error = at - body["position"][k].as_f64().unwrap();
            assert!(error.abs() <= 0.501 * step, "{axis} of {i}: {error}");
        }
    }
}

#[test]
fn a_fault_is_told_to_the_page_and_to_the_caller() {
    let place = Place::new();
    // A body so light that its velocity is no number.
    let scene = r#"{ "name": "stops", "time": { "dt": 1e50, "end": 5e50 },
        "dynamics": { "inertial": { "density": 1e-60 } }, "contact": { "overlap_tolerance": 1e-50 },
        "forces": [ { "uniform": { "force": [1e50, 0, 0] } } ],
        "bodies": [ { "shape": { "sphere": { "radius": 1e-40 } }, "position": [0, 0, 0] } ] }"#;
    fs::write(place.at("stops.json"), scene).unwrap();
    let live = Live::start(&place, &["stops.json", "--quiet"]);
    let mut told = live.get("status").json();
    live.control(&json!({"do": "play"}));
    while told["phase"] != "ended" {
        let answer = live.get(&format!("next?version={}&step=0", told["version"]));
        told = document(&answer.body).0["status"].clone();
    }
    assert!(told["message"].as_str().is_some_and(|message| message.starts_with("stopped: ")), "{told}");
    let (status, said) = live.end();
    assert!(status == Some(3) && said.contains("stopped: "), "{said}");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_run_that_pauses() {
    let place = Place::new();
    let live = Live::start(&place, &COLONY);
    live.steps(20);
    place::signal(&live.child, "-INT");
    let (status, said) = live.end();
    assert!(status == Some(130) && said.contains("relcp run --resume --out run"), "{said}");
    place.relcp(&["run", "--resume", "--backend", "cpu", "--quiet", "--out", "run"]).expect(0);
    assert_eq!(hash(&place, "run"), again(&place, "run", "again"));
}

#[test]
fn a_port_that_is_taken_is_refused_before_anything_is_written() {
    let place = Place::new();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let refused = place.relcp(&["run", "rods.json", "--live", "--port", &port, "--out", "run"]).expect(2);
    assert!(
        refused.err.contains(&port) && refused.err.contains("--port") && !place.at("run").exists(),
        "{}",
        refused.err
    );
    assert!(place.relcp(&["run", "rods.json", "--port", "8080"]).expect(2).err.contains("--live"));
}
