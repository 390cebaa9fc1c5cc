//! Translates serde's messages: the key, the problem, and what was expected.

use super::error::{FaultKind, SceneError, shortened};
use super::foreign::hint;
use super::nearest::nearest;
use super::place;
use serde_json::error::Category;
use serde_path_to_error::{Path, Segment};

/// A fault of reading, with its byte offset if the location does not follow from the key.
pub(super) struct Misread {
    pub error: SceneError,
    pub byte: Option<usize>,
}

impl Misread {
    /// The same fault with the keys that may stand there, if there are any.
    pub fn with_choices(mut self, choices: &[String]) -> Self {
        if !choices.is_empty() {
            self.error = self.error.with_help(format!("the keys here are {}", choices.join(", ")));
        }
        self
    }
}

/// Whether an object with a single key was expected.
pub(super) fn needs_single_key(error: &serde_json::Error) -> bool {
    without_place(error).ends_with(SINGLE_KEY) || without_place(error).ends_with(WORD_OR_SINGLE_KEY)
}

/// What serde expects where an object has a single key; and where it may be a word too.
const SINGLE_KEY: &str = "expected map with a single key";
const WORD_OR_SINGLE_KEY: &str = "expected string or map";

/// The names that serde lists where a choice is unknown.
pub(super) fn names_of_unknown(error: &serde_json::Error) -> Vec<String> {
    let words = without_place(error);
    if !words.starts_with("unknown variant") {
        return Vec::new();
    }
    words.split('`').skip(3).step_by(2).map(str::to_owned).collect()
}

/// Translates a fault of parsing or typing at `path`.
pub(super) fn translate(path: &Path, error: &serde_json::Error, text: &str) -> Misread {
    let mut key: Vec<String> = path.iter().filter_map(segment).collect();
    let words = without_place(error);
    let byte = (error.line() > 0).then(|| place::byte_of(text, error.line(), error.column()));
    if error.classify() != Category::Data {
        return Misread { error: syntax(&words, &key.join("."), text, byte), byte };
    }
    let mut names = words.split('`').skip(1).step_by(2);
    let name = names.next().unwrap_or_default();
    let (kind, message) = if words.starts_with("unknown field") {
        (FaultKind::UnknownKey, unknown("key", name, names))
    } else if words.starts_with("unknown variant") {
        let kind = if is_object_at(text, &key) { FaultKind::UnknownKey } else { FaultKind::BadValue };
        (kind, unknown(if kind == FaultKind::UnknownKey { "key" } else { "value" }, name, names))
    } else if words.starts_with("missing field") {
        (FaultKind::MissingKey, "is missing, and has no default".to_owned())
    } else if words.starts_with("duplicate field") {
        (FaultKind::DuplicateKey, "appears twice in one object".to_owned())
    } else if words.starts_with("invalid type: unit variant") {
        let variant = key.pop().unwrap_or_default();
        (FaultKind::WrongType, format!("\"{variant}\" needs its settings: {{\"{variant}\": {{...}}}}"))
    } else if words.starts_with("invalid value: integer") {
        (FaultKind::BadValue, plain(&words))
    } else {
        (FaultKind::WrongType, plain(&words))
    };
    let names_a_key = matches!(kind, FaultKind::UnknownKey | FaultKind::MissingKey | FaultKind::DuplicateKey);
    if names_a_key && key.last().is_none_or(|last| last != name) {
        key.push(name.to_owned());
    }
    // The path gives the first of two equal keys; serde's location gives the end of the second.
    let byte = byte.filter(|_| kind == FaultKind::DuplicateKey).map(|b| start_of_key(text, b, name));
    Misread { error: SceneError::new(kind, key.join("."), message), byte }
}

/// Translates a fault of the text after its first value.
pub(super) fn translate_syntax(error: &serde_json::Error, text: &str) -> Misread {
    let byte = place::byte_of(text, error.line(), error.column());
    Misread { error: syntax(&without_place(error), "", text, Some(byte)), byte: Some(byte) }
}

pub(super) fn segment(segment: &Segment) -> Option<String> {
    match segment {
        Segment::Seq { index } => Some(index.to_string()),
        Segment::Map { key } => Some(key.clone()),
        Segment::Enum { variant } => Some(variant.clone()),
        Segment::Unknown => None,
    }
}

fn without_place(error: &serde_json::Error) -> String {
    let words = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    words.strip_suffix(&place).unwrap_or(&words).to_owned()
}

/// The longest name in messages, in characters.
const LONGEST_NAME: usize = 60;

/// Words that some programs write for numbers that JSON lacks.
const NOT_NUMBERS: [&str; 4] = ["NaN", "nan", "Infinity", "inf"];

fn syntax(words: &str, key: &str, text: &str, byte: Option<usize>) -> SceneError {
    if words == "number out of range" {
        return SceneError::bad(key, "the number is larger than a 64-bit float can hold (1.8e308)");
    }
    let rest = byte.and_then(|b| text.get(b..)).unwrap_or_default().trim_start_matches('-');
    // serde_json stops at the first or the second letter of an unknown word.
    let before = byte.and_then(|b| text.get(b.saturating_sub(1)..)).unwrap_or_default();
    if NOT_NUMBERS.iter().any(|n| rest.starts_with(n) || before.starts_with(n)) {
        return SceneError::new(FaultKind::Syntax, key, "is not finite; every number of a scene is");
    }
    SceneError::new(FaultKind::Syntax, key, format!("is not JSON: {words}"))
}

fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    let hint = hint(name, &known);
    let name = &shortened(name, LONGEST_NAME);
    if let Some(hint) = hint {
        return format!("unknown {what} `{name}`; {hint}; the {what}s here are {}", known.join(", "));
    }
    match nearest(name, known.iter().copied()) {
        _ if known.is_empty() => format!("unknown {what} `{name}`; no {what} is allowed here"),
        _ if known.len() == 1 => format!("unknown {what} `{name}`; the only {what} here is `{}`", known[0]),
        None => format!("unknown {what} `{name}`; the {what}s here are {}", known.join(", ")),
        Some(near) => {
            format!("unknown {what} `{name}`; the nearest is `{near}` (the {what}s here are {})", known.join(", "))
        }
    }
}

/// What follows where a number is a text: it may have a unit.
const UNITS: &str = "; write the number alone, in units of your own, the same for the whole scene";

/// What follows where a number is null: users leave a side of a box open by it.
const NULL: &str = "; null stands for an open axis in periodic.lengths alone (for a box with an open side, write a \
                    half_space for each of the others, or put this side far away)";

/// serde's message, with its names of types in a user's terms.
fn plain(words: &str) -> String {
    let (found, wanted) = words.split_once(", expected ").unwrap_or((words, ""));
    let found = found.trim_start_matches("invalid type: ").trim_start_matches("invalid value: ");
    let wanted = match wanted {
        "f64" => "a number",
        "u64" | "usize" => "a whole number, 0 or more, without point or exponent",
        "u32" => "a whole number from 0 to 4294967295, without point or exponent",
        "a sequence" => "a list",
        "a boolean" => "true or false",
        "string or map" => "a word or an object with a single key",
        "map with a single key" => "an object with a single key",
        "unit" => "nothing: this word has no settings",
        "fewer elements in array" => "a shorter list",
        other if other.starts_with("struct") => "an object",
        other => other,
    };
    if wanted.is_empty() {
        return format!("is refused: {found}");
    }
    if found == "null" && wanted == "a number" {
        return format!("expected a number, found null{NULL}");
    }
    let wanted = wanted.replace("an array of length", "a list of length");
    let units = if wanted == "a number" && found.starts_with("string") { UNITS } else { "" };
    format!("expected {wanted}, found {}{units}", in_words(found, &wanted))
}

/// The value that was found, in a user's terms.
fn in_words(found: &str, wanted: &str) -> String {
    let renamed = [("integer ", "the number "), ("floating point ", "the number "), ("string ", "the text ")];
    if let Some((named, name)) = renamed.iter().find(|(named, _)| found.starts_with(named)) {
        return found.replacen(named, name, 1).replace('`', "");
    }
    match (found, found.strip_prefix("invalid length ")) {
        ("map", _) if wanted.contains("a single key") => {
            "an object with no key or several: settings go inside the key".into()
        }
        ("map", _) => "an object".into(),
        ("sequence", _) => "a list".into(),
        // serde accepts a list in place of an object, in the order of its keys.
        (_, Some(_)) if wanted == "an object" => "a list".into(),
        (_, Some(length)) => format!("a list of {length}"),
        (other, None) => other.into(),
    }
}

fn is_object_at(text: &str, key: &[String]) -> bool {
    place::locate(text, key).is_some_and(|f| f.depth == key.len() && text.as_bytes().get(f.value.start) == Some(&b'{'))
}

/// serde's location of a repeated key is its closing quote.
fn start_of_key(text: &str, end: usize, name: &str) -> usize {
    text.get(..=end).and_then(|t| t.rfind(&format!("\"{name}\""))).unwrap_or(end.min(text.len()))
}
