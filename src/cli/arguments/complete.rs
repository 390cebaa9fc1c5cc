//! Completions that a shell offers for an argument: names of built-in scenes, files and folders.

use clap_complete::engine::{ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter};
use relcp::scene::BuiltIn;
use std::ffi::OsStr;

/// A scene: a built-in one by its name, or a file.
pub(super) fn scene() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| names_and(typed, &PathCompleter::file()))
}

/// A run or a scene: a built-in scene, a file or a folder.
pub(super) fn run() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| names_and(typed, &PathCompleter::any()))
}

/// A built-in scene by its name.
pub(super) fn built_in() -> ArgValueCompleter {
    ArgValueCompleter::new(names)
}

fn names_and(typed: &OsStr, paths: &PathCompleter) -> Vec<CompletionCandidate> {
    let mut found = names(typed);
    found.extend(paths.complete(typed));
    found
}

fn names(typed: &OsStr) -> Vec<CompletionCandidate> {
    let typed = typed.as_encoded_bytes();
    let fits = BuiltIn::ALL.iter().filter(|scene| scene.name.as_bytes().starts_with(typed));
    fits.map(|scene| CompletionCandidate::new(scene.name).help(Some(scene.summary.into()))).collect()
}
