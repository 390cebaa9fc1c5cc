//! Assembles the source of a kernel: the number type, constants of the scene, and fragments of `shaders/`.

use super::Precision;
use super::function::{Part, declared};
use std::fmt::Write as _;

/// Invocations of a workgroup, unless a kernel sets another size. 64 to 256 were equally fast for the product with A.
pub const WORKGROUP: u32 = 128;

/// The same for kernels with independent invocations on a software adapter, which executes whole workgroups vector by
/// vector: in a larger workgroup most vectors are idle if a member of an ensemble has 20 bodies.
const WORKGROUP_ON_SOFTWARE: u32 = 16;

/// A piece of WGSL.
#[derive(Clone, Copy, Debug)]
pub struct Fragment {
    /// Its path in `shaders/`.
    pub name: &'static str,
    /// The text.
    pub text: &'static str,
}

/// Functions of a fragment that a scene replaces: each is renamed to `NAME_of_others`, and the other fragment, which is
/// added after it, has a function of its name.
#[derive(Clone, Copy, Debug)]
pub struct Extension {
    /// The path of the fragment.
    pub of: &'static str,
    /// The functions.
    pub functions: &'static [&'static str],
    /// The fragment with their replacements.
    pub with: Fragment,
}

/// The source of one kernel. Its entry point is `main`, its workgroup `WORKGROUP` invocations.
#[derive(Clone, Debug)]
pub struct Source {
    name: String,
    text: String,
    fragments: Vec<&'static str>,
    extensions: &'static [Extension],
    groups: Vec<(&'static str, Vec<&'static str>)>,
    precision: Precision,
    workgroup: u32,
    arguments: Vec<Part>,
}

const REAL_F32: &str = "alias real = f32;
alias vec2r = vec2<f32>;
alias vec3r = vec3<f32>;
alias vec4r = vec4<f32>;
alias mat3r = mat3x3<f32>;
const EPSILON: real = 1.1920929e-7;
const HUGE: real = 3e38;
const TINY: real = 1.1754944e-38;
";

const REAL_F64: &str = "alias real = f64;
alias vec2r = vec2<f64>;
alias vec3r = vec3<f64>;
alias vec4r = vec4<f64>;
alias mat3r = mat3x3<f64>;
const EPSILON: real = 2.220446049250313e-16lf;
const HUGE: real = 1e300lf;
const TINY: real = 2.2250738585072014e-308lf;
";

impl Source {
    /// A source with the number type and the definitions that all kernels share.
    pub fn new(name: impl Into<String>, precision: Precision) -> Self {
        Source::with_workgroup(name, precision, WORKGROUP)
    }

    /// The same for workgroups of another size.
    pub fn with_workgroup(name: impl Into<String>, precision: Precision, workgroup: u32) -> Self {
        let mut source = Source {
            name: name.into(),
            text: String::new(),
            fragments: Vec::new(),
            extensions: &[],
            groups: Vec::new(),
            precision,
            workgroup,
            arguments: Vec::new(),
        };
        source.text.push_str(match precision {
            Precision::F32 => REAL_F32,
            Precision::F64 => REAL_F64,
        });
        source.integer("WORKGROUP", workgroup).include(super::fragment!("common/invocation.wgsl"))
    }

    /// The same with smaller workgroups, for kernels that do not depend on the size: an invocation gets its index only
    /// from `invocation`, and only that function, the constant and the entry point use the size. Invocations do not
    /// synchronize.
    pub(super) fn on_software(&self) -> Option<Source> {
        let meets = ["var<workgroup>", "Barrier"].iter().any(|word| self.text.contains(word));
        let count = |words: &str| self.text.matches(words).count();
        // Each name occurs once in its definition.
        let by_place = count(" invocation(") > 1 && count(" group_index(") == 1;
        let separate = !meets && by_place && count("WORKGROUP") == 3;
        let of = |workgroup| format!("const WORKGROUP: u32 = {workgroup}u;");
        let smaller = |text: &str| text.replace(&of(self.workgroup), &of(WORKGROUP_ON_SOFTWARE));
        (separate && self.workgroup > WORKGROUP_ON_SOFTWARE)
            .then(|| Source { workgroup: WORKGROUP_ON_SOFTWARE, ..self.clone().mapped(smaller) })
    }

    /// Adds a constant of type `u32`.
    #[must_use]
    pub fn integer(mut self, name: &str, value: u32) -> Self {
        let _ = writeln!(self.text, "const {name}: u32 = {value}u;");
        self
    }

    /// Adds a group of constants of type `u32`, once. Tests require that a `switch` with a case for one of them has
    /// cases for all.
    #[must_use]
    pub fn constants(mut self, name: &'static str, constants: impl IntoIterator<Item = (&'static str, u32)>) -> Self {
        if self.fragments.contains(&name) {
            return self;
        }
        self.fragments.push(name);
        let constants: Vec<_> = constants.into_iter().collect();
        self.groups.push((name, constants.iter().map(|(constant, _)| *constant).collect()));
        constants.into_iter().fold(self, |source, (constant, value)| source.integer(constant, value))
    }

    /// The groups of constants, by name.
    #[cfg(test)]
    pub(super) fn groups(&self) -> &[(&'static str, Vec<&'static str>)] {
        &self.groups
    }

    /// Sets the arguments of the kernel, and declares its parameters.
    #[must_use]
    pub fn called_with(mut self, arguments: Vec<Part>) -> Self {
        self.text += &declared(&self.text, &arguments);
        Source { arguments, ..self }
    }

    /// The arguments of the kernel.
    pub(super) fn arguments(&self) -> &[Part] {
        &self.arguments
    }

    /// Adds a constant of type `bool`.
    #[must_use]
    pub fn flag(mut self, name: &str, value: bool) -> Self {
        let _ = writeln!(self.text, "const {name}: bool = {value};");
        self
    }

    /// Adds a constant of type `real`.
    #[must_use]
    pub fn real(mut self, name: &str, value: f64) -> Self {
        let literal = self.literal(value);
        let _ = writeln!(self.text, "const {name}: real = {literal};");
        self
    }

    /// Adds a constant of type `vec3r`.
    #[must_use]
    pub fn vector(mut self, name: &str, value: [f64; 3]) -> Self {
        let [x, y, z] = value.map(|v| self.literal(v));
        let _ = writeln!(self.text, "const {name}: vec3r = vec3r({x}, {y}, {z});");
        self
    }

    /// A literal of type `real`.
    pub fn literal(&self, value: f64) -> String {
        match self.precision {
            // A literal that overflows is not valid WGSL; one that underflows is zero.
            Precision::F32 => format!("{:e}f", value.clamp(-3e38, 3e38) as f32),
            Precision::F64 => format!("{value:e}lf"),
        }
    }

    /// Changes the text.
    #[must_use]
    pub fn mapped(mut self, change: impl FnOnce(&str) -> String) -> Self {
        self.text = change(&self.text);
        self
    }

    /// Adds a fragment, once.
    #[must_use]
    pub fn include(mut self, fragment: Fragment) -> Self {
        if !self.fragments.contains(&fragment.name) {
            self.fragments.push(fragment.name);
            return match self.extensions.iter().find(|extension| extension.of == fragment.name) {
                Some(extension) => {
                    let rename = |text: String, name: &&str| {
                        debug_assert_eq!(text.matches(&format!("fn {name}(")).count(), 1, "{name}");
                        text.replace(&format!("fn {name}("), &format!("fn {name}_of_others("))
                    };
                    let text = extension.functions.iter().fold(fragment.text.to_owned(), rename);
                    self.text(&text).text("\n").include(extension.with)
                }
                None => self.text(fragment.text).text("\n"),
            };
        }
        self
    }

    /// Replaces functions of fragments that are added later.
    #[must_use]
    pub fn extended(self, extensions: &'static [Extension]) -> Self {
        Source { extensions, ..self }
    }

    /// Adds generated text.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.text.push_str(text);
        self
    }

    /// The kernel's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The whole text.
    pub fn code(&self) -> &str {
        &self.text
    }

    /// The number type.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// Invocations of a workgroup.
    pub fn workgroup(&self) -> u32 {
        self.workgroup
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(body: &str) -> Source {
        let begin = "@compute @workgroup_size(WORKGROUP) fn main(@builtin(workgroup_id) group: vec3<u32>, \
                     @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {";
        Source::new("test", Precision::F32).text(&format!("{begin} {body} }}"))
    }

    #[test]
    fn only_kernels_of_separate_invocations_take_smaller_workgroups() {
        let smaller = source("let i = invocation(group, groups, local);").on_software().unwrap();
        assert_eq!(smaller.workgroup(), WORKGROUP_ON_SOFTWARE);
        assert!(smaller.code().contains("const WORKGROUP: u32 = 16u;"));
        for body in [
            "let i = local;",
            "let i = invocation(group, groups, local); workgroupBarrier();",
            "let i = invocation(group, groups, local) / WORKGROUP;",
            "let i = invocation(group, groups, local); let g = group_index(group, groups);",
        ] {
            assert!(source(body).on_software().is_none(), "{body}");
        }
    }
}
