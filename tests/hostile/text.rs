//! Damage to JSON text by its tokens, so that much of it is still JSON.

use super::mutants::{damage, pick, span};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::ops::Range;

/// What takes the place of a number, or of any value.
const VALUES: [&str; 36] = [
    "0",
    "-0.0",
    "1",
    "2",
    "3",
    "-1",
    "0.5",
    "1e308",
    "1e-308",
    "1e-320",
    "1e12",
    "1e60",
    "1e-60",
    "1e61",
    "1e15",
    "1000000000",
    "1000000000000",
    "16777216",
    "9007199254740991",
    "9007199254740993",
    "18446744073709551615",
    "18446744073709551616",
    "1e400",
    "NaN",
    "\"NaN\"",
    "Infinity",
    "null",
    "true",
    "\"\"",
    "[]",
    "{}",
    "[[[[[0]]]]]",
    "[0, 0, 0]",
    "[1e-59, 1e-30, 1e30]",
    "{\"a\": {\"b\": []}}",
    "1e-9",
];

/// What takes the place of a string: names that leave a folder, that files cannot have, and words of scenes.
const STRINGS: [&str; 30] = [
    "..",
    "../../etc/passwd",
    "/",
    "/etc/passwd",
    "a/b",
    "a\\\\b",
    "\\u0000",
    "a\\u0000b",
    "",
    ".",
    "...",
    "\\ud800",
    "\\u202e",
    "CON",
    "\u{e9}\u{1f600}",
    "colony",
    "colony.json",
    "rods.json",
    "sphere",
    "torus",
    "ellipsoid",
    "bodies",
    "seed",
    "bodies.0.position.1",
    "forces.0.uniform.force.2",
    "a.b.c.d",
    "time.dt",
    "generate.0.isotropic.count",
    "-",
    "name",
];

/// A JSON text with some faults, mostly one. `words` are put where strings are, beside [`STRINGS`].
pub fn mutate(random: &mut ChaCha8Rng, text: &str, words: &[&str]) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..[1, 1, 1, 1, 2, 4][random.random_range(0..6)] {
        if random.random_bool(0.15) {
            damage(random, &mut bytes);
        } else {
            damage_token(random, &mut bytes, words);
        }
    }
    bytes
}

fn damage_token(random: &mut ChaCha8Rng, bytes: &mut Vec<u8>, words: &[&str]) {
    let tokens = tokens(bytes);
    if tokens.is_empty() {
        return;
    }
    let is_value = |token: &&Range<usize>| !b"{}[]:,".contains(&bytes[token.start]);
    let values: Vec<Range<usize>> = tokens.iter().filter(is_value).cloned().collect();
    let any = tokens[random.random_range(0..tokens.len())].clone();
    let value = if values.is_empty() { any.clone() } else { values[random.random_range(0..values.len())].clone() };
    let other = tokens[random.random_range(0..tokens.len())].clone();
    match random.random_range(0..18) {
        0..=9 => {
            let new = replacement(random, bytes[value.start] == b'"', words);
            bytes.splice(value, new);
        }
        10 => {
            let string = random.random_bool(0.5);
            let new = replacement(random, string, words);
            bytes.splice(any, new);
        }
        11 => {
            // Two values change places, or two keys do.
            let with = values.get(random.random_range(0..values.len().max(1))).unwrap_or(&any).clone();
            let (first, second) = if value.start < with.start { (value, with) } else { (with, value) };
            if first.end <= second.start {
                let moved = bytes[first.clone()].to_vec();
                let back = bytes.splice(second, moved).collect::<Vec<u8>>();
                bytes.splice(first, back);
            }
        }
        12 => drop(bytes.drain(any)),
        13 => {
            let copied = bytes[other].to_vec();
            bytes.splice(any.start..any.start, copied);
        }
        14 | 15 => {
            // A list's element, or a part of a text, twice or not at all.
            let range = whole(bytes, any.start);
            let copied = [&bytes[range.clone()], b","].concat();
            if random.random_bool(0.6) {
                bytes.splice(range.start..range.start, copied);
            } else {
                bytes.drain(range);
            }
        }
        16 => {
            let range = whole(bytes, any.start);
            let inside = bytes[whole(bytes, other.start)].to_vec();
            bytes.splice(range, inside);
        }
        _ => {
            let range = span(random, tokens.len());
            if let Some(last) = tokens[range.clone()].last() {
                bytes.drain(tokens[range.start].start..last.end);
            }
        }
    }
}

fn replacement(random: &mut ChaCha8Rng, string: bool, words: &[&str]) -> Vec<u8> {
    if !string || random.random_bool(0.1) {
        return pick(random, &VALUES).as_bytes().to_vec();
    }
    let word = match random.random_range(0..8) {
        0 => "x".repeat(random.random_range(1..3_000)),
        1 => "a.".repeat(random.random_range(1..2_000)),
        2..=4 if !words.is_empty() => pick(random, words).to_owned(),
        _ => pick(random, &STRINGS).to_owned(),
    };
    format!("\"{word}\"").into_bytes()
}

/// Where the tokens of JSON stand; what is none is one of a byte.
fn tokens(bytes: &[u8]) -> Vec<Range<usize>> {
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let start = at;
        at += 1;
        match bytes[start] {
            b if b.is_ascii_whitespace() => continue,
            b'"' => {
                while at < bytes.len() && bytes[at] != b'"' {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at = (at + 1).min(bytes.len());
            }
            b if b.is_ascii_alphanumeric() || b"+-.".contains(&b) => {
                let more = |b: &u8| b.is_ascii_alphanumeric() || b"+-.".contains(b);
                while bytes.get(at).is_some_and(more) {
                    at += 1;
                }
            }
            _ => {}
        }
        found.push(start..at);
    }
    found
}

/// The value that starts at a token: to the bracket that closes it, where it opens one.
fn whole(bytes: &[u8], start: usize) -> Range<usize> {
    let mut open = 0_usize;
    for token in tokens(&bytes[start..]) {
        match bytes[start + token.start] {
            b'{' | b'[' => open += 1,
            b'}' | b']' => open = open.saturating_sub(1),
            _ => {}
        }
        if open == 0 {
            return start..start + token.end;
        }
    }
    start..bytes.len()
}
