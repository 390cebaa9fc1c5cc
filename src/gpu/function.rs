//! Kernels that are called like functions, with a struct of their arguments (`functions!`).
//!
//! A kernel's WGSL declares its arrays and reads members of `parameters`; the declaration of `parameters` follows from
//! the arguments ([`declared`]). Each array or member is an argument of that name, or a part of one, such as the cells
//! of poses; a kernel takes only the parts that it names. Names are resolved once, when the kernel is created. A call
//! copies values to their offsets and binds arrays to their bindings.

use super::kernel::bindings;
use super::recorder::Size;
use super::{Buffer, Gpu, GpuError, Kernel, Recorder, Source};
use naga::{Module, TypeInner};
use std::ops::Range;

/// An argument of a kernel.
pub trait Argument {
    /// The arrays and values in the argument.
    fn parts() -> Vec<Part>
    where
        Self: Sized;

    /// The nth part, if it is an array.
    fn array(&self, _nth: usize) -> Option<&Buffer> {
        None
    }

    /// Writes the nth part, if it is a value.
    fn write(&self, _nth: usize, _to: Member<'_>) {}
}

/// An array or a value in an argument.
#[derive(Clone, Debug)]
pub struct Part {
    /// The name of the part; empty if the part is the whole argument.
    name: &'static str,
    /// The name of the argument followed by that of the part, since several arguments may have cells.
    full: String,
    /// The WGSL type of a value; empty for an array.
    value: &'static str,
    nth: usize,
    /// Whether it is a whole argument, which the kernel must take.
    whole: bool,
}

/// Parts with these names: values of WGSL types, or arrays if the type is empty.
pub fn parts(of: &[(&'static str, &'static str)]) -> Vec<Part> {
    let part = |(nth, (name, value)): (usize, &(&'static str, &'static str))| Part {
        name,
        full: String::new(),
        value,
        nth,
        whole: false,
    };
    of.iter().enumerate().map(part).collect()
}

/// The largest number of fields of a struct of arguments.
pub const MOST_FIELDS: usize = 32;

/// The parts of a struct of arguments.
pub fn joined(fields: Vec<(&'static str, Vec<Part>)>) -> Vec<Part> {
    let mut all = Vec::new();
    for (field, (argument, parts)) in fields.into_iter().enumerate() {
        for part in parts {
            let (full, whole) = match (part.full.is_empty(), part.name) {
                (true, "") => (argument.to_owned(), true),
                (true, name) => (format!("{argument}_{name}"), false),
                (false, _) => (part.full, false),
            };
            all.push(Part { full, whole, nth: field + MOST_FIELDS * part.nth, ..part });
        }
    }
    all
}

/// The part with this name in a kernel.
fn find<'p>(parts: &'p [Part], name: &str, is_value: bool) -> Result<&'p Part, String> {
    let of_kind = || parts.iter().filter(|part| part.value.is_empty() != is_value);
    let found = of_kind().find(|part| part.full == name).or_else(|| of_kind().find(|part| part.name == name));
    found.ok_or(format!("{name} is no argument"))
}

/// The declaration of the `parameters` that a kernel's text reads; empty if it reads none, or declares them itself.
pub(super) fn declared(text: &str, parts: &[Part]) -> String {
    let mut members: Vec<String> = Vec::new();
    for read in text.split("parameters.").skip(1).filter(|_| !text.contains("var<uniform>")) {
        let name = &read[..read.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(read.len())];
        let Ok(part) = find(parts, name, true) else { continue };
        let member = format!("{name}: {}", part.value);
        if !members.contains(&member) {
            members.push(member);
        }
    }
    match members.is_empty() {
        true => String::new(),
        false => format!("struct Parameters {{ {} }}\nvar<uniform> parameters: Parameters;\n", members.join(", ")),
    }
}

/// A value among the parameters: its bytes, and the size of each of its numbers.
pub struct Member<'p> {
    bytes: &'p mut [u8],
    width: usize,
}

impl Member<'_> {
    /// Writes integers, as many as fit.
    pub fn words(self, words: &[u32]) {
        self.bytes.copy_from_slice(&bytemuck::cast_slice(words)[..self.bytes.len()]);
    }

    /// Writes numbers, rounded to the kernel's type.
    pub fn reals(self, numbers: &[f64]) {
        for (place, number) in self.bytes.chunks_exact_mut(self.width).zip(numbers) {
            match self.width {
                4 => place.copy_from_slice(&(*number as f32).to_le_bytes()),
                _ => place.copy_from_slice(&number.to_le_bytes()),
            }
        }
    }
}

impl Argument for Buffer {
    fn parts() -> Vec<Part> {
        parts(&[("", "")])
    }

    fn array(&self, _: usize) -> Option<&Buffer> {
        Some(self)
    }
}

impl<T: Argument> Argument for &T {
    fn parts() -> Vec<Part> {
        T::parts()
    }

    fn array(&self, nth: usize) -> Option<&Buffer> {
        (**self).array(nth)
    }

    fn write(&self, nth: usize, to: Member<'_>) {
        (**self).write(nth, to);
    }
}

macro_rules! value {
    ($($Of:ty: $wgsl:literal = $write:ident($value:expr);)*) => {$(
        impl Argument for $Of {
            fn parts() -> Vec<Part> {
                parts(&[("", $wgsl)])
            }

            fn write(&self, _: usize, to: Member<'_>) {
                let write: fn(&$Of) -> _ = $value;
                to.$write(&write(self));
            }
        }
    )*};
}
value! {
    u32: "u32" = words(|word| [*word]);
    u64: "u32" = words(|count| [*count as u32]);
    usize: "u32" = words(|count| [*count as u32]);
    bool: "u32" = words(|flag| [u32::from(*flag)]);
    f32: "f32" = reals(|number| [f64::from(*number)]);
    f64: "real" = reals(|number| [*number]);
    [u32; 8]: "array<vec4<u32>, 2>" = words(|words| *words);
    [u32; 16]: "array<vec4<u32>, 4>" = words(|words| *words);
}

/// The bindings and offsets of the arguments.
#[derive(Default)]
pub(super) struct Plan {
    /// The size of the parameters in bytes.
    bytes: usize,
    /// For each member of the parameters: its part, its bytes, and the size of each number in it.
    members: Vec<(usize, Range<usize>, usize)>,
    /// The part of each array, in the order of bindings.
    arrays: Vec<usize>,
}

/// The size in bytes of each number in a type.
fn width(module: &Module, inner: &TypeInner) -> usize {
    match inner {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => scalar.width.into(),
        TypeInner::Array { base, .. } => width(module, &module.types[*base].inner),
        _ => 0,
    }
}

impl Plan {
    /// The plan of a validated kernel.
    ///
    /// # Errors
    /// The name that occurs only in the kernel or only among the arguments.
    pub fn of(module: &Module, parts: &[Part]) -> Result<Plan, String> {
        let mut plan = Plan::default();
        for binding in bindings(module)? {
            if !binding.uniform {
                plan.arrays.push(find(parts, &binding.name, false)?.nth);
                continue;
            }
            let TypeInner::Struct { members, span } = &module.types[binding.ty].inner else {
                return Err("its parameters are no struct".into());
            };
            plan.bytes = *span as usize;
            for member in members {
                let part = find(parts, member.name.as_deref().unwrap_or_default(), true)?;
                let (inner, begin) = (&module.types[member.ty].inner, member.offset as usize);
                let bytes = begin..begin + inner.size(module.to_ctx()) as usize;
                plan.members.push((part.nth, bytes, width(module, inner)));
            }
        }
        let taken = |part: &Part| match part.value {
            "" => plan.arrays.contains(&part.nth),
            _ => plan.members.iter().any(|(nth, ..)| *nth == part.nth),
        };
        match parts.iter().find(|part| part.whole && !taken(part)) {
            Some(part) => Err(format!("it takes no {}", part.full)),
            None => Ok(plan),
        }
    }

    fn encode(&self, arguments: &dyn Argument) -> Vec<u8> {
        let mut bytes = vec![0; self.bytes];
        for (nth, range, width) in &self.members {
            arguments.write(*nth, Member { bytes: &mut bytes[range.clone()], width: *width });
        }
        bytes
    }
}

/// A kernel with the plan of its arguments.
pub struct Function {
    kernel: Kernel,
    plan: Plan,
}

impl Function {
    /// Compiles a source with declared arguments.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] with the position in the source, or with a name that is not an argument.
    pub fn new(gpu: &Gpu, source: &Source) -> Result<Self, GpuError> {
        let kernel = Kernel::new(gpu, source)?;
        let refused = |message| GpuError::Kernel { kernel: source.name().to_owned(), message };
        let plan = Plan::of(kernel.module(), source.arguments()).map_err(refused)?;
        Ok(Function { kernel, plan })
    }

    /// Records a call.
    pub fn call(&self, record: &mut Recorder<'_>, size: Size<'_>, arguments: &dyn Argument) {
        let buffers: Vec<&Buffer> = self.plan.arrays.iter().filter_map(|nth| arguments.array(*nth)).collect();
        record.run(&self.kernel, &self.plan.encode(arguments), &buffers, size);
    }
}

/// Declares kernels with the structs of their arguments:
///
/// ```ignore
/// functions! {
///     /// Sets the motions of fixed bodies to zero.
///     pub(super) Hold = struct HoldArgs<'a> { bodies: u64, is_fixed: &'a Buffer, motions: &'a Motions }
/// }
///
/// hold.call(record, bodies, HoldArgs { bodies, is_fixed: &self.flags, motions });
/// ```
macro_rules! functions {
    ($(
        $(#[$doc:meta])*
        $visible:vis $Kernel:ident = struct $Args:ident<$life:lifetime> { $($field:ident: $T:ty),* $(,)? }
    )*) => {$(
        $(#[$doc])*
        $visible struct $Kernel($crate::gpu::Function);

        $crate::gpu::arguments! {
            $visible struct $Args<$life> { $($field: $T,)* }
        }

        impl $Kernel {
            /// Records a call with this many invocations.
            $visible fn call<'s>(
                &self,
                record: &mut $crate::gpu::Recorder<'_>,
                size: impl Into<$crate::gpu::Size<'s>>,
                arguments: $Args<'_>,
            ) {
                self.0.call(record, size.into(), &arguments);
            }

            fn declared(source: $crate::gpu::Source) -> $crate::gpu::Source {
                source.called_with(<$Args<'_> as $crate::gpu::Argument>::parts())
            }
        }

        impl $crate::gpu::Made for $Kernel {
            type From<'a> = $crate::gpu::Source;

            fn make(gpu: &$crate::gpu::Gpu, from: $crate::gpu::Source) -> Result<Self, $crate::gpu::GpuError> {
                Ok($Kernel($crate::gpu::Function::new(gpu, &$Kernel::declared(from))?))
            }

            #[cfg(test)]
            fn sources(from: $crate::gpu::Source) -> Vec<$crate::gpu::Source> {
                vec![$Kernel::declared(from)]
            }
        }
    )*};
}
pub(crate) use functions;

/// Declares a struct whose fields are arguments of kernels.
macro_rules! arguments {
    (
        $(#[$about:meta])*
        $visible:vis struct $Of:ident $(<$life:lifetime>)? { $($(#[$doc:meta])* $field:ident: $T:ty),* $(,)? }
    ) => {
        $(#[$about])*
        $visible struct $Of $(<$life>)? {
            $($(#[$doc])* pub $field: $T,)*
        }

        impl $(<$life>)? $crate::gpu::Argument for $Of $(<$life>)? {
            fn parts() -> Vec<$crate::gpu::function::Part> {
                use $crate::gpu::Argument;
                $crate::gpu::function::joined(vec![$((stringify!($field), <$T as Argument>::parts())),*])
            }

            fn array(&self, nth: usize) -> Option<&$crate::gpu::Buffer> {
                use $crate::gpu::function::MOST_FIELDS;
                let fields: &[&dyn $crate::gpu::Argument] = &[$(&self.$field),*];
                fields[nth % MOST_FIELDS].array(nth / MOST_FIELDS)
            }

            fn write(&self, nth: usize, to: $crate::gpu::function::Member<'_>) {
                use $crate::gpu::function::MOST_FIELDS;
                let fields: &[&dyn $crate::gpu::Argument] = &[$(&self.$field),*];
                fields[nth % MOST_FIELDS].write(nth / MOST_FIELDS, to);
            }
        }
    };
}
pub(crate) use arguments;

/// Declares which fields of a struct are arrays of kernels, as `name: field` if the kernels use another name, and after
/// the semicolon which are counts, in the same form: `arrays!(Lists { pairs, start: adjacency_start; pairs: pairs_count
/// })`.
macro_rules! arrays {
    ($Of:ty { $($name:ident $(: $field:ident)?),* $(,)? $(; $($value:ident: $of:ident),*)? }) => {
        impl $crate::gpu::Argument for $Of {
            fn parts() -> Vec<$crate::gpu::function::Part> {
                let arrays = $crate::gpu::function::parts(&[$((stringify!($name), "")),*]);
                [arrays, $($crate::gpu::function::parts(&[$((stringify!($value), "u32")),*]))?].concat()
            }

            fn array(&self, nth: usize) -> Option<&$crate::gpu::Buffer> {
                [$($crate::gpu::arrays!(@ self $name $($field)?)),*].get(nth).copied()
            }

            $(fn write(&self, nth: usize, to: $crate::gpu::function::Member<'_>) {
                to.words(&[[$(self.$of as u32),*][nth]]);
            })?
        }
    };
    (@ $of:ident $name:ident) => { &$of.$name };
    (@ $of:ident $name:ident $field:ident) => { &$of.$field };
}
pub(crate) use arrays;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Precision, validate};

    struct Poses([Buffer; 2]);

    impl Argument for Poses {
        fn parts() -> Vec<Part> {
            parts(&[("cells", ""), ("before", ""), ("by", "real"), ("bodies", "u32")])
        }

        fn array(&self, nth: usize) -> Option<&Buffer> {
            self.0.get(nth)
        }
    }

    arguments! {
        struct Scale<'a> { bodies: u64, start: &'a Poses, trial: &'a Poses, by: f64 }
    }

    const TEXT: &str = "
        var<storage, read> before: array<real>;
        var<storage, read_write> trial_cells: array<real>;
        @compute @workgroup_size(WORKGROUP)
        fn main(@builtin(local_invocation_index) i: u32) {
            if i < parameters.bodies { trial_cells[i] = parameters.by * before[i]; }
        }";

    fn plan(precision: Precision, text: &str, parts: Vec<Part>) -> Result<Plan, String> {
        let source = Source::new("scale", precision).text(text).called_with(parts);
        Plan::of(&validate(&source)?, source.arguments())
    }

    #[test]
    fn a_kernel_takes_what_it_names() {
        // The second argument's first array, then the first argument's second array.
        let places = |argument: usize, part: usize| argument + MOST_FIELDS * part;
        for (precision, offset) in [(Precision::F32, 4), (Precision::F64, 8)] {
            let plan = plan(precision, TEXT, Scale::parts()).unwrap();
            assert_eq!(plan.arrays, [places(1, 1), places(2, 0)]);
            let by = (places(3, 0), offset..offset + precision.bytes(), precision.bytes());
            assert_eq!(plan.members, [(places(0, 0), 0..4, 4), by]);
            let mut member = [0; 8];
            0.1.write(0, Member { bytes: &mut member[..precision.bytes()], width: precision.bytes() });
            assert_eq!(member[..precision.bytes()], precision.encode([0.1]));
        }
    }

    #[test]
    fn what_a_kernel_or_its_arguments_alone_have_is_refused() {
        let refused = |text: &str, parts| plan(Precision::F32, text, parts).err().unwrap_or_default();
        assert_eq!(refused(&TEXT.replace("trial_cells", "cell"), Scale::parts()), "cell is no argument");
        assert!(refused(&TEXT.replace("parameters.by", "parameters.to"), Scale::parts()).contains("`to`"));
        let more = [Scale::parts(), joined(vec![("more", Buffer::parts())])].concat();
        assert_eq!(refused(TEXT, more), "it takes no more");
        assert_eq!(refused(&TEXT.replace("parameters.bodies", "1u"), Scale::parts()), "it takes no bodies");
    }
}
