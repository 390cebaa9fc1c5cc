//! The commands of the laboratory that the pages of the repository name are there, with their flags.

use super::place::Place;
use std::fs;
use std::path::{Path, PathBuf};

const COMMAND: &str = "cargo run --release -p relcp-lab -- ";

fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
}

#[test]
fn commands_of_the_pages_have_the_flags_that_they_name() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut all = vec![root.join("README.md"), root.join("CONTRIBUTING.md"), root.join("ARCHITECTURE.md")];
    pages(&root.join("docs"), &mut all);
    let help = Place::new().lab(&["--help"]).expect(0).out;
    let has = |word: &str| [" ", "\n", ":"].iter().any(|end| help.contains(&format!("{word}{end}")));
    let (mut commands, mut wrong) = (0, Vec::new());
    for path in all {
        let page = fs::read_to_string(&path).unwrap();
        for after in page.split(COMMAND).skip(1) {
            let line = after.split(['`', '#', '\n']).next().unwrap();
            let mut words = line.split_whitespace();
            let Some(name) = words.next().filter(|name| *name != "NAME") else { continue };
            commands += 1;
            let flags = words.filter(|word| word.starts_with("--")).map(|word| word.split('=').next().unwrap());
            if ![name].into_iter().chain(flags).all(has) {
                wrong.push(format!("{}: {line}", path.display()));
            }
        }
    }
    assert!(commands > 20 && wrong.is_empty(), "{commands} commands; wrong: {wrong:#?}");
}
