//! Kernels that serve many members of an ensemble in one dispatch.
//!
//! One buffer, the arena, contains all arrays of all members. A merged kernel is made from the parsed text of a plain
//! one. Workgroups of one `z` belong to one member. The member's row of the table `members` contains its number of
//! workgroups and the beginning of each of its arrays. An access `jacobian[i]` becomes `jacobian[i + begin]`, with
//! `begin` from that row; the parameters of the dispatch become an array with one entry per member, and an invocation
//! first copies the entry of its member. Nothing else changes, so a member computes the same as with the plain kernel,
//! in the same order.
//!
//! The old entry point becomes a function. A new entry point calls it with the member's own group and number of groups.

mod entry;
mod function;

use function::Rewriting;
use naga::{
    AddressSpace, ArraySize, GlobalVariable, Handle, Module, ResourceBinding, Scalar, Span, StorageAccess, Type,
    TypeInner,
};
use std::collections::HashMap;

/// Words of a member's row before the offsets of its arrays: workgroups along x and y, and the offset in the arena,
/// plus one, of the words that contain them; zero if the row contains them itself.
pub(super) const HEAD: usize = 3;

/// The bindings of a merged kernel: the table at 0, then its arrays, the arena as words, and its parameters if it has
/// any.
pub(in crate::gpu) struct Merged {
    pub module: Module,
    /// Bytes from one element to the next of each array; for a variable that is not an array, from one member's value
    /// to the next.
    pub strides: Vec<u64>,
    /// Bytes from the parameters of one member to those of the next, if there are parameters.
    pub parameters: Option<u64>,
}

/// A storage variable of which each member has its own copy.
#[derive(Clone, Copy)]
struct Own {
    /// The private variable with the beginning of a member's copy.
    begin: Handle<GlobalVariable>,
    /// Whether it is an array; otherwise it is an element of an array over all members.
    is_array: bool,
}

type Owned = HashMap<Handle<GlobalVariable>, Own>;

/// The variables of a merged kernel.
struct Variables {
    members: Handle<GlobalVariable>,
    words: Handle<GlobalVariable>,
    /// The member that an invocation serves.
    member: Handle<GlobalVariable>,
    /// The beginnings of its arrays, in the order of their bindings.
    begins: Vec<Handle<GlobalVariable>>,
    owned: Owned,
    /// The parameters of all members, and the private copy of a member's own.
    copied: Option<[Handle<GlobalVariable>; 2]>,
}

/// Merges a kernel; `info` is the result of its validation.
///
/// # Errors
/// An operation of the kernel that cannot be merged: it uses an array's length, or its index among all invocations.
pub(in crate::gpu) fn merged(of: &Module, info: &naga::valid::ModuleInfo) -> Result<Merged, String> {
    let mut module = of.clone();
    let mut strides = Vec::new();
    let mut parameters = None;
    let variables = declare(&mut module, &mut strides, &mut parameters)?;
    let mut moved = HashMap::new();
    for (handle, function) in std::mem::take(&mut module.functions).iter() {
        let rewritten = Rewriting::of(of, &info[handle], &variables.owned, &moved).function(function)?;
        moved.insert(handle, module.functions.append(rewritten, Span::UNDEFINED));
    }
    let [main] = &module.entry_points[..] else { return Err("it has no entry point, or several".into()) };
    let old = Rewriting::of(of, info.get_entry_point(0), &variables.owned, &moved).function(&main.function)?;
    let arguments = old.arguments.clone();
    let plain = naga::Function {
        name: Some("of_member".into()),
        arguments: arguments
            .iter()
            .cloned()
            .map(|argument| naga::FunctionArgument { binding: None, ..argument })
            .collect(),
        ..old
    };
    let plain = module.functions.append(plain, Span::UNDEFINED);
    let entry = entry::entry(&mut module, &variables, plain, &arguments)?;
    module.entry_points[0].function = entry;
    Ok(Merged { module, strides, parameters })
}

fn scalar(module: &mut Module, name: Option<String>, inner: TypeInner) -> Handle<Type> {
    module.types.insert(Type { name, inner }, Span::UNDEFINED)
}

/// Makes the variables of a merged kernel from those of a plain one.
fn declare(module: &mut Module, strides: &mut Vec<u64>, parameters: &mut Option<u64>) -> Result<Variables, String> {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).map_err(|e| e.to_string())?;
    let number = |variable: &GlobalVariable| variable.binding.map(|binding| binding.binding);
    let bound = module.global_variables.iter().filter_map(|(handle, variable)| Some((number(variable)?, handle)));
    let mut bound: Vec<_> = bound.collect();
    bound.sort_unstable();
    let word = scalar(module, None, TypeInner::Scalar(Scalar::U32));
    let all_words = TypeInner::Array { base: word, size: ArraySize::Dynamic, stride: 4 };
    let all_words = scalar(module, None, all_words);
    let both = StorageAccess::LOAD | StorageAccess::STORE;
    let storage = |name: &str, number: u32, ty, access| GlobalVariable {
        name: Some(name.into()),
        space: AddressSpace::Storage { access },
        binding: Some(ResourceBinding { group: 0, binding: number }),
        ty,
        init: None,
        memory_decorations: naga::MemoryDecorations::empty(),
    };
    let private = |name: String| GlobalVariable {
        name: Some(name),
        space: AddressSpace::Private,
        binding: None,
        ty: word,
        init: None,
        memory_decorations: naga::MemoryDecorations::empty(),
    };
    let members =
        module.global_variables.append(storage("members", 0, all_words, StorageAccess::LOAD), Span::UNDEFINED);
    let member = module.global_variables.append(private("member".into()), Span::UNDEFINED);
    let (mut owned, mut begins) = (Owned::new(), Vec::new());
    let (mut uniform, mut copied) = (None, None);
    for (_, handle) in bound {
        let whole = module.global_variables[handle].clone();
        let (stride, name) = (u64::from(layouter[whole.ty].to_stride()), whole.name.clone().unwrap_or_default());
        if whole.space == AddressSpace::Uniform {
            uniform = Some((handle, whole.ty, stride));
            continue;
        }
        let (base, stride, is_array) = match module.types[whole.ty].inner {
            TypeInner::Array { base, stride, .. } => (base, u64::from(stride), true),
            _ => (whole.ty, stride, false),
        };
        let array = TypeInner::Array { base, size: ArraySize::Dynamic, stride: stride as u32 };
        let ty = scalar(module, None, array);
        strides.push(stride);
        module.global_variables[handle] = storage(&name, strides.len() as u32, ty, both);
        let begin = module.global_variables.append(private(format!("{name}_begin")), Span::UNDEFINED);
        begins.push(begin);
        owned.insert(handle, Own { begin, is_array });
    }
    let next = strides.len() as u32 + 1;
    let words = module.global_variables.append(storage("arena", next, all_words, both), Span::UNDEFINED);
    if let Some((handle, base, stride)) = uniform {
        let array = TypeInner::Array { base, size: ArraySize::Dynamic, stride: stride as u32 };
        let ty = scalar(module, None, array);
        // A driver reads a uniform once for all invocations, but an array element once per invocation and access. So
        // the kernel copies its member's parameters. The gain of this alone was not measured.
        module.global_variables[handle].space = AddressSpace::Private;
        module.global_variables[handle].binding = None;
        let all = storage("parameters_of_all", next + 1, ty, StorageAccess::LOAD);
        copied = Some([module.global_variables.append(all, Span::UNDEFINED), handle]);
        *parameters = Some(stride);
    }
    Ok(Variables { members, words, member, begins, owned, copied })
}

#[cfg(test)]
mod tests;
