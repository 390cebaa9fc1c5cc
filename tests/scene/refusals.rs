//! Scenes that are refused, with the place and the message.

use super::{good, isotropic, set};
use relcp::scene::{self, FaultKind, Generate, Scene};
use relcp::shape::Shape;
use serde::Deserialize;
use std::path::Path;

/// One broken scene: edits of a good scene, or a text of its own, and what the refusal must say.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Broken {
    name: String,
    /// The built-in scene that the edits start from.
    #[serde(default)]
    base: String,
    /// Old and new text, each replaced once.
    #[serde(default)]
    edit: Vec<(String, String)>,
    #[serde(default)]
    text: Option<String>,
    kind: String,
    key: String,
    says: String,
    /// What stands at the place.
    #[serde(default)]
    at: Option<String>,
}

impl Broken {
    fn text(&self) -> String {
        let mut text = self.text.clone().unwrap_or_else(|| {
            scene::BuiltIn::ALL
                .iter()
                .find(|b| b.name == self.base)
                .unwrap_or_else(|| panic!("{}: no base", self.name))
                .text
                .to_owned()
        });
        for (old, new) in &self.edit {
            assert!(text.contains(old), "{}: nothing to replace: {old}", self.name);
            text = text.replacen(old, new, 1);
        }
        text
    }
}

#[test]
fn broken_scenes_are_refused_with_kind_key_place_and_message() {
    let tables = [
        include_str!("../broken_scenes/table.json"),
        include_str!("../broken_scenes/motion.json"),
        include_str!("../broken_scenes/superellipsoids.json"),
    ];
    let table: Vec<Broken> = tables.iter().flat_map(|table| serde_json::from_str::<Vec<_>>(table).unwrap()).collect();
    assert!(table.len() >= 60);
    let mut wrong = Vec::new();
    for broken in &table {
        let text = broken.text();
        let Err(error) = Scene::parse(&text, "broken.json") else {
            wrong.push(format!("{}: accepted", broken.name));
            continue;
        };
        let (line, column) = (error.line().unwrap_or(0), error.column().unwrap_or(0));
        let there: String =
            text.lines().nth(line.saturating_sub(1)).unwrap_or("").chars().skip(column.saturating_sub(1)).collect();
        let place = broken.at.as_ref().is_none_or(|at| there.starts_with(at.as_str()));
        let right = format!("{:?}", error.kind()) == broken.kind
            && error.key() == broken.key
            && error.message().contains(&broken.says);
        if !right || line == 0 || column == 0 || !place || error.kind() == FaultKind::Io {
            wrong.push(format!("{}: {:?} {error}\n    there: {there:.40}", broken.name, error.kind()));
        }
    }
    assert!(wrong.is_empty(), "{} of {} wrong:\n{}", wrong.len(), table.len(), wrong.join("\n"));
}

#[test]
fn files_that_cannot_be_read_are_not_bad_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Scene::read(folder.path().join("none.json")).unwrap_err();
    assert_eq!(missing.kind(), FaultKind::Io);
    let directory = Scene::read(folder.path()).unwrap_err();
    assert_eq!(directory.kind(), FaultKind::Io);
    assert!(directory.to_string().contains("directory"));
    let bytes = folder.path().join("bytes.json");
    std::fs::write(&bytes, b"{\n \"name\": \"\xff\"}").unwrap();
    let error = Scene::read(&bytes).unwrap_err();
    assert_eq!((error.kind(), error.line(), error.column()), (FaultKind::Syntax, Some(2), Some(11)));
    let file = folder.path().join("scene.json");
    std::fs::write(&file, format!("\u{feff}{}", good().to_json())).unwrap();
    assert_eq!(Scene::read(&file).unwrap(), good());
    assert_eq!(Scene::read(&file).unwrap(), good());
    let misspelt = Scene::load("colny", scene::NO_OVERRIDES).unwrap_err();
    assert!(misspelt.help_text().unwrap().contains("`colony`"));
}

#[test]
fn scenes_built_in_code_are_validated_too() {
    let mut scene = good();
    scene.bodies[1].position[2] = f64::NAN;
    let error = scene.validate().unwrap_err();
    assert_eq!((error.key(), error.line()), ("bodies.1.position.2", None));
    assert_eq!(error.to_string(), "bodies.1.position.2: must be finite");
    assert_eq!(scene.build().unwrap_err().key(), "bodies.1.position.2");
    let mut scene = good();
    scene.time.dt = f64::INFINITY;
    assert_eq!(scene.validate().unwrap_err().key(), "time.dt");
}

#[test]
fn a_refusal_points_into_the_text() {
    let text = good().to_json().replace("\"dt\": 0.01", "\"dt\": -1.5");
    let error = Scene::parse(&text, "my.json").unwrap_err();
    let mut picture = String::new();
    miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none())
        .render_report(&mut picture, &error)
        .unwrap();
    assert!(picture.contains("\"dt\": -1.5") && picture.contains("my.json") && picture.contains("here"), "{picture}");
}

#[test]
fn absurd_counts_are_refused_at_once() {
    let count = |n: u64| isotropic(n, Shape::Sphere { radius: 1.0 }, 0.01, false).validate().unwrap_err();
    for n in [1_000_000_000, 1_000_000_000_000, u64::MAX] {
        assert_eq!((count(n).kind(), count(n).key()), (FaultKind::TooLarge, "generate.0.isotropic.count"));
    }
    let mut scene = good();
    scene.generate = vec![Generate::Chainmail {
        columns: u64::MAX,
        rows: u64::MAX,
        major_radius: 1.0,
        minor_radius: 0.1,
        group: None,
    }];
    assert_eq!(scene.validate().unwrap_err().kind(), FaultKind::TooLarge);
    let error = Scene::read(Path::new("/nonexistent/x.json")).unwrap_err();
    assert_eq!(error.kind(), FaultKind::Io);
}

#[test]
fn deep_nesting_is_refused_not_followed() {
    for text in ["[".repeat(100_000), "{\"a\":".repeat(100_000), format!("{{\"name\": {}1", "[".repeat(500))] {
        let error = Scene::parse(&text, "deep").unwrap_err();
        assert_eq!((error.kind(), error.line()), (FaultKind::Syntax, Some(1)));
        assert!(error.message().contains("recursion limit"), "{}", error.message());
    }
    let error = set("colony", &[&format!("name={}", "[".repeat(100_000))]).unwrap_err();
    assert_eq!(error.kind(), FaultKind::BadOverride);
}

#[test]
fn comments_and_trailing_commas_are_read_and_faults_keep_their_places() {
    let text = "{\n  // a ball\n  \"name\": \"ball\", /* in\n space */ \"time\": { \"dt\": 0.1, \"end\": 1, },\n  # one body\n  \"bodies\": [{ \"shape\": { \"sphere\": { \"radius\": 1, }, }, \"position\": [0, 0, 0,], }],\n}\n";
    assert_eq!(Scene::parse(text, "ball.json").unwrap().time.end, 1.0);
    let error = Scene::parse(&text.replace("0.1", "-0.1"), "ball.json").unwrap_err();
    assert_eq!((error.key(), error.line(), error.column()), ("time.dt", Some(4), Some(27)));
    let shown = format!("{:?}", miette::Report::new(error));
    assert!(shown.contains("space */") && shown.contains("# one body"), "{shown}");
    let error = Scene::parse("{ \"name\": \"x\" /* no end", "x.json").unwrap_err();
    assert_eq!(error.kind(), FaultKind::Syntax);
}
