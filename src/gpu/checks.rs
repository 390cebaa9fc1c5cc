//! Checks of assembled kernels, for tests. The kernels are valid on every adapter and take the arguments of their
//! calls. Every `switch` on a group of constants ([`Source::constants`]) handles all of them, and treats no other
//! number as one of them.

use super::function::Plan;
use super::{Source, kernel};

/// A `switch` of a kernel: the labels of its cases, and the code of its default.
struct Switch {
    labels: Vec<String>,
    default: String,
}

/// Parses and validates a source, alone and merged for an ensemble, and checks its arguments and its switches.
pub(crate) fn validate(source: &Source) -> Result<naga::Module, String> {
    let module = kernel::validate(source)?;
    check_merged(source, &module)?;
    if !source.arguments().is_empty() {
        Plan::of(&module, source.arguments())?;
    }
    for switch in switches(source.code()) {
        for (name, group) in source.groups() {
            let has = |constant: &str| switch.labels.iter().any(|label| label == constant);
            if !group.iter().any(|constant| has(constant)) {
                continue;
            }
            if let Some(missing) = group.iter().find(|constant| !has(constant)) {
                return Err(format!("a switch on {name} has no case for {missing}: {:?}", switch.labels));
            }
            if !["not_a_number()", "return 0u;"].iter().any(|error| switch.default.contains(error)) {
                return Err(format!("a switch on {name} takes an unknown number for a known one: {}", switch.default));
            }
        }
    }
    Ok(module)
}

/// A kernel that has parameters or arrays can serve the members of an ensemble.
fn check_merged(source: &Source, module: &naga::Module) -> Result<(), String> {
    // The texts of some tests have no entry point.
    if module.entry_points.is_empty() {
        return Ok(());
    }
    let info = kernel::check(module, source.precision(), source.code())?;
    let merged = super::ensemble::merged(module, &info)?;
    kernel::check(&merged.module, source.precision(), "").map(|_| ())
}

/// The text in the braces that begin at `open`.
fn block(text: &str, open: usize) -> &str {
    let mut depth = 0;
    for (at, byte) in text.bytes().enumerate().skip(open) {
        match byte {
            b'{' => depth += 1,
            b'}' if depth == 1 => return &text[open + 1..at],
            b'}' => depth -= 1,
            _ => {}
        }
    }
    &text[open..]
}

fn switches(code: &str) -> Vec<Switch> {
    let text: String = code.lines().map(|line| line.split("//").next().unwrap_or("").to_owned() + "\n").collect();
    let begins = text.match_indices("switch ").map(|(at, _)| at);
    begins.filter_map(|at| Some(of_arms(block(&text, at + text[at..].find('{')?)))).collect()
}

fn of_arms(arms: &str) -> Switch {
    let (mut labels, mut default) = (Vec::new(), String::new());
    let mut rest = arms;
    while let Some(open) = rest.find('{') {
        let body = block(rest, open);
        let own = rest[..open].replace("case ", "").replace(':', "");
        for label in own.split(',').map(str::trim) {
            if label == "default" {
                default = body.to_owned();
            }
            labels.push(label.to_owned());
        }
        rest = &rest[open + body.len() + 2..];
    }
    Switch { labels, default }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Precision;

    fn check(arms: &str) -> Result<naga::Module, String> {
        let kinds = [("APPLE", 0), ("PEAR", 1)];
        let text = format!("fn weight(kind: u32) -> real {{\n switch kind {{ {arms} }}\n}}\n");
        validate(&Source::new("fruit", Precision::F32).constants("kinds of fruit", kinds).text(&text))
    }

    #[test]
    fn a_switch_that_forgets_a_constant_or_hides_an_unknown_one_is_refused() {
        check("case APPLE: { return 1.0; } case PEAR: { return 2.0; } default: { return not_a_number(); }").unwrap();
        let forgotten = check("case APPLE: { return 1.0; } default: { return not_a_number(); }").unwrap_err();
        assert!(forgotten.contains("no case for PEAR"), "{forgotten}");
        let hidden = check("case APPLE: { return 1.0; } case PEAR, default: { return 2.0; }").unwrap_err();
        assert!(hidden.contains("unknown number"), "{hidden}");
    }
}
