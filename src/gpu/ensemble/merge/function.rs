//! A function of a kernel with every access to a member's own variables shifted by the beginning of the variable.
//!
//! naga requires that an expression follows its operands. So the arena of expressions is rebuilt in its order, with the
//! sums of indices and beginnings inserted before each access.

use super::Owned;
use naga::{
    Arena, BinaryOperator, Block, Expression, Function, GlobalVariable, Handle, Literal, LocalVariable, Module, Range,
    ScalarKind, Span, Statement, SwitchCase,
};
use std::collections::HashMap;

pub(super) struct Rewriting<'a> {
    module: &'a Module,
    info: &'a naga::valid::FunctionInfo,
    owned: &'a Owned,
    /// The new handles of other functions.
    moved: &'a HashMap<Handle<Function>, Handle<Function>>,
    expressions: Arena<Expression>,
    /// For each old expression: the first expression that replaces it, and the one with its value.
    places: HashMap<Handle<Expression>, (Handle<Expression>, Handle<Expression>)>,
    /// The pointers to the beginnings, and the literals of constant indices.
    begins: HashMap<Handle<GlobalVariable>, Handle<Expression>>,
    literals: HashMap<u32, Handle<Expression>>,
}

impl<'a> Rewriting<'a> {
    pub fn of(
        module: &'a Module,
        info: &'a naga::valid::FunctionInfo,
        owned: &'a Owned,
        moved: &'a HashMap<Handle<Function>, Handle<Function>>,
    ) -> Self {
        let (expressions, places) = (Arena::new(), HashMap::new());
        Rewriting { module, info, owned, moved, expressions, places, begins: HashMap::new(), literals: HashMap::new() }
    }

    pub fn function(mut self, old: &Function) -> Result<Function, String> {
        self.declare(old);
        for (handle, expression) in old.expressions.iter() {
            let place = self.place(&old.expressions, expression)?;
            self.places.insert(handle, place);
        }
        let body = self.block(&old.body)?;
        let mut local_variables = Arena::new();
        for (_, variable) in old.local_variables.iter() {
            let init = variable.init.map(|init| self.value(init));
            local_variables.append(LocalVariable { init, ..variable.clone() }, Span::UNDEFINED);
        }
        Ok(Function {
            name: old.name.clone(),
            arguments: old.arguments.clone(),
            result: old.result.clone(),
            local_variables,
            expressions: self.expressions,
            named_expressions: Default::default(),
            body,
            diagnostic_filter_leaf: old.diagnostic_filter_leaf,
        })
    }

    fn append(&mut self, expression: Expression) -> Handle<Expression> {
        self.expressions.append(expression, Span::UNDEFINED)
    }

    /// Pointers and literals are evaluated without a statement, so they come before all others.
    fn declare(&mut self, old: &Function) {
        for (_, expression) in old.expressions.iter() {
            match *expression {
                Expression::GlobalVariable(variable) => {
                    if let Some(own) = self.owned.get(&variable)
                        && !self.begins.contains_key(&variable)
                    {
                        let pointer = self.append(Expression::GlobalVariable(own.begin));
                        self.begins.insert(variable, pointer);
                    }
                }
                Expression::AccessIndex { base, index }
                    if variable_of(&old.expressions, base).is_some() && !self.literals.contains_key(&index) =>
                {
                    let literal = self.append(Expression::Literal(Literal::U32(index)));
                    self.literals.insert(index, literal);
                }
                _ => {}
            }
        }
    }

    fn value(&self, old: Handle<Expression>) -> Handle<Expression> {
        self.places[&old].1
    }

    /// The variable of an expression, if each member has its own.
    fn own(&self, old: &Arena<Expression>, pointer: Handle<Expression>) -> Option<(Handle<GlobalVariable>, bool)> {
        let variable = variable_of(old, pointer)?;
        Some((variable, self.owned.get(&variable)?.is_array))
    }

    /// The beginning of a member's own variable.
    fn begin(&mut self, variable: Handle<GlobalVariable>) -> Handle<Expression> {
        let pointer = self.begins[&variable];
        self.append(Expression::Load { pointer })
    }

    /// Adds the expressions that replace an expression.
    fn place(
        &mut self,
        old: &Arena<Expression>,
        expression: &Expression,
    ) -> Result<(Handle<Expression>, Handle<Expression>), String> {
        match *expression {
            Expression::Access { base, index } => {
                if let Some((variable, true)) = self.own(old, base) {
                    let begin = self.begin(variable);
                    let index = self.unsigned(index);
                    return Ok((begin, self.element(base, begin, index)));
                }
            }
            Expression::AccessIndex { base, index } => match self.own(old, base) {
                Some((variable, true)) => {
                    let begin = self.begin(variable);
                    let index = self.literals[&index];
                    return Ok((begin, self.element(base, begin, index)));
                }
                Some((variable, false)) => {
                    let begin = self.begin(variable);
                    let base = self.append(Expression::Access { base: self.value(base), index: begin });
                    return Ok((begin, self.append(Expression::AccessIndex { base, index })));
                }
                None => {}
            },
            Expression::Load { pointer } => {
                if let Some((variable, false)) = self.own(old, pointer) {
                    let begin = self.begin(variable);
                    let pointer = self.append(Expression::Access { base: self.value(pointer), index: begin });
                    return Ok((begin, self.append(Expression::Load { pointer })));
                }
            }
            Expression::ArrayLength(_) => return Err("it asks for the length of an array".into()),
            _ => {}
        }
        let copied = self.copied(expression)?;
        let handle = self.append(copied);
        Ok((handle, handle))
    }

    fn element(
        &mut self,
        base: Handle<Expression>,
        begin: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Handle<Expression> {
        let index = self.append(Expression::Binary { op: BinaryOperator::Add, left: index, right: begin });
        self.append(Expression::Access { base: self.value(base), index })
    }

    /// An index converted to `u32`.
    fn unsigned(&mut self, old: Handle<Expression>) -> Handle<Expression> {
        let expr = self.value(old);
        match self.info[old].ty.inner_with(&self.module.types).scalar_kind() {
            Some(ScalarKind::Sint) => self.append(Expression::As { expr, kind: ScalarKind::Uint, convert: Some(4) }),
            _ => expr,
        }
    }

    /// An expression with the new handles of its operands.
    fn copied(&self, expression: &Expression) -> Result<Expression, String> {
        let at = |handle: &Handle<Expression>| self.value(*handle);
        let maybe = |handle: &Option<Handle<Expression>>| handle.map(|handle| self.value(handle));
        Ok(match expression {
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::ZeroValue(_)
            | Expression::FunctionArgument(_)
            | Expression::GlobalVariable(_)
            | Expression::LocalVariable(_)
            | Expression::AtomicResult { .. }
            | Expression::WorkGroupUniformLoadResult { .. } => expression.clone(),
            Expression::CallResult(function) => Expression::CallResult(self.moved[function]),
            Expression::Compose { ty, components } => {
                Expression::Compose { ty: *ty, components: components.iter().map(at).collect() }
            }
            Expression::Access { base, index } => Expression::Access { base: at(base), index: at(index) },
            Expression::AccessIndex { base, index } => Expression::AccessIndex { base: at(base), index: *index },
            Expression::Splat { size, value } => Expression::Splat { size: *size, value: at(value) },
            Expression::Swizzle { size, vector, pattern } => {
                Expression::Swizzle { size: *size, vector: at(vector), pattern: *pattern }
            }
            Expression::Load { pointer } => Expression::Load { pointer: at(pointer) },
            Expression::Unary { op, expr } => Expression::Unary { op: *op, expr: at(expr) },
            Expression::Binary { op, left, right } => Expression::Binary { op: *op, left: at(left), right: at(right) },
            Expression::Select { condition, accept, reject } => {
                Expression::Select { condition: at(condition), accept: at(accept), reject: at(reject) }
            }
            Expression::Relational { fun, argument } => Expression::Relational { fun: *fun, argument: at(argument) },
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                Expression::Math { fun: *fun, arg: at(arg), arg1: maybe(arg1), arg2: maybe(arg2), arg3: maybe(arg3) }
            }
            Expression::As { expr, kind, convert } => Expression::As { expr: at(expr), kind: *kind, convert: *convert },
            _ => return Err("it has an expression that no merged kernel has".into()),
        })
    }

    fn block(&self, old: &Block) -> Result<Block, String> {
        let mut out = Block::with_capacity(old.len());
        for (statement, span) in old.span_iter() {
            if let Some(statement) = self.statement(statement)? {
                out.push(statement, *span);
            }
        }
        Ok(out)
    }

    fn statement(&self, old: &Statement) -> Result<Option<Statement>, String> {
        let at = |handle: &Handle<Expression>| self.value(*handle);
        let maybe = |handle: &Option<Handle<Expression>>| handle.map(|handle| self.value(handle));
        Ok(Some(match old {
            Statement::Emit(range) => {
                let (Some(first), Some(last)) = (range.clone().next(), range.clone().last()) else { return Ok(None) };
                Statement::Emit(Range::new_from_bounds(self.places[&first].0, self.value(last)))
            }
            Statement::Block(block) => Statement::Block(self.block(block)?),
            Statement::If { condition, accept, reject } => {
                Statement::If { condition: at(condition), accept: self.block(accept)?, reject: self.block(reject)? }
            }
            Statement::Switch { selector, cases } => {
                let case = |case: &SwitchCase| Ok(SwitchCase { body: self.block(&case.body)?, ..case.clone() });
                let cases = cases.iter().map(case).collect::<Result<_, String>>()?;
                Statement::Switch { selector: at(selector), cases }
            }
            Statement::Loop { body, continuing, break_if } => {
                let (body, continuing) = (self.block(body)?, self.block(continuing)?);
                Statement::Loop { body, continuing, break_if: maybe(break_if) }
            }
            Statement::Break | Statement::Continue | Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {
                old.clone()
            }
            Statement::Return { value } => Statement::Return { value: maybe(value) },
            Statement::Store { pointer, value } => Statement::Store { pointer: at(pointer), value: at(value) },
            Statement::Atomic { pointer, fun, value, result } => {
                let fun = match fun {
                    naga::AtomicFunction::Exchange { compare: Some(compare) } => {
                        naga::AtomicFunction::Exchange { compare: Some(at(compare)) }
                    }
                    other => *other,
                };
                Statement::Atomic { pointer: at(pointer), fun, value: at(value), result: maybe(result) }
            }
            Statement::WorkGroupUniformLoad { pointer, result } => {
                Statement::WorkGroupUniformLoad { pointer: at(pointer), result: at(result) }
            }
            Statement::Call { function, arguments, result } => Statement::Call {
                function: self.moved[function],
                arguments: arguments.iter().map(at).collect(),
                result: maybe(result),
            },
            _ => return Err("it has a statement that no merged kernel has".into()),
        }))
    }
}

fn variable_of(old: &Arena<Expression>, pointer: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    match old[pointer] {
        Expression::GlobalVariable(variable) => Some(variable),
        _ => None,
    }
}
