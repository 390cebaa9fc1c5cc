//! The tutorials' own text, run: files are written as a page says, commands run in their order, with the options of the
//! page's `<!-- test: ... -->`, which make runs short.

use super::place::Place;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The most settings of a key, and seeds, of a sweep in this test.
const MOST_OF_SWEEP: usize = 2;

fn page(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name)).unwrap()
}

/// The blocks of a page, with the line of text before each.
fn blocks(page: &str) -> Vec<(String, String, String)> {
    let (mut blocks, mut text, mut lines) = (Vec::new(), String::new(), page.lines());
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let code: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            blocks.push((std::mem::take(&mut text), language.to_owned(), code.join("\n")));
        } else if !line.is_empty() {
            text = line.to_owned();
        }
    }
    blocks
}

/// The file that "Write `name`" asks for.
fn file_of(text: &str) -> Option<&str> {
    text.strip_prefix("Write `")?.split('`').next()
}

/// Writes the files of a page; a sweep gets the options `set`, few seeds and few settings of each key.
fn write_files(place: &Place, page: &str, set: &[(String, Value)]) {
    for (text, language, code) in blocks(page) {
        let Some(name) = file_of(&text) else { continue };
        assert!(["json", "python"].contains(&language.as_str()), "{name}: {language}");
        let mut code = code;
        if let Ok(mut sweep) = serde_json::from_str::<Value>(&code)
            && sweep.get("grid").is_some()
        {
            set.iter().for_each(|(key, value)| sweep["set"][key] = value.clone());
            sweep["seeds"]["count"] = json!(MOST_OF_SWEEP);
            let grid = sweep["grid"].as_object_mut().unwrap().values_mut();
            grid.for_each(|values| values.as_array_mut().unwrap().truncate(MOST_OF_SWEEP));
            code = sweep.to_string();
        }
        fs::write(place.at(name), code).unwrap();
    }
}

/// The settings of `<!-- test: --set KEY=VALUE -->`.
fn settings(page: &str) -> Vec<(String, Value)> {
    let named = page.split_once("<!-- test:").expect("a tutorial says how its test is short").1;
    let words: Vec<&str> = named.split("-->").next().unwrap().split_whitespace().collect();
    let pairs = words.chunks(2).map(|pair| (pair[0], pair[1].split_once('=').unwrap()));
    pairs
        .map(|(set, (key, value))| {
            assert_eq!(set, "--set");
            (key.to_owned(), serde_json::from_str(value).unwrap())
        })
        .collect()
}

/// A Python that can make the figures, if there is one.
fn python() -> Option<&'static str> {
    let has = |code: &str| Command::new("python3").args(["-c", code]).output().is_ok_and(|ran| ran.status.success());
    has("import matplotlib").then_some("python3")
}

fn run(name: &str) {
    let (place, page) = (Place::new(), page(name));
    let set = settings(&page);
    if let Some((_, rest)) = page.split_once("Begin with `") {
        let from = rest.split('(').nth(1).unwrap().split(')').next().unwrap();
        write_files(&place, &self::page(from), &set);
    }
    write_files(&place, &page, &set);
    let (mut commands, mut skipped) = (0, 0);
    for (_, _, code) in blocks(&page).iter().filter(|(_, language, _)| language == "sh") {
        for line in code.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let words: Vec<&str> = words.iter().copied().take_while(|word| *word != "#").collect();
            match words[0] {
                "relcp" => {
                    let own: Vec<String> = set.iter().map(|(key, value)| format!("--set={key}={value}")).collect();
                    let own = own.iter().map(String::as_str).filter(|_| words[1] == "run");
                    let all: Vec<&str> = words[1..].iter().copied().chain(own).collect();
                    place.relcp(&all).expect(0);
                }
                "python3" => {
                    let Some(python) = python() else {
                        println!("SKIP {name}: {line}: no python3 with matplotlib");
                        skipped += 1;
                        continue;
                    };
                    let ran = Command::new(python).args(&words[1..]).current_dir(&place.0).output().unwrap();
                    assert!(ran.status.success(), "{name}: {line}: {}", String::from_utf8_lossy(&ran.stderr));
                }
                other => panic!("{name}: {other}"),
            }
            commands += 1;
        }
    }
    let figures = page.matches("](pictures/tutorial-").count();
    assert!(commands + skipped >= 2 && figures >= 1, "{name}: {commands} commands, {figures} pictures");
}

#[test]
fn the_tutorial_of_a_colony_runs() {
    run("tutorial-colony.md");
}

#[test]
fn the_tutorial_of_a_chamber_runs() {
    run("tutorial-trap.md");
}

#[test]
fn the_tutorial_of_a_packing_runs() {
    run("tutorial-packing.md");
}

#[test]
fn the_tutorial_of_a_sweep_runs() {
    run("tutorial-sweep.md");
}

#[test]
fn the_tutorial_of_a_filament_runs() {
    run("tutorial-filament.md");
}

#[test]
fn the_tutorial_of_a_heap_runs() {
    run("tutorial-pile.md");
}
