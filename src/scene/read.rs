//! Reads scenes: from a file, from text, from a built-in name, with overrides.
//!
//! Without overrides, text is deserialized directly; with overrides, through a JSON tree that also refuses repeated
//! keys. In both cases a fault has its dotted key, and its line and column if it is in the text.

use super::comments::blanked;
use super::error::{FaultKind, SceneError, shortened};
use super::nearest::nearest;
use super::place::{self, Place};
use super::set::Override;
use super::translate::{Misread, names_of_unknown, needs_single_key, segment, translate, translate_syntax};
use super::tree::Tree;
use super::{BuiltIn, Scene};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The largest scene file, in bytes: room for the largest number of bodies ([`super::MAX_BODIES`]), listed at about 500
/// bytes each with lineage and velocities.
pub const MAX_FILE_BYTES: u64 = 8 << 30;

/// The source that means the standard input.
const STANDARD_INPUT: &str = "-";

/// No overrides, for [`Scene::load`].
pub const NO_OVERRIDES: [&str; 0] = [];

impl Scene {
    /// Reads and validates a scene file: JSON, in which comments (`//`, `/* */`, `#`) and trailing commas are allowed.
    ///
    /// # Errors
    /// [`SceneError`] with its location: a file that cannot be read ([`FaultKind::Io`]), text that is not JSON,
    /// unknown, missing and repeated keys, wrong types, and everything that [`Scene::validate`] refuses.
    pub fn read(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
        Source::file(path.as_ref())?.scene(&[])
    }

    /// Reads and validates a scene from JSON text; `origin` names the text in messages.
    ///
    /// ```
    /// let text = r#"{ "name": "ball", "time": { "dt": 0.1, "end": 1 },
    ///                 "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] } ] }"#;
    /// let scene = relcp::Scene::parse(text, "ball.json")?;
    /// assert_eq!(scene.time.steps(), 10);
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Scene::read`], except those of files.
    pub fn parse(text: &str, origin: &str) -> Result<Scene, SceneError> {
        parse_with(text, origin, &[])
    }

    /// Reads a built-in scene by its name ([`BuiltIn::ALL`]).
    ///
    /// ```
    /// let scene = relcp::Scene::built_in("colony")?;
    /// assert!(scene.planar && scene.growth.len() == 1);
    /// assert!(relcp::Scene::built_in("colny").is_err());
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError`] of the kind [`FaultKind::UnknownScene`] if no such scene exists.
    pub fn built_in(name: &str) -> Result<Scene, SceneError> {
        parse_with(BuiltIn::find(name)?.text, name, &[])
    }

    /// Reads and validates a built-in scene by its name, or else a scene file by its path, after overrides `KEY=VALUE`.
    /// Without any: [`Scene::built_in`], [`Scene::read`], or [`NO_OVERRIDES`].
    ///
    /// A key is dotted, with indices for lists (`bodies.0.position.1=2.5`); missing objects on its path are created,
    /// and an index one past a list's end appends to the list. A value is JSON, or else a string. A built-in name takes
    /// precedence over a file of that name; use `./NAME` for the file. `-` is the standard input.
    ///
    /// ```
    /// let scene = relcp::Scene::load("two-ellipsoids", ["time.dt=0.05", "contact.method=snsd"])?;
    /// assert_eq!(scene.time.dt, 0.05);
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Scene::read`]; also an override that is not `KEY=VALUE`, or whose key cannot be resolved or does not exist.
    pub fn load(
        source: impl AsRef<Path>,
        overrides: impl IntoIterator<Item = impl AsRef<str>>,
    ) -> Result<Scene, SceneError> {
        let sets = overrides.into_iter().map(|set| Override::parse(set.as_ref())).collect::<Result<Vec<_>, _>>()?;
        Scene::load_with(source.as_ref(), &sets)
    }

    /// [`Scene::load`], with parsed overrides.
    pub(crate) fn load_with(source: &Path, sets: &[Override]) -> Result<Scene, SceneError> {
        match source.to_str().and_then(BuiltIn::named) {
            Some(scene) => parse_with(scene.text, scene.name, sets),
            None if source == Path::new(STANDARD_INPUT) => Source::standard_input()?.scene(sets),
            None => Source::file(source)?.scene(sets),
        }
    }
}

impl SceneError {
    /// A fault of placing the bodies of a scene, with the location of its key in the file, the built-in scene or the
    /// override that the scene was read from. It is unchanged where the source cannot be read again (the standard
    /// input), and where placement was interrupted: nothing is wrong with the scene then.
    #[must_use]
    pub fn located_in(self, source: impl AsRef<Path>, overrides: impl IntoIterator<Item = impl AsRef<str>>) -> Self {
        let sets: Result<Vec<_>, _> = overrides.into_iter().map(|set| Override::parse(set.as_ref())).collect();
        let source = source.as_ref();
        let text = match source.to_str().and_then(BuiltIn::named) {
            Some(scene) => Ok(Source::new(scene.text, scene.name)),
            None => Source::file(source),
        };
        match (text, sets) {
            (Ok(text), Ok(sets)) if source != Path::new(STANDARD_INPUT) && self.kind() != FaultKind::Interrupted => {
                text.shown(put(self, &text.origin, &text.text, &sets))
            }
            _ => self,
        }
    }
}

impl BuiltIn {
    /// The built-in scene of this name.
    ///
    /// # Errors
    /// [`FaultKind::UnknownScene`] if no built-in scene has this name; its help has the nearest name.
    pub fn find(name: &str) -> Result<&'static BuiltIn, SceneError> {
        BuiltIn::named(name).ok_or_else(|| unknown_scene(name, "there is no built-in scene"))
    }
}

fn unknown_scene(name: &str, what: &str) -> SceneError {
    let refused = SceneError::new(FaultKind::UnknownScene, "", format!("{what} `{}`", shortened(name, LONGEST_NAME)));
    match nearest_built_in(name) {
        Some(near) => refused.with_help(format!("the nearest built-in scene is `{near}`")),
        None => refused,
    }
}

/// Whether a source is a bare word, like the names of built-in scenes: without folder and extension.
pub(crate) fn is_bare(source: &Path) -> bool {
    source.components().count() == 1 && source.extension().is_none()
}

/// The longest name of a scene in a message, in characters.
const LONGEST_NAME: usize = 60;

fn nearest_built_in(name: &str) -> Option<&'static str> {
    nearest(name, BuiltIn::ALL.iter().map(|scene| scene.name))
}

/// A text that is read once, with its name in messages.
pub(crate) struct Source {
    origin: String,
    /// The text with blanks in place of comments.
    text: String,
    /// The text with its comments, if it has any.
    written: Option<String>,
}

impl Source {
    /// A text in memory. A byte order mark, which some editors write, is skipped.
    pub fn new(text: &str, origin: &str) -> Self {
        Source::of(unmarked(text).to_owned(), origin.to_owned())
    }

    fn of(text: String, origin: String) -> Self {
        match blanked(&text) {
            Cow::Borrowed(_) => Source { origin, text, written: None },
            Cow::Owned(blanked) => Source { origin, text: blanked, written: Some(text) },
        }
    }

    /// The original text.
    fn written(&self) -> &str {
        self.written.as_ref().unwrap_or(&self.text)
    }

    /// Shows a fault of this text, not of an override, with its comments.
    fn shown(&self, error: SceneError) -> SceneError {
        match &self.written {
            Some(written) if error.origin() == Some(&self.origin) => error.shown_in(written),
            _ => error,
        }
    }

    /// The text from the standard input.
    fn standard_input() -> Result<Self, SceneError> {
        let origin = "standard input".to_owned();
        Source::decoded(take_bytes(std::io::stdin().lock(), &origin)?, origin)
    }

    /// A file's text.
    pub fn file(path: &Path) -> Result<Self, SceneError> {
        let origin = path.display().to_string();
        Source::decoded(read_bytes(path, &origin)?, origin)
    }

    fn decoded(bytes: Vec<u8>, origin: String) -> Result<Self, SceneError> {
        match String::from_utf8(bytes) {
            Ok(text) if unmarked(&text).len() == text.len() => Ok(Source::of(text, origin)),
            Ok(text) => Ok(Source::new(&text, &origin)),
            Err(e) => {
                let start = e.utf8_error().valid_up_to();
                let text = String::from_utf8_lossy(e.as_bytes());
                let fault = SceneError::new(FaultKind::Syntax, "", "the file is not UTF-8 text");
                // Up to the fault the lossy text equals the file's; at the fault it has the three bytes of U+FFFD.
                Err(fault.at(&origin, &text, Place { start, end: (start + 3).min(text.len()) }))
            }
        }
    }

    /// Its name in messages.
    pub fn origin(&self) -> &str {
        &self.origin
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Parses the text as a scene, after overrides.
    pub fn scene(&self, sets: &[Override]) -> Result<Scene, SceneError> {
        parse_json(&self.text, &self.origin, sets).map_err(|error| self.shown(error))
    }

    /// Parses the text as a document of another type, as strictly as a scene: an object without unknown or repeated
    /// keys.
    pub fn document<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        let read = || {
            let value = tree(&self.text)?;
            if value.is_array() {
                let error = SceneError::new(FaultKind::WrongType, "", "expected an object, found a list");
                return Err(Misread { error, byte: None });
            }
            // From the text, which keeps the order of keys; after a fault from the tree, which gives its path.
            serde_json::from_str(&self.text).or_else(|_| from_tree(value, &self.text))
        };
        let placed = |misread| self.shown(misplaced(misread, &self.origin, &self.text, &[]));
        read().map_err(placed)
    }

    /// Locates a fault of that document by its key.
    pub fn put(&self, error: SceneError) -> SceneError {
        self.shown(put(error, &self.origin, &self.text, &[]))
    }

    /// Sets the location of a fault to a range of the text.
    pub fn at(&self, error: SceneError, place: Place) -> SceneError {
        error.at(&self.origin, self.written(), narrowed(&self.text, place))
    }
}

fn unmarked(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// The remedy where a file of a bare name is missing.
const NO_FILE: &str = "the current folder has no such file, and no built-in scene has a name like it";

fn read_bytes(path: &Path, origin: &str) -> Result<Vec<u8>, SceneError> {
    let refuse = |message: String| SceneError::new(FaultKind::Io, "", message).of(origin);
    let file = File::open(path).map_err(|e| {
        let fault = refuse(format!("cannot be read: {e}"));
        if e.kind() != std::io::ErrorKind::NotFound || path.components().count() != 1 {
            return fault;
        }
        if is_bare(path) {
            return unknown_scene(origin, "there is no built-in scene and no file named");
        }
        match nearest_built_in(path.file_stem().and_then(|stem| stem.to_str()).unwrap_or(origin)) {
            Some(name) => {
                fault.with_help(format!("neither a file nor a built-in scene; the nearest built-in scene is `{name}`"))
            }
            None => fault.with_help(NO_FILE),
        }
    })?;
    let meta = file.metadata().map_err(|e| refuse(format!("cannot be read: {e}")))?;
    if meta.is_dir() {
        return Err(refuse("is a directory, not a scene file".to_owned()));
    }
    take_bytes(file, origin)
}

fn take_bytes(from: impl Read, origin: &str) -> Result<Vec<u8>, SceneError> {
    let mut bytes = Vec::new();
    let fault = |e| SceneError::new(FaultKind::Io, "", format!("cannot be read: {e}")).of(origin);
    from.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(
            SceneError::new(FaultKind::TooLarge, "", format!("is longer than {MAX_FILE_BYTES} bytes")).of(origin)
        );
    }
    Ok(bytes)
}

fn parse_with(text: &str, origin: &str, sets: &[Override]) -> Result<Scene, SceneError> {
    Source::new(text, origin).scene(sets)
}

fn parse_json(text: &str, origin: &str, sets: &[Override]) -> Result<Scene, SceneError> {
    let mut scene = typed(text, sets).map_err(|misread| misplaced(misread, origin, text, sets))?;
    scene.validate().map_err(|error| put(error, origin, text, sets))?;
    scene.normalize_orientations();
    Ok(scene)
}

/// A scene with other values of keys, not validated. A fault has its key.
pub(super) fn reread(scene: &Scene, sets: &[Override]) -> Result<Scene, SceneError> {
    typed(&scene.to_json(), sets).map_err(|misread| misread.error)
}

fn misplaced(misread: Misread, origin: &str, text: &str, sets: &[Override]) -> SceneError {
    match misread.byte {
        Some(byte) => misread.error.at(origin, text, character(text, byte)),
        None => put(misread.error, origin, text, sets),
    }
}

fn typed(text: &str, sets: &[Override]) -> Result<Scene, Misread> {
    if sets.is_empty()
        && let Ok(scene) = serde_json::from_str(text)
    {
        return refuse_lists(text).map(|()| scene);
    }
    // The slow way, by a tree: for overrides, and for the location and the wording of a fault.
    let mut value = tree(text)?;
    for set in sets {
        set.apply(&mut value).map_err(|error| Misread { error, byte: None })?;
    }
    let effective = value.to_string();
    let scene = from_tree(value, text).map_err(|misread| match refuse_lists(&effective) {
        // serde takes a list for an object and complains of the list's first item.
        Err(list) if misread.error.key().starts_with(&format!("{}.", list.error.key())) => list,
        _ => misread,
    })?;
    refuse_lists(&effective).map(|()| scene)
}

fn tree(text: &str) -> Result<Value, Misread> {
    if text.trim().is_empty() {
        let error = SceneError::new(FaultKind::Syntax, "", "the text is empty; expected a JSON object");
        return Err(Misread { error, byte: Some(0) });
    }
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let tree: Tree =
        serde_path_to_error::deserialize(&mut deserializer).map_err(|e| translate(e.path(), e.inner(), text))?;
    deserializer.end().map_err(|e| translate_syntax(&e, text))?;
    Ok(tree.0)
}

fn from_tree<T: DeserializeOwned>(value: Value, text: &str) -> Result<T, Misread> {
    serde_path_to_error::deserialize(&value).map_err(|e| {
        let choices = if needs_single_key(e.inner()) { choices_at::<T>(&value, e.path()) } else { Vec::new() };
        translate(e.path(), e.inner(), text).with_choices(&choices)
    })
}

/// The keys that may stand at a path whose value must be an object with a single key: serde names them where that key
/// is unknown.
fn choices_at<T: DeserializeOwned>(value: &Value, path: &serde_path_to_error::Path) -> Vec<String> {
    let pointer: String = path.iter().filter_map(segment).map(|key| format!("/{}", pointed(&key))).collect();
    let mut probe = value.clone();
    let Some(place) = probe.pointer_mut(&pointer) else { return Vec::new() };
    *place = Value::Object([(String::new(), Value::Null)].into_iter().collect());
    match serde_path_to_error::deserialize::<_, T>(&probe) {
        Err(fault) if fault.path().to_string() == path.to_string() => names_of_unknown(fault.inner()),
        _ => Vec::new(),
    }
}

/// A key in a JSON pointer (RFC 6901).
fn pointed(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// The keys whose values are lists of lists.
const LISTS_OF_LISTS: [&str; 3] = ["at", "points", "axes"];

/// The keys whose values are lists.
const LISTS: &[&str] = &[
    "bonds",
    "joints",
    "daughter_bonds",
    "rest",
    "at",
    "bodies",
    "forces",
    "generate",
    "position",
    "orientation",
    "velocity",
    "angular_velocity",
    "force",
    "acceleration",
    "torque",
    "axes",
    "radii",
    "exponents",
    "walls",
    "normal",
    "center",
    "axis",
    "minimum",
    "maximum",
    "direction",
    "gradient",
    "strain_rate",
    "lengths",
    "measures",
    "growth",
    "removal",
    "cells",
    "values",
    "held",
    "exchange",
    "x",
    "y",
    "z",
    "mixture",
    "groups",
    "between",
    "changes",
    "points",
    "counts",
    "repeat",
    "offset",
    "start",
    "target",
    "point",
    "add",
    "remove",
];

/// Keys whose object holds the list that users write in its place, with the remedy.
const LISTS_WITHIN: [(&str, &str); 1] = [("periodic", "write \"periodic\": {\"lengths\": [...]}")];

/// The key whose object has values of any type, by dotted keys.
const OF_ANY_TYPE: &str = "set";

fn refuse_lists(text: &str) -> Result<(), Misread> {
    match place::misplaced_list(text, LISTS, &LISTS_OF_LISTS, OF_ANY_TYPE) {
        None => Ok(()),
        Some(path) => {
            let words = "expected an object or a single value, found a list";
            let error = SceneError::new(FaultKind::WrongType, path.join("."), words);
            let help = LISTS_WITHIN.iter().find(|(key, _)| *key == path.join(".")).map(|(_, help)| *help);
            Err(Misread { error: help.into_iter().fold(error, SceneError::with_help), byte: None })
        }
    }
}

/// Locates a fault by its key: in an override or in the text.
fn put(error: SceneError, origin: &str, text: &str, sets: &[Override]) -> SceneError {
    if error.origin().is_some() {
        return error;
    }
    let path: Vec<String> = error.key().split('.').filter(|s| !s.is_empty()).map(str::to_owned).collect();
    let found = place::locate(text, &path);
    let whole = found.is_some_and(|f| f.depth == path.len());
    if let Some(set) = sets.iter().rev().find(|s| s.made(&path) || (!whole && s.passed(&path))) {
        return set.blame(error);
    }
    let Some(found) = found else { return error.of(origin) };
    let key_is_wrong = matches!(error.kind(), FaultKind::UnknownKey) || !whole;
    let place = found.key.filter(|_| key_is_wrong).unwrap_or(found.value);
    error.at(origin, text, narrowed(text, place))
}

/// A location on one line; of a longer one, its first character.
fn narrowed(text: &str, place: Place) -> Place {
    if text[place.start..place.end].contains('\n') { character(text, place.start) } else { place }
}

fn character(text: &str, byte: usize) -> Place {
    let length = text.get(byte..).and_then(|t| t.chars().next()).map_or(0, char::len_utf8);
    Place { start: byte, end: byte + length }
}
