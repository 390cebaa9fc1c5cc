//! Kernels that are called like functions, with a struct of their arguments (`functions!`).
//!
//! A kernel's WGSL declares its arrays and the members of its parameters, and each is an argument of that name. Where an
//! argument is several arrays or values that belong together, such as the poses of bodies, the kernel takes those that
//! it declares. Names and types are compared once, when the kernel is made: a call copies values to their places.

use super::kernel::bindings;
use super::recorder::Size;
use super::{Buffer, Gpu, GpuError, Kernel, Recorder, Source};
use naga::{Module, ScalarKind, TypeInner};
use std::ops::Range;

/// Arrays that belong together.
pub trait Arrays {
    /// Their names; an empty one is that of the argument. Where two arguments have a name, the plain one is the first's,
    /// and `trial_cells` are the cells of the argument `trial`.
    fn names() -> &'static [&'static str]
    where
        Self: Sized;

    /// The array of the nth name.
    fn array(&self, nth: usize) -> &Buffer;
}

impl Arrays for Buffer {
    fn names() -> &'static [&'static str] {
        &[""]
    }

    fn array(&self, _: usize) -> &Buffer {
        self
    }
}

/// A value of a kernel's parameters, or several that belong together.
pub trait Parameter {
    /// The names of its values, as of arrays.
    fn names() -> &'static [&'static str]
    where
        Self: Sized,
    {
        &[""]
    }

    /// The kind of its numbers.
    fn kind() -> ScalarKind
    where
        Self: Sized;

    /// Writes the value of the nth name.
    fn write(&self, nth: usize, to: Member<'_>);
}

/// The place of a value: its bytes, and those of each of its numbers.
pub struct Member<'p> {
    bytes: &'p mut [u8],
    width: usize,
}

impl Member<'_> {
    /// Writes integers, as many as there is room for.
    pub fn words(self, words: &[u32]) {
        self.bytes.copy_from_slice(&bytemuck::cast_slice(words)[..self.bytes.len()]);
    }

    /// Writes numbers, rounded to what they are in the kernel.
    pub fn reals(self, numbers: &[f64]) {
        for (place, number) in self.bytes.chunks_exact_mut(self.width).zip(numbers) {
            match self.width {
                4 => place.copy_from_slice(&(*number as f32).to_le_bytes()),
                _ => place.copy_from_slice(&number.to_le_bytes()),
            }
        }
    }
}

/// Counts and flags are `u32` in kernels.
macro_rules! word {
    ($($Of:ty),*) => {$(
        impl Parameter for $Of {
            fn kind() -> ScalarKind {
                ScalarKind::Uint
            }

            fn write(&self, _: usize, to: Member<'_>) {
                to.words(&[*self as u32]);
            }
        }
    )*};
}
word!(u32, u64, usize, bool);

impl Parameter for f64 {
    fn kind() -> ScalarKind {
        ScalarKind::Float
    }

    fn write(&self, _: usize, to: Member<'_>) {
        to.reals(&[*self]);
    }
}

/// An argument's name, and the names of its parts.
pub type Argument = (&'static str, &'static [&'static str]);

/// The arguments of a function.
#[derive(Clone, Debug)]
pub struct Declaration {
    pub parameters: Vec<(Argument, ScalarKind)>,
    pub arrays: Vec<Argument>,
}

/// A part of an argument, both by their numbers.
type Part = (usize, usize);

/// Where the arguments of a function belong.
#[derive(Default)]
pub(super) struct Plan {
    /// Bytes of the parameters.
    bytes: usize,
    /// Of each member of the parameters its part, its bytes and those of each number in it.
    members: Vec<(Part, Range<usize>, usize)>,
    /// Of each array, in the order of bindings.
    arrays: Vec<Part>,
}

/// The part that a variable is.
fn part(arguments: impl Iterator<Item = Argument> + Clone, variable: &str) -> Option<Part> {
    let find = |is: &dyn Fn(&str, &str) -> bool| {
        let of = |(argument, (name, parts)): (usize, Argument)| {
            parts.iter().position(|part| is(name, part)).map(|nth| (argument, nth))
        };
        arguments.clone().enumerate().find_map(of)
    };
    let full = |name: &str, part: &str| match part {
        "" => name == variable,
        _ => variable.strip_prefix(name).and_then(|rest| rest.strip_prefix('_')) == Some(part),
    };
    find(&full).or_else(|| find(&|_, part| part == variable))
}

/// The kind and the bytes of the numbers that a type is made of.
fn numbers(module: &Module, inner: &TypeInner) -> Option<(ScalarKind, usize)> {
    match inner {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => Some((scalar.kind, scalar.width.into())),
        TypeInner::Array { base, .. } => numbers(module, &module.types[*base].inner),
        _ => None,
    }
}

impl Plan {
    /// Of a validated kernel.
    ///
    /// # Errors
    /// The name of what the kernel or the function does not have, or has as something else.
    pub fn of(module: &Module, declaration: &Declaration) -> Result<Plan, String> {
        let Declaration { parameters, arrays } = declaration;
        let mut plan = Plan::default();
        for binding in bindings(module)? {
            let name = &binding.name;
            if binding.uniform {
                plan.parameters(module, declaration)?;
                continue;
            }
            let part = part(arrays.iter().copied(), name).ok_or(format!("its array {name} is no argument"))?;
            plan.arrays.push(part);
        }
        let taken = |nth: usize| plan.members.iter().any(|(part, ..)| part.0 == nth);
        let unused = (0..).zip(parameters).find(|(nth, ((_, parts), _))| parts[0].is_empty() && !taken(*nth));
        let bound = |nth: usize| plan.arrays.iter().any(|part| part.0 == nth);
        let idle = (0..).zip(arrays).find(|(nth, (_, parts))| parts[0].is_empty() && !bound(*nth));
        match unused.map(|(_, ((name, _), _))| name).or(idle.map(|(_, (name, _))| name)) {
            Some(name) => Err(format!("it takes no argument {name}")),
            None => Ok(plan),
        }
    }

    fn parameters(&mut self, module: &Module, Declaration { parameters, .. }: &Declaration) -> Result<(), String> {
        let uniform = module.global_variables.iter().find(|(_, v)| v.space == naga::AddressSpace::Uniform);
        let Some(TypeInner::Struct { members, span }) = uniform.map(|(_, v)| &module.types[v.ty].inner) else {
            return Err("its parameters are no struct".into());
        };
        self.bytes = *span as usize;
        for member in members {
            let (name, inner) = (member.name.as_deref().unwrap_or_default(), &module.types[member.ty].inner);
            let part = part(parameters.iter().map(|(argument, _)| *argument), name);
            let part = part.ok_or(format!("its parameter {name} is no argument"))?;
            let numbers = numbers(module, inner).filter(|(kind, _)| *kind == parameters[part.0].1);
            let (_, width) = numbers.ok_or(format!("its parameter {name} has another type than the argument"))?;
            let begin = member.offset as usize;
            self.members.push((part, begin..begin + inner.size(module.to_ctx()) as usize, width));
        }
        Ok(())
    }
}

/// A kernel, and where its arguments belong.
pub struct Function {
    kernel: Kernel,
    plan: Plan,
}

impl Function {
    /// Compiles a source that has a declaration.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] with the place in the source, or with the name of what is no argument.
    pub fn new(gpu: &Gpu, source: &Source, declaration: &Declaration) -> Result<Self, GpuError> {
        let kernel = Kernel::new(gpu, source)?;
        let refused = |message| GpuError::Kernel { kernel: source.name().to_owned(), message };
        let plan = Plan::of(kernel.module(), declaration).map_err(refused)?;
        Ok(Function { kernel, plan })
    }

    /// Records a call.
    pub fn call(
        &self,
        record: &mut Recorder<'_>,
        size: Size<'_>,
        parameters: &[&dyn Parameter],
        arrays: &[&dyn Arrays],
    ) {
        let mut bytes = vec![0; self.plan.bytes];
        for ((argument, nth), range, width) in &self.plan.members {
            parameters[*argument].write(*nth, Member { bytes: &mut bytes[range.clone()], width: *width });
        }
        let array = |(argument, nth): &Part| arrays[*argument].array(*nth);
        let buffers: Vec<&Buffer> = self.plan.arrays.iter().map(array).collect();
        record.dispatch(&self.kernel, &bytes, &buffers, size);
    }
}

/// Declares kernels with their arguments: parameters, and arrays behind them.
///
/// ```ignore
/// functions! {
///     /// Sets the motions of fixed bodies to zero.
///     pub(super) Hold(HoldArgs { bodies: u64; is_fixed: Buffer, motions: Buffer });
/// }
///
/// hold.call(record, bodies, HoldArgs { bodies, is_fixed: &self.flags, motions });
/// ```
macro_rules! functions {
    ($(
        $(#[$doc:meta])*
        $visible:vis $Kernel:ident($Args:ident { $($parameter:ident: $P:ty),*; $($array:ident: $A:ty),* $(,)? });
    )*) => {$(
        $(#[$doc])*
        $visible struct $Kernel($crate::gpu::Function);

        /// What it is called with.
        $visible struct $Args<'a> {
            $(pub $parameter: $P,)*
            $(pub $array: &'a $A,)*
        }

        impl $Kernel {
            fn declaration() -> $crate::gpu::Declaration {
                use $crate::gpu::{Arrays, Parameter};
                $crate::gpu::Declaration {
                    parameters: vec![$(((stringify!($parameter), <$P>::names()), <$P>::kind())),*],
                    arrays: vec![$((stringify!($array), <$A>::names())),*],
                }
            }

            /// Records a call of so many invocations.
            $visible fn call<'s>(
                &self,
                record: &mut $crate::gpu::Recorder<'_>,
                size: impl Into<$crate::gpu::Size<'s>>,
                arguments: $Args<'_>,
            ) {
                self.0.call(record, size.into(), &[$(&arguments.$parameter),*], &[$(arguments.$array),*]);
            }
        }

        impl $crate::gpu::Made for $Kernel {
            type From<'a> = $crate::gpu::Source;

            fn make(gpu: &$crate::gpu::Gpu, from: $crate::gpu::Source) -> Result<Self, $crate::gpu::GpuError> {
                Ok($Kernel($crate::gpu::Function::new(gpu, &from, &$Kernel::declaration())?))
            }

            #[cfg(test)]
            fn sources(from: $crate::gpu::Source) -> Vec<$crate::gpu::Source> {
                vec![from.declared($Kernel::declaration())]
            }
        }
    )*};
}
pub(crate) use functions;

/// Says which fields of a struct are arrays that kernels know, by these names or by others:
/// `arrays!(Poses { cells, places: cells })`.
macro_rules! arrays {
    ($Of:ty { $($name:ident $(: $field:ident)?),* $(,)? }) => {
        impl $crate::gpu::Arrays for $Of {
            fn names() -> &'static [&'static str] {
                &[$(stringify!($name)),*]
            }

            fn array(&self, nth: usize) -> &$crate::gpu::Buffer {
                [$($crate::gpu::arrays!(@ self $name $($field)?)),*][nth]
            }
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

    const TEXT: &str = "
        struct Parameters { n: u32, by: real }
        @group(0) @binding(0) var<uniform> parameters: Parameters;
        @group(0) @binding(1) var<storage, read> from: array<real>;
        @group(0) @binding(2) var<storage, read_write> into: array<real>;
        @compute @workgroup_size(WORKGROUP)
        fn main(@builtin(local_invocation_index) i: u32) {
            if i < parameters.n { into[i] = parameters.by * from[i]; }
        }";

    fn check(parameters: &[(&'static str, ScalarKind)], arrays: &[&'static str]) -> Result<(), String> {
        let plain: &[&str] = &[""];
        let declaration = Declaration {
            parameters: parameters.iter().map(|(name, kind)| ((*name, plain), *kind)).collect(),
            arrays: arrays.iter().map(|name| (*name, plain)).collect(),
        };
        validate(&Source::new("scale", Precision::F32).text(TEXT).declared(declaration)).map(|_| ())
    }

    #[test]
    fn a_function_takes_what_its_kernel_declares() {
        let (n, by) = (("n", ScalarKind::Uint), ("by", ScalarKind::Float));
        check(&[by, n], &["into", "from"]).unwrap();
        for (parameters, arrays, what) in [
            (&[n, by][..], &["from"][..], "its array into is no argument"),
            (&[n], &["from", "into"], "its parameter by is no argument"),
            (&[n, by], &["from", "into", "more"], "it takes no argument more"),
            (&[n, by, ("most", ScalarKind::Uint)], &["from", "into"], "it takes no argument most"),
            (&[("n", ScalarKind::Float), by], &["from", "into"], "its parameter n has another type than the argument"),
        ] {
            assert_eq!(check(parameters, arrays).unwrap_err(), what);
        }
    }

    #[test]
    fn a_variable_is_the_part_of_an_argument() {
        let poses: &[&str] = &["cells", "twists"];
        let arguments = [("start", poses), ("trial", poses), ("boxes", &[""])];
        let part = |name| part(arguments.iter().copied(), name);
        assert_eq!(
            ["cells", "start_twists", "trial_cells", "boxes"].map(part),
            [Some((0, 0)), Some((0, 1)), Some((1, 0)), Some((2, 0)),]
        );
        assert_eq!(["trial", "boxes_cells", "trialcells"].map(part), [None; 3]);
    }
}
