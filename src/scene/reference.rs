//! The keys of a scene as a page of Markdown, from the same types as the JSON Schema: one section per object, one line
//! per key.

use super::schema;
use serde_json::{Map, Value};
use std::fmt::Write as _;

/// The prefix of named objects in the schema.
const DEFINITIONS: &str = "#/$defs/";

/// The page.
///
/// ```
/// let page = relcp::scene::reference();
/// assert!(page.contains("`overlap_tolerance`"));
/// ```
pub fn reference() -> String {
    let schema = schema();
    let mut page = String::from(
        "# The keys of a scene\n\nMade by `relcp schema --markdown` from the types that scenes are read into. Lengths, times and forces are in units of \
         your own; keys in bold are required.\n",
    );
    section(&mut page, "A scene", &schema);
    let none = Map::new();
    for (name, object) in schema["$defs"].as_object().unwrap_or(&none) {
        section(&mut page, name, object);
    }
    page
}

fn section(page: &mut String, name: &str, object: &Value) {
    let _ = write!(page, "\n## {name}\n\n{}\n", text(object));
    if object.get("properties").is_some() {
        page.push('\n');
        head(page);
        keys(page, "", object);
    }
    let Some(cases) = object["oneOf"].as_array() else { return };
    page.push_str("\nOne of:\n\n");
    head(page);
    for case in cases {
        one_case(page, case);
    }
}

fn head(page: &mut String) {
    page.push_str("| key | type | default | |\n| --- | --- | --- | --- |\n");
}

/// Writes one case of a choice: a word, several words, or an object with a single key that has keys of its own.
fn one_case(page: &mut String, case: &Value) {
    let words = case["enum"].as_array().map_or(case.get("const").into_iter().collect(), |words| words.iter().collect());
    let words: Vec<&Value> = words;
    for word in &words {
        let _ = writeln!(page, "| `{word}` | | | {} |", text(case));
    }
    let none = Map::new();
    for (key, object) in case["properties"].as_object().filter(|_| words.is_empty()).unwrap_or(&none) {
        let told = if object.get("description").is_some() { text(object) } else { text(case) };
        let _ = writeln!(page, "| `{key}` | {} | | {told} |", kind(object));
        keys(page, &format!("{key}."), object);
    }
}

fn keys(page: &mut String, before: &str, object: &Value) {
    let none = Map::new();
    let required = |key: &str| object["required"].as_array().is_some_and(|keys| keys.iter().any(|k| k == key));
    for (key, value) in object["properties"].as_object().unwrap_or(&none) {
        let mark = if required(key) { "**" } else { "" };
        let default = value.get("default").filter(|d| !d.is_null()).map_or(String::new(), |d| format!("`{d}`"));
        let _ = writeln!(page, "| {mark}`{before}{key}`{mark} | {} | {default} | {} |", kind(value), text(value));
    }
}

/// Describes a value: its type with its bounds, or a link to a section.
fn kind(value: &Value) -> String {
    if let Some(name) = value["$ref"].as_str().and_then(|path| path.strip_prefix(DEFINITIONS)) {
        return format!("[{name}](#{})", name.to_lowercase());
    }
    if let Some(cases) = value["anyOf"].as_array() {
        let kinds = cases.iter().filter(|case| case["type"] != "null").map(kind);
        return kinds.collect::<Vec<_>>().join(" or ");
    }
    if let Some(word) = value.get("const") {
        return format!("`{word}`");
    }
    let types: Vec<&str> = match &value["type"] {
        Value::String(one) => vec![one],
        Value::Array(several) => several.iter().filter_map(Value::as_str).filter(|t| *t != "null").collect(),
        _ => Vec::new(),
    };
    if types == ["array"] {
        let items = kind(&value["items"]);
        return match (value["minItems"].as_u64(), value["maxItems"].as_u64()) {
            (Some(n), Some(m)) if n == m => tuple(n, &items),
            _ => format!("list of {items}"),
        };
    }
    let bound = |key: &str, sign: &str| value.get(key).map(|limit| format!("{sign} {limit}"));
    let bounds =
        [bound("minimum", "≥"), bound("exclusiveMinimum", ">"), bound("maximum", "≤"), bound("exclusiveMaximum", "<")];
    let bounds: Vec<String> = bounds.into_iter().flatten().collect();
    format!("{} {}", types.join(" or "), bounds.join(", ")).trim().to_owned()
}

/// A list of fixed length; numbers are named by their axes.
fn tuple(count: u64, items: &str) -> String {
    let axes = match count {
        3 => "`[x, y, z]`",
        4 => "`[w, x, y, z]`",
        _ => return format!("{count} × {items}"),
    };
    match items.strip_prefix("number") {
        Some("") => axes.into(),
        Some(bounds) => format!("{axes}, each{bounds}"),
        None => format!("{count} × {items}"),
    }
}

/// The description of an object, in one line.
fn text(object: &Value) -> String {
    object["description"].as_str().unwrap_or_default().replace('\n', " ").replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_in_the_docs_is_the_types() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scene.md");
        let committed = std::fs::read_to_string(page).unwrap();
        assert!(committed == reference(), "docs/scene.md is old: relcp schema --markdown > docs/scene.md");
    }

    #[test]
    fn every_key_of_every_object_is_there() {
        fn walk(value: &Value, page: &str, keys: &mut usize) {
            match value {
                Value::Object(map) => {
                    for key in map.get("properties").and_then(Value::as_object).into_iter().flat_map(Map::keys) {
                        assert!(page.contains(&format!("`{key}`")) || page.contains(&format!(".{key}`")), "{key}");
                        *keys += 1;
                    }
                    map.values().for_each(|value| walk(value, page, keys));
                }
                Value::Array(values) => values.iter().for_each(|value| walk(value, page, keys)),
                _ => {}
            }
        }
        let mut keys = 0;
        walk(&schema(), &reference(), &mut keys);
        assert!(keys > 60, "{keys}");
    }
}
