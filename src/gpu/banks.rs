//! Arrays larger than one binding. The buffer stays whole and is bound in banks of equal size; functions that are
//! generated from the array's layout find the bank of an element.
//!
//! WebGPU guarantees bindings of 128 MiB only, while buffers may be larger. No kernel is written for banks. In the
//! parsed kernel, a load of `jacobian[i]` becomes a call of a function that reads the bank of `i`, and a store becomes
//! a call of a function that writes it. There is one function for each array and each path to a part of an element
//! (`contacts[i].w`). naga validates the result. An atomic, a pointer passed to a function and `arrayLength` have no
//! such function: a kernel that needs one of them for a banked array is rejected.

mod accessor;

use accessor::{Accessor, Step};
use naga::{AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Module, Span, Statement};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// An array that is bound in several banks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Banked {
    /// Its name.
    pub name: String,
    /// The number of banks.
    pub banks: u32,
    /// Elements per bank.
    pub elements: u64,
}

/// The variables of a banked array.
struct Banks {
    variables: Vec<Handle<GlobalVariable>>,
    elements: u32,
}

/// The path from an array to the target of a pointer, with the computed indices in order.
#[derive(Clone)]
struct Place {
    array: Handle<GlobalVariable>,
    path: Vec<Step>,
    indices: Vec<Handle<Expression>>,
}

type Arrays = HashMap<Handle<GlobalVariable>, Banks>;
type Places = HashMap<Handle<Expression>, Place>;
type Accessors = HashMap<Accessor, Handle<Function>>;
/// The calls that replace loads: the function and its arguments.
type Calls = HashMap<Handle<Expression>, (Handle<Function>, Vec<Handle<Expression>>)>;

/// Splits arrays of a kernel into banks, and renumbers all storage bindings in order.
///
/// # Errors
/// A use of such an array that cannot be split.
pub(super) fn split(module: &mut Module, info: &naga::valid::ModuleInfo, of: &[Banked]) -> Result<(), String> {
    let arrays = declare(module, of)?;
    let mut wanted = Vec::new();
    let mut all_places = Vec::new();
    for (handle, function) in module.functions.iter() {
        all_places.push(places(module, function, &info[handle], &arrays)?);
    }
    let mut of_entries = Vec::new();
    for (index, entry) in module.entry_points.iter().enumerate() {
        of_entries.push(places(module, &entry.function, info.get_entry_point(index), &arrays)?);
    }
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    for (function, places) in functions.chain(entries).zip(all_places.iter().chain(&of_entries)) {
        want(function, places, &mut wanted);
    }
    // A function may call only those before it.
    let old = std::mem::take(&mut module.functions);
    let mut accessors = Accessors::new();
    for accessor in wanted {
        if let Entry::Vacant(place) = accessors.entry(accessor) {
            let banks = &arrays[&place.key().array];
            let function = place.key().function(module, &banks.variables, banks.elements)?;
            place.insert(module.functions.append(function, Span::UNDEFINED));
        }
    }
    let mut moved = HashMap::new();
    for ((handle, function), places) in old.iter().zip(&all_places) {
        let function = rewritten(function.clone(), places, &accessors, &moved)?;
        moved.insert(handle, module.functions.append(function, Span::UNDEFINED));
    }
    for (entry, places) in module.entry_points.iter_mut().zip(&of_entries) {
        entry.function = rewritten(std::mem::take(&mut entry.function), places, &accessors, &moved)?;
    }
    Ok(())
}

/// Declares the banks. The variable of the whole array becomes its first bank.
fn declare(module: &mut Module, of: &[Banked]) -> Result<Arrays, String> {
    let is_storage = |variable: &GlobalVariable| matches!(variable.space, AddressSpace::Storage { .. });
    let number = |variable: &GlobalVariable| variable.binding.map(|binding| binding.binding);
    let variables = module.global_variables.iter().filter(|(_, variable)| is_storage(variable));
    let mut storages: Vec<_> = variables.filter_map(|(handle, variable)| Some((number(variable)?, handle))).collect();
    storages.sort_unstable();
    let mut next = storages.first().map_or(0, |(first, _)| *first);
    let mut arrays = Arrays::new();
    for (_, handle) in storages {
        let whole = module.global_variables[handle].clone();
        let banked = of.iter().find(|array| whole.name.as_deref() == Some(&array.name));
        let mut variables = Vec::new();
        for bank in 0..banked.map_or(1, |array| array.banks) {
            let name = whole.name.as_ref().map(|name| if bank > 0 { format!("{name}_{bank}") } else { name.clone() });
            let binding = whole.binding.map(|binding| naga::ResourceBinding { binding: next, ..binding });
            next += 1;
            let variable = GlobalVariable { name, binding, ..whole.clone() };
            if bank == 0 {
                module.global_variables[handle] = variable;
                variables.push(handle);
            } else {
                variables.push(module.global_variables.append(variable, Span::UNDEFINED));
            }
        }
        if let Some(array) = banked {
            let elements =
                u32::try_from(array.elements).map_err(|_| format!("a bank of {} is too large", array.name))?;
            arrays.insert(handle, Banks { variables, elements });
        }
    }
    Ok(arrays)
}

/// The pointers of a function into banked arrays.
fn places(
    module: &Module,
    function: &Function,
    info: &naga::valid::FunctionInfo,
    arrays: &Arrays,
) -> Result<Places, String> {
    let mut places = Places::new();
    for (handle, expression) in function.expressions.iter() {
        let place = match *expression {
            Expression::GlobalVariable(array) if arrays.contains_key(&array) => {
                Some(Place { array, path: Vec::new(), indices: Vec::new() })
            }
            Expression::Access { base, index } => places.get(&base).cloned().map(|mut place| {
                let kind = info[index].ty.inner_with(&module.types).scalar_kind();
                place.path.push(if kind == Some(naga::ScalarKind::Sint) { Step::Signed } else { Step::Unsigned });
                place.indices.push(index);
                place
            }),
            Expression::AccessIndex { base, index } => places.get(&base).cloned().map(|mut place| {
                place.path.push(Step::Known(index));
                place
            }),
            Expression::ArrayLength(array) if places.contains_key(&array) => {
                return Err("the length of an array in banks is unknown to it".into());
            }
            _ => None,
        };
        if let Some(place) = place {
            places.insert(handle, place);
        }
    }
    Ok(places)
}

impl Place {
    fn accessor(&self, stores: bool) -> Accessor {
        Accessor { array: self.array, path: self.path.clone(), stores }
    }
}

/// The place that an expression loads from.
fn loaded<'a>(expression: &Expression, places: &'a Places) -> Option<&'a Place> {
    match expression {
        Expression::Load { pointer } => places.get(pointer),
        _ => None,
    }
}

/// Adds the accessors that a function needs to load and store.
fn want(function: &Function, places: &Places, wanted: &mut Vec<Accessor>) {
    let loads = function.expressions.iter().filter_map(|(_, expression)| loaded(expression, places));
    wanted.extend(loads.map(|place| place.accessor(false)));
    rebuilt(function.body.clone(), &mut |statement, _, _| {
        if let Statement::Store { pointer, .. } = statement {
            wanted.extend(places.get(&pointer).map(|place| place.accessor(true)));
        }
    });
}

/// A function that calls `accessors`, and other functions by the handles in `moved`.
fn rewritten(
    mut function: Function,
    places: &Places,
    accessors: &Accessors,
    moved: &HashMap<Handle<Function>, Handle<Function>>,
) -> Result<Function, String> {
    let mut loads = Calls::new();
    for (handle, expression) in function.expressions.iter_mut() {
        if let Some(place) = loaded(expression, places) {
            let accessor = accessors[&place.accessor(false)];
            loads.insert(handle, (accessor, place.indices.clone()));
            *expression = Expression::CallResult(accessor);
        } else if let Expression::CallResult(called) = expression {
            *called = moved[called];
        }
    }
    let mut refused = false;
    let body = std::mem::take(&mut function.body);
    function.body = rebuilt(body, &mut |statement, span, out| match statement {
        Statement::Emit(range) => emit(range, &loads, span, out),
        Statement::Store { pointer, value } if places.contains_key(&pointer) => {
            let place = &places[&pointer];
            let arguments = place.indices.iter().copied().chain([value]).collect();
            let called = accessors[&place.accessor(true)];
            out.push(Statement::Call { function: called, arguments, result: None }, span);
        }
        Statement::Call { function: called, arguments, result } => {
            refused |= arguments.iter().any(|argument| places.contains_key(argument));
            out.push(Statement::Call { function: moved[&called], arguments, result }, span);
        }
        Statement::Atomic { pointer, .. } if places.contains_key(&pointer) => refused = true,
        other => out.push(other, span),
    });
    if refused { Err("an array in banks has neither atomics nor pointers".into()) } else { Ok(function) }
}

/// Emits expressions, with calls instead of loads.
fn emit(range: naga::Range<Expression>, loads: &Calls, span: Span, out: &mut Block) {
    let mut run: Option<(Handle<Expression>, Handle<Expression>)> = None;
    let flush = |run: &mut Option<_>, out: &mut Block| {
        if let Some((first, last)) = run.take() {
            out.push(Statement::Emit(naga::Range::new_from_bounds(first, last)), span);
        }
    };
    for handle in range {
        match loads.get(&handle) {
            None => run = Some((run.map_or(handle, |(first, _)| first), handle)),
            Some((function, arguments)) => {
                flush(&mut run, out);
                let (function, arguments) = (*function, arguments.clone());
                out.push(Statement::Call { function, arguments, result: Some(handle) }, span);
            }
        }
    }
    flush(&mut run, out);
}

/// The block with every statement replaced by the statements that `each` adds for it, also within nested statements.
fn rebuilt(block: Block, each: &mut dyn FnMut(Statement, Span, &mut Block)) -> Block {
    let mut out = Block::with_capacity(block.len());
    for (statement, span) in block.span_into_iter() {
        let statement = match statement {
            Statement::Block(block) => Statement::Block(rebuilt(block, each)),
            Statement::If { condition, accept, reject } => {
                Statement::If { condition, accept: rebuilt(accept, each), reject: rebuilt(reject, each) }
            }
            Statement::Switch { selector, mut cases } => {
                for case in &mut cases {
                    case.body = rebuilt(std::mem::take(&mut case.body), each);
                }
                Statement::Switch { selector, cases }
            }
            Statement::Loop { body, continuing, break_if } => {
                Statement::Loop { body: rebuilt(body, each), continuing: rebuilt(continuing, each), break_if }
            }
            other => {
                each(other, span, &mut out);
                continue;
            }
        };
        out.push(statement, span);
    }
    out
}

#[cfg(test)]
mod tests;
