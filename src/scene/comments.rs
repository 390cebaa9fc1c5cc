//! Comments (`//`, `/* */`, `#`) and trailing commas in JSON text, as in configuration files.

use serde::de::IgnoredAny;
use std::borrow::Cow;

/// The text with blanks in place of comments and trailing commas, so that every byte keeps its offset. A text that is
/// JSON already, or whose last comment is not closed, is returned unchanged.
pub(super) fn blanked(text: &str) -> Cow<'_, str> {
    if serde_json::from_str::<IgnoredAny>(text).is_ok() {
        return text.into();
    }
    let mut blanked = text.to_owned();
    match json_strip_comments::strip(&mut blanked) {
        Ok(()) => blanked.into(),
        Err(_) => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_trailing_commas_are_blanks_and_nothing_moves() {
        let text = "{ // one\n \"a\": [1, 2, /* \u{f6} */ ], # two\n \"b\": \"// no comment\",\n}";
        let blanked = blanked(text);
        assert_eq!(blanked.len(), text.len());
        assert_eq!(blanked.find("\"b\""), text.find("\"b\""));
        let value: serde_json::Value = serde_json::from_str(&blanked).unwrap();
        assert_eq!(value, serde_json::json!({"a": [1, 2], "b": "// no comment"}));
    }

    #[test]
    fn what_is_no_comment_stays() {
        for text in ["{\"a\": 1}", "", "{\"a\" 1}"] {
            assert_eq!(blanked(text), text);
        }
    }
}
