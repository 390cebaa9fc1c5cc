//! Arrays larger than one binding: the buffer stays whole and is bound in banks of equal size, and the kernel's source
//! is rewritten so that an index finds its bank.
//!
//! WebGPU promises bindings of 128 MiB only, while buffers may be larger. No kernel is written for banks: `jacobian[i]`
//! becomes `jacobian_at(i)`, `jacobian[i] = x;` becomes `jacobian_store(i, x);`, and naga validates what comes out.
//! Arrays of atomics are left as they are, so that the rewritten source of one that needs banks is refused.

use std::fmt::Write as _;

/// An array of a source that is bound in several banks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Banked {
    /// Its name.
    pub name: String,
    /// How many banks there are.
    pub banks: u32,
    /// Elements of one.
    pub elements: u64,
    /// Whether it is written.
    pub writable: bool,
}

/// A storage array as it is declared.
struct Declaration<'a> {
    head: &'a str,
    name: &'a str,
    kind: &'a str,
}

/// The source with `arrays` in banks; all storage arrays are numbered from `first` in the order of `names`.
pub(super) fn rewrite(source: &str, first: u32, names: &[String], arrays: &[Banked]) -> String {
    let mut out = String::with_capacity(2 * source.len());
    let mut rest = source;
    while let Some((before, declaration, after)) = next_declaration(rest) {
        out.push_str(&uses(before, arrays));
        declare(&mut out, &declaration, first, names, arrays);
        rest = after;
    }
    out.push_str(&uses(rest, arrays));
    out
}

/// The next `@group(0) @binding(..) var<storage, ..> name: type;`, what is before it, and what is after it.
fn next_declaration(source: &str) -> Option<(&str, Declaration<'_>, &str)> {
    let storage = source.find("var<storage")?;
    let begin = source[..storage].rfind("@group")?;
    let head_end = storage + source[storage..].find('>')? + 1;
    let end = head_end + source[head_end..].find(';')?;
    let (name, kind) = source[head_end..end].split_once(':')?;
    let declaration = Declaration { head: &source[storage..head_end], name: name.trim(), kind: kind.trim() };
    Some((&source[..begin], declaration, &source[end + 1..]))
}

fn declare(out: &mut String, declaration: &Declaration<'_>, first: u32, names: &[String], arrays: &[Banked]) {
    let Declaration { head, name, kind } = declaration;
    let banks = |of: &str| arrays.iter().find(|array| array.name == of).map_or(1, |array| array.banks);
    let number = first + names.iter().take_while(|other| other != name).map(|other| banks(other)).sum::<u32>();
    let Some(array) = arrays.iter().find(|array| array.name == *name) else {
        let _ = write!(out, "@group(0) @binding({number}) {head} {name}: {kind};");
        return;
    };
    for bank in 0..array.banks {
        let _ = writeln!(out, "@group(0) @binding({}) {head} {name}_{bank}: {kind};", number + bank);
    }
    let element = kind.strip_prefix("array<").and_then(|kind| kind.strip_suffix('>')).unwrap_or(kind);
    let cases = |body: &dyn Fn(u32) -> String| {
        (0..array.banks).fold(String::new(), |mut text, bank| {
            let label = if bank + 1 == array.banks { "default".into() } else { format!("case {bank}u") };
            let _ = write!(text, " {label}: {{ {} }}", body(bank));
            text
        })
    };
    let size = array.elements;
    let place = |bank: u32| format!("{name}_{bank}[i - {}u]", u64::from(bank) * size);
    let load = cases(&|bank| format!("return {};", place(bank)));
    let _ = writeln!(out, "fn {name}_at(i: u32) -> {element} {{ switch i / {size}u {{{load} }} }}");
    if array.writable {
        let store = cases(&|bank| format!("{} = x;", place(bank)));
        let _ = writeln!(out, "fn {name}_store(i: u32, x: {element}) {{ switch i / {size}u {{{store} }} }}");
    }
}

fn is_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The text with every use of the arrays rewritten.
fn uses(text: &str, arrays: &[Banked]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    while let Some((array, begin, open)) = next_use(text, at, arrays) {
        out.push_str(&text[at..begin]);
        let Some(close) = matching(text, open) else { break };
        let name = &array.name;
        let index = uses(&text[open + 1..close], arrays);
        match assignment(&text[close + 1..]) {
            Some(Assignment { member, operator, value, length }) => {
                let value = uses(value, arrays);
                let old = format!("{name}_at({index})");
                match (member, operator) {
                    ("", "") => drop(write!(out, "{name}_store({index}, {value});")),
                    ("", operator) => drop(write!(out, "{name}_store({index}, {old} {operator} ({value}));")),
                    (member, operator) => {
                        let value =
                            if operator.is_empty() { value } else { format!("held.{member} {operator} ({value})") };
                        let _ = write!(
                            out,
                            "{{ var held = {old}; held.{member} = {value}; {name}_store({index}, held); }}"
                        );
                    }
                }
                at = close + 1 + length;
            }
            None => {
                let _ = write!(out, "{name}_at({index})");
                at = close + 1;
            }
        }
    }
    out.push_str(&text[at..]);
    out
}

/// The next `name[` of an array: where the name begins and where the bracket is.
fn next_use<'a>(text: &str, from: usize, arrays: &'a [Banked]) -> Option<(&'a Banked, usize, usize)> {
    let found = arrays.iter().filter_map(|array| {
        let mut at = from;
        loop {
            let begin = at + text[at..].find(array.name.as_str())?;
            let end = begin + array.name.len();
            let bytes = text.as_bytes();
            let alone = begin == 0 || !(is_name(bytes[begin - 1]) || bytes[begin - 1] == b'.');
            if alone && bytes.get(end) == Some(&b'[') {
                return Some((array, begin, end));
            }
            at = end;
        }
    });
    found.min_by_key(|(_, begin, _)| *begin)
}

/// The bracket that closes the one at `open`.
fn matching(text: &str, open: usize) -> Option<usize> {
    let mut depth = 0usize;
    for (at, byte) in text.bytes().enumerate().skip(open) {
        match byte {
            b'[' => depth += 1,
            b']' => {
                depth -= 1;
                if depth == 0 {
                    return Some(at);
                }
            }
            _ => {}
        }
    }
    None
}

struct Assignment<'a> {
    member: &'a str,
    operator: &'a str,
    value: &'a str,
    /// Bytes up to and with the semicolon.
    length: usize,
}

/// What follows a place, if it is written: `.member op= value;`.
fn assignment(text: &str) -> Option<Assignment<'_>> {
    let mut rest = text;
    let mut member = "";
    if let Some(after) = rest.strip_prefix('.') {
        let end = after.bytes().position(|b| !is_name(b))?;
        (member, rest) = after.split_at(end);
    }
    rest = rest.trim_start();
    let operator_end = rest.find('=')?;
    let operator = &rest[..operator_end];
    if !matches!(operator, "" | "+" | "-" | "*" | "/" | "|" | "&") || rest[operator_end + 1..].starts_with('=') {
        return None;
    }
    let end = rest.find(';')?;
    let value = rest[operator_end + 1..end].trim();
    Some(Assignment { member, operator, value, length: text.len() - rest.len() + end + 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "@group(0) @binding(0) var<uniform> n: u32;
@group(0) @binding(1) var<storage, read> list: array<u32>;
const PLACE: u32 = 2u;
@group(0) @binding(PLACE) var<storage, read_write> out: array<vec4<f32>>;
@compute @workgroup_size(1) fn main() {
    out[list[list[3]] + n] = vec4<f32>(f32(list[1]));
    out[n].w = 2.0 * out[2].x;
    out[n + 1u] += out[n];
    if list[2] == 3u { out[1].y *= 2.0; }
}
";

    fn banked(name: &str, banks: u32, writable: bool) -> Banked {
        Banked { name: name.into(), banks, elements: 64, writable }
    }

    fn valid(source: &str) {
        let module = naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    }

    #[test]
    fn every_use_is_rewritten_and_the_source_is_valid() {
        let names = ["list".to_owned(), "out".to_owned()];
        let text = rewrite(SOURCE, 1, &names, &[banked("list", 3, false), banked("out", 2, true)]);
        valid(&text);
        assert!(text.contains("out_store(list_at(list_at(3)) + n, vec4<f32>(f32(list_at(1))));"), "{text}");
        assert!(
            text.contains("held.w = 2.0 * out_at(2).x;")
                && text.contains("out_store(n + 1u, out_at(n + 1u) + (out_at(n)));")
        );
        assert!(text.contains("if list_at(2) == 3u {") && text.contains("held.y = held.y * (2.0);"));
        assert!(
            text.contains("@binding(3) var<storage, read> list_2")
                && text.contains("@binding(5) var<storage, read_write> out_1")
        );
    }

    #[test]
    fn arrays_in_one_bank_are_only_renumbered() {
        let names = ["list".to_owned(), "out".to_owned()];
        let text = rewrite(SOURCE, 1, &names, &[banked("list", 4, false)]);
        valid(&text);
        assert!(
            text.contains("@binding(5) var<storage, read_write> out:") && text.contains("out[n].w = 2.0 * out[2].x;")
        );
    }
}
