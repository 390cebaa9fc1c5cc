//! Files that use each other in a circle can only be read together. This test reads the imports of all sources, and
//! fails where a circle has more than three files.
//!
//! Circles are the strongly connected components of the graph of imports (R. E. Tarjan, SIAM J. Comput. 1, 146 (1972);
//! here by the reachability of each file, which suffices for some hundred files).

use crate::additions::{code, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The largest number of files in a circle.
const MOST_FILES: usize = 3;

type Module = Vec<String>;

/// The module of a file, as the names on its path.
fn module(root: &Path, path: &Path) -> Module {
    let names = path.strip_prefix(root).unwrap().with_extension("");
    let mut names: Module = names.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    names.pop_if(|last| last == "mod" || last == "lib");
    names
}

/// The paths of a tree of imports, as `a::{b, c::{d}}`.
fn leaves(prefix: &str, tree: &str, found: &mut Vec<String>) {
    let Some((head, rest)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        return found.push(format!("{prefix}{path}"));
    };
    let (inner, mut depth, mut from) = (&rest[..rest.rfind('}').unwrap()], 0, 0);
    for (at, c) in inner.char_indices().chain([(inner.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let part = inner[from..at].trim();
                if !part.is_empty() {
                    leaves(&format!("{prefix}{head}"), part, found);
                }
                from = at + 1;
            }
            _ => {}
        }
    }
}

/// The paths within this crate that some code names, in imports and elsewhere.
fn named(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    let words = code.split_whitespace().collect::<Vec<_>>().join(" ");
    for start in ["crate::", "super::"] {
        for (at, _) in words.match_indices(start) {
            let before = &words[..at];
            // Inner parts of a longer path, as in `super::super::`.
            if before.ends_with("::") {
                continue;
            }
            let imported = before.ends_with("use ");
            let part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
            let end = match imported {
                true => words[at..].find(';'),
                false => words[at..].find(|c| !part(c)),
            };
            leaves("", &words[at..at + end.unwrap_or(words.len() - at)], &mut found);
        }
    }
    found
}

/// The file in which a path of a module is.
fn target(from: &Module, path: &str, all: &BTreeSet<Module>) -> Option<Module> {
    let mut names: Module = Vec::new();
    for (nth, name) in path.split("::").map(str::trim).enumerate() {
        match (name, nth) {
            ("crate", 0) => {}
            ("super", 0) => names.extend_from_slice(from.split_last()?.1),
            ("super", _) => drop(names.pop()),
            _ => names.push(name.to_owned()),
        }
    }
    (0..=names.len()).rev().map(|count| names[..count].to_vec()).find(|module| all.contains(module))
}

fn reachable<'a>(from: &'a Module, uses: &'a BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<&'a Module> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(next) = open.pop() {
        for to in &uses[next] {
            if found.insert(to) {
                open.push(to);
            }
        }
    }
    found
}

#[test]
fn no_circle_of_imports_has_more_than_three_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let all: BTreeSet<Module> = files.iter().map(|path| module(&root, path)).collect();
    let mut uses: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for path in &files {
        let own = module(&root, path);
        let named = named(&code(path)).into_iter().filter_map(|path| target(&own, &path, &all));
        // The crate's face names everything.
        let named = named.filter(|to| *to != own && !to.is_empty()).collect();
        uses.insert(own, named);
    }
    assert!(uses.values().map(BTreeSet::len).sum::<usize>() > 1_000, "imports were not found");
    let reached: BTreeMap<&Module, BTreeSet<&Module>> = all.iter().map(|own| (own, reachable(own, &uses))).collect();
    for own in &all {
        let circle: Vec<_> = reached[own].iter().filter(|other| reached[**other].contains(own)).collect();
        assert!(circle.len() <= MOST_FILES, "files that use each other: {circle:?}");
    }
}

#[test]
fn trees_of_imports_are_read() {
    let text = "use crate::a::{b::C, d::{E as F, g}};\nuse super::super::h;\nfn f() { crate::i::j(super::k::L) }";
    let mut found = named(text);
    found.sort();
    assert_eq!(
        found,
        ["crate::a::b::C", "crate::a::d::E", "crate::a::d::g", "crate::i::j", "super::k::L", "super::super::h"]
    );
}
