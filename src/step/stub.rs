//! The stub of a step's report in Python, made of the figures: a test that the package has it.

use super::{step_figures, step_phases};
use std::fs;

/// Where a line of a stub ends at the latest.
const WIDEST: usize = 120;

/// An attribute of the report: its name, its type as Rust has it, its doc.
type Attribute = (&'static str, &'static str, &'static str);

macro_rules! attributes {
    ($($(#[doc = $doc:literal])* $name:ident: $type:ty = $before:expr, $joins:ident, $elsewhere:tt;)*) => {
        const FIGURES: &[Attribute] = &[$((stringify!($name), stringify!($type), concat!($($doc),*)),)*];
    };
}

macro_rules! seconds {
    ($($(#[doc = $doc:literal])* $name:ident, $label:literal;)*) => {
        const SECONDS: &[Attribute] = &[$((concat!(stringify!($name), "_seconds"), "f64", concat!($($doc),*)),)*];
    };
}

step_figures!(attributes);
step_phases!(seconds);

fn in_python(of: &str) -> &'static str {
    // How many blanks there are is up to the compiler.
    match of.replace(' ', "").as_str() {
        "bool" => "bool",
        "u32" | "u64" | "usize" | "Option<Passed>" => "int",
        "f64" => "float",
        "Option<f64>" => "Optional[float]",
        "Option<usize>" => "Optional[int]",
        "Option<[usize;2]>" => "Optional[tuple[int, int]]",
        "Status" => "_Status",
        other => panic!("say here how Python has {other}"),
    }
}

/// The doc as a string, in lines that are not too wide.
fn docstring(doc: &str) -> String {
    let mut lines = vec![String::from("        \"\"\"")];
    for word in format!("{}\"\"\"", doc.trim()).split_whitespace() {
        let line = lines.last_mut().unwrap();
        if line.len() + 1 + word.len() > WIDEST {
            lines.push(format!("        {word}"));
        } else {
            let gap = if line.ends_with(['"', ' ']) { "" } else { " " };
            *line += &format!("{gap}{word}");
        }
    }
    lines.join("\n")
}

#[test]
fn the_stubs_of_python_have_the_figures_of_a_report() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/python/relcp/__init__.pyi");
    let stubs = fs::read_to_string(path).unwrap().replace("\r\n", "\n");
    let (before, rest) = stubs.split_once("class StepReport:\n").unwrap();
    let (_, after) = rest.split_once("    def to_dict").unwrap();
    let more: [Attribute; 2] = [
        ("passed_pair", "Option<[usize; 2]>", "The first pair that went through each other, where there is one."),
        ("wall_seconds", "f64", "Wall time of the step."),
    ];
    let attributes = FIGURES.iter().chain(&more).chain(SECONDS).map(|(name, of, doc)| {
        format!("    @property\n    def {name}(self) -> {}:\n{}\n\n", in_python(of), docstring(doc))
    });
    let head = "    \"\"\"What one step did; lengths in the scene's unit, wall times in seconds.\"\"\"\n\n";
    let class = format!("class StepReport:\n{head}{}", attributes.collect::<String>());
    let told = format!("{before}{class}    def to_dict{after}");
    if std::env::var_os("RELCP_WRITE_STUBS").is_some() {
        fs::write(path, &told).unwrap();
    }
    assert!(stubs == told, "RELCP_WRITE_STUBS=1 cargo test --lib stubs writes those of {path}");
}
