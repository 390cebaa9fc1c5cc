//! Who may ask for what.
//!
//! A request must name this server as its host, so that no other name that leads to this computer serves; come from no
//! page of another origin; and know the token. Then it may ask for one of eight addresses.

use super::answer::Answer;
use super::curves::Point;
use super::desk::{Ask, Asked, Desk, Phase, Pull, Refusal, Status};
use super::request::Request;
use relcp::scene::{Body, parse_json};
use relcp::view::Live;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

/// Random bytes of a token: it cannot be guessed.
const TOKEN_BYTES: usize = 16;
/// The longest time for which a page waits for news; then it asks again.
const POLL: Duration = Duration::from_secs(20);
/// Slower is not a speed.
const SLOWEST: f64 = 1e-3;
const FASTEST: f64 = 1e9;

/// What a request must know.
pub(super) struct Door {
    port: u16,
    token: String,
}

/// The news that a page gets with a state.
#[derive(Serialize)]
struct News<'a> {
    status: &'a Status,
    /// Points of the curves after those that the page has.
    points: &'a [Point],
    /// Whether a state follows.
    state: bool,
}

/// What a page may ask of the run, as it writes it.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Control {
    Play {},
    Pause {},
    Step {
        #[serde(default = "one")]
        steps: u64,
    },
    Speed {
        steps_a_second: Option<f64>,
    },
    End {},
}

/// Bodies that leave and come.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Bodies {
    #[serde(default)]
    remove: Vec<u64>,
    #[serde(default)]
    add: Vec<Body>,
}

/// A body that is dragged; without a target it is let go.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Hand {
    body: u64,
    #[serde(default)]
    point: [f64; 3],
    target: Option<[f64; 3]>,
}

fn one() -> u64 {
    1
}

impl Door {
    pub fn new(port: u16) -> Result<Self, String> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(|why| format!("the system gives no random numbers: {why}"))?;
        Ok(Door { port, token: bytes.iter().map(|byte| format!("{byte:02x}")).collect() })
    }

    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// The part of the path after the token, or why there is none.
    fn admit<'a>(&self, request: &'a Request) -> Result<&'a str, Answer> {
        let hosts = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port));
        let Some(host) = request.host.as_ref().filter(|host| hosts.contains(host)) else {
            return Err(Answer::refuse(403, "the request names another host than this program"));
        };
        if request.origin.as_ref().is_some_and(|origin| *origin != format!("http://{host}")) {
            return Err(Answer::refuse(403, "the request comes from a page of another origin"));
        }
        let (token, rest) = request.path.strip_prefix('/').and_then(|path| path.split_once('/')).unwrap_or_default();
        match same(token.as_bytes(), self.token.as_bytes()) {
            true => Ok(rest),
            false => Err(Answer::refuse(403, "the address lacks the token of the run; the program has printed it all")),
        }
    }
}

/// Whether two texts are the same, in a time that tells nothing of where they differ.
fn same(one: &[u8], other: &[u8]) -> bool {
    one.len() == other.len() && one.iter().zip(other).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

/// The answer to a request, and whether it tells a page that the run has ended.
pub(super) fn answer(request: &Request, desk: &Desk, door: &Door) -> (Answer, bool) {
    let place = match door.admit(request) {
        Ok(place) => place,
        Err(refused) => return (refused, false),
    };
    let answer = match (place, request.method.as_str()) {
        ("next", "GET") => return next(request, desk),
        ("", "GET") => Live::page().map_or_else(|why| Answer::refuse(503, &why.to_string()), Answer::html),
        ("status", "GET") => Answer::json(200, &desk.told().status),
        ("keys", "GET") => {
            let keys = desk.told().keys.clone();
            Answer::json_text(&keys)
        }
        ("control", "POST") => ask(request, desk, control),
        ("change", "POST") => ask(request, desk, change),
        ("bodies", "POST") => ask(request, desk, bodies),
        ("hand", "POST") => ask(request, desk, hand),
        ("" | "next" | "status" | "keys", _) => Answer::only("GET"),
        ("control" | "change" | "bodies" | "hand", _) => Answer::only("POST"),
        _ => Answer::refuse(404, "there is nothing at this address"),
    };
    (answer, false)
}

/// The newest state after the one that the page has, as soon as there is one; or news of the run.
fn next(request: &Request, desk: &Desk) -> (Answer, bool) {
    let number = |name: &str| {
        let pairs = request.query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.filter(|(own, _)| *own == name).find_map(|(_, value)| value.parse::<u64>().ok())
    };
    let (has, knows) = (number("step"), number("version").unwrap_or(0));
    let begun = Instant::now();
    let mut told = desk.told();
    let before = told.newest();
    loop {
        told.watched = Some(Instant::now());
        let frame = told.frame_after(has, before);
        let is_late = begun.elapsed() >= POLL;
        let ended = told.status.phase == Phase::Ended;
        // The news of the end must not outrun the last state.
        let whole = frame.is_some() || has == Some(told.rests_at) || begun.elapsed() >= LAST_STATE;
        if frame.is_some() || is_late || (ended && whole) || (!ended && told.status.version > knows) {
            let status = told.status.clone();
            let points: &[Point] = frame.as_ref().map_or(&[], |frame| &frame.points);
            let points = &points[points.partition_point(|point| has.is_some_and(|step| point.step <= step))..];
            let news = News { status: &status, points, state: frame.is_some() };
            let document = serde_json::to_vec(&news).unwrap_or_default();
            drop(told);
            return (Answer::state(&document, frame), ended);
        }
        desk.call(&told);
        told = desk.wait(told, POLL.saturating_sub(begun.elapsed()).min(LOOK_AGAIN));
    }
}

/// A wait is looked at so often: a state that a run has left may have become old meanwhile.
const LOOK_AGAIN: Duration = Duration::from_millis(500);
/// The longest wait for the last state of a run that has ended.
const LAST_STATE: Duration = Duration::from_secs(2);

/// Puts to the run what the body asks, and waits for its answer, which comes after the step that it takes.
fn ask(request: &Request, desk: &Desk, read: fn(&[u8]) -> Result<Ask, Refusal>) -> Answer {
    let kind = request.content_type.as_deref().unwrap_or_default();
    if kind.split(';').next().map(str::trim) != Some("application/json") {
        return Answer::refuse(415, "the body must be JSON, with the header Content-Type: application/json");
    }
    let what = match read(&request.body) {
        Ok(what) => what,
        Err(refusal) => return Answer::json(400, &refusal),
    };
    let (answer, answered) = sync_channel(1);
    if let Err(refusal) = desk.ask(Asked { what, answer }) {
        return Answer::json(409, &refusal);
    }
    match answered.recv() {
        Ok(Ok(())) => Answer::json(200, &desk.told().status),
        Ok(Err(refusal)) => Answer::json(400, &refusal),
        Err(_) => Answer::refuse(409, "the run has ended"),
    }
}

/// What a body asks; no key of it twice. `help` shows what is understood.
fn understood<T: DeserializeOwned>(body: &[u8], help: &str) -> Result<T, Refusal> {
    let refuse = |why: String| Refusal { error: format!("not understood: {why}"), help: Some(help.into()) };
    let value = parse_json(body).map_err(|why| refuse(why.to_string()))?;
    serde_path_to_error::deserialize(value).map_err(|why| match why.path().to_string() {
        path if path == "." => refuse(why.inner().to_string()),
        path => refuse(format!("{path}: {}", why.inner())),
    })
}

fn control(body: &[u8]) -> Result<Ask, Refusal> {
    let help = r#"{"do": "play"}, "pause", "step", "end", or {"do": "speed", "steps_a_second": 10}"#;
    Ok(match understood(body, help)? {
        Control::Play {} => Ask::Play,
        Control::Pause {} => Ask::Pause,
        Control::Step { steps } if steps > 0 => Ask::Steps(steps),
        Control::Step { .. } => return Err(Refusal::new("steps must be at least 1")),
        Control::Speed { steps_a_second: Some(most) } if !(SLOWEST..=FASTEST).contains(&most) => {
            return Err(Refusal::new("steps_a_second must be from 0.001 to 1e9, or null for as many as come"));
        }
        Control::Speed { steps_a_second } => Ask::Speed(steps_a_second),
        Control::End {} => Ask::End,
    })
}

fn change(body: &[u8]) -> Result<Ask, Refusal> {
    let set: Map<String, Value> = understood(body, r#"an object of dotted keys: {"growth.rate": 0.5}"#)?;
    if set.is_empty() {
        return Err(Refusal::new("no key is given"));
    }
    Ok(Ask::Change(set.into_iter().collect()))
}

fn bodies(body: &[u8]) -> Result<Ask, Refusal> {
    let help = r#"ids and bodies as in a scene: {"remove": [3], "add": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}]}"#;
    let Bodies { remove, add } = understood(body, help)?;
    if remove.is_empty() && add.is_empty() {
        return Err(Refusal::new("no body is given"));
    }
    Ok(Ask::Place { remove, add })
}

fn hand(body: &[u8]) -> Result<Ask, Refusal> {
    let help = r#"{"body": 3, "point": [0, 0, 0.5], "target": [4, 1, 0]}, or {"body": 3} to let it go"#;
    let Hand { body, point, target } = understood(body, help)?;
    Ok(target.map_or(Ask::LetGo(body), |target| Ask::Pull(Pull { body, point, target })))
}
