//! Which folder may use which: those above it in the list of ARCHITECTURE.md. This test reads the list and all sources,
//! and fails where a folder uses one below it, or one that the list does not name; so no two can use each other.

use crate::additions::{code, sources};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// What stands outside of the list: the crate's face, the error that all convert into, the door of tests and benches,
/// and the tests of the sources.
const OUTSIDE: [&str; 7] = ["lib", "main", "error", "internals", "additions", "circles", "layers"];

/// The program is a crate of its own.
const PROGRAM: &str = "cli";

/// The folders and files of the list, in their order.
fn listed(architecture: &str) -> Vec<String> {
    let tree = architecture.split("```").nth(1).unwrap();
    let first_words = tree.lines().filter_map(|line| line.split_whitespace().next());
    first_words.filter_map(|word| word.strip_suffix('/').or(word.strip_suffix(".rs"))).map(str::to_owned).collect()
}

/// The folders and files right below `src` that some code names.
fn used(code: &str) -> BTreeSet<&str> {
    let identifier = |text: &str| text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let mut used = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        assert!(!rest.starts_with('{'), "write one `use` a folder, so that this test can read them");
        used.insert(&rest[..identifier(rest)]);
    }
    used
}

#[test]
fn no_folder_uses_one_below_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let listed = listed(&fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap());
    let rank = |name: &str| listed.iter().position(|own| own == name);
    let mut all = Vec::new();
    sources(&root.join("src"), &mut all);
    let (mut arrows, mut wrong) = (BTreeSet::new(), BTreeSet::new());
    for path in &all {
        let below = path.strip_prefix(root.join("src")).unwrap().iter().next().unwrap().to_string_lossy().into_owned();
        let from = below.trim_end_matches(".rs").to_owned();
        if OUTSIDE.contains(&from.as_str()) || from == PROGRAM {
            continue;
        }
        let own = rank(&from).unwrap_or_else(|| panic!("ARCHITECTURE.md does not name {from}"));
        let code = code(path);
        for to in used(&code).into_iter().filter(|to| *to != from) {
            // A name of the crate's face stands for the folder that it comes from.
            if let Some(to_rank) = rank(to) {
                arrows.insert((from.clone(), to.to_owned()));
                if to_rank > own {
                    wrong.insert(format!("{from} uses {to}"));
                }
            }
        }
    }
    assert!(arrows.len() > 100, "{arrows:?}");
    assert!(wrong.is_empty(), "{wrong:?}");
}
