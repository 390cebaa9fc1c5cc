//! The entry point of a merged kernel. It finds the member, the beginnings of the member's arrays, and whether this
//! workgroup belongs to the member.

use super::{HEAD, Variables, scalar};
use naga::{
    BinaryOperator, Binding, Block, BuiltIn, Expression, Function, FunctionArgument, GlobalVariable, Handle, Literal,
    LocalVariable, Module, Range, Scalar, Span, Statement, Type, TypeInner, VectorSize,
};

/// A function under construction, statement by statement.
struct Building {
    function: Function,
    words: u32,
}

/// The entry point that calls `plain`, a kernel's old entry point with these arguments.
///
/// # Errors
/// An argument whose value differs between a member alone and the same member among others.
pub(super) fn entry(
    module: &mut Module,
    variables: &Variables,
    plain: Handle<Function>,
    arguments: &[FunctionArgument],
) -> Result<Function, String> {
    let word = scalar(module, None, TypeInner::Scalar(Scalar::U32));
    let vector = scalar(module, None, TypeInner::Vector { size: VectorSize::Tri, scalar: Scalar::U32 });
    let mut of = Building { function: Function::default(), words: (HEAD + variables.begins.len()) as u32 };
    let group = of.argument(vector, BuiltIn::WorkGroupId);
    let local = of.argument(word, BuiltIn::LocalInvocationIndex);
    let [x, y, member] = [0, 1, 2].map(|index| of.emit(Expression::AccessIndex { base: group, index }));
    of.store(variables.member, member);
    let columns = of.local(word, "columns");
    let rows = of.local(word, "rows");
    let said = of.row(variables.members, member, 2);
    let [own_columns, own_rows] = [0, 1].map(|nth| of.row(variables.members, member, nth));
    of.statement(Statement::Store { pointer: columns, value: own_columns });
    of.statement(Statement::Store { pointer: rows, value: own_rows });
    of.take_from_arena(variables.words, said, [columns, rows]);
    let [columns, rows] = [columns, rows].map(|pointer| of.emit(Expression::Load { pointer }));
    let [beyond, below] = [(x, columns), (y, rows)]
        .map(|(left, right)| of.emit(Expression::Binary { op: BinaryOperator::GreaterEqual, left, right }));
    let outside = of.emit(Expression::Binary { op: BinaryOperator::LogicalOr, left: beyond, right: below });
    let leave = Block::from_vec(vec![Statement::Return { value: None }]);
    of.statement(Statement::If { condition: outside, accept: leave, reject: Block::new() });
    for (nth, begin) in variables.begins.iter().enumerate() {
        let value = of.row(variables.members, member, (HEAD + nth) as u32);
        of.store(*begin, value);
    }
    if let Some([all, own]) = variables.copied {
        let value = of.word(all, member);
        of.store(own, value);
    }
    let [none, one] = [0, 1].map(|number| of.literal(number));
    let own_group = of.emit(Expression::Compose { ty: vector, components: vec![x, y, none] });
    let groups = of.emit(Expression::Compose { ty: vector, components: vec![columns, rows, one] });
    let mut passed = Vec::new();
    for argument in arguments {
        passed.push(match argument.binding {
            Some(Binding::BuiltIn(BuiltIn::WorkGroupId)) => own_group,
            Some(Binding::BuiltIn(BuiltIn::NumWorkGroups)) => groups,
            Some(Binding::BuiltIn(BuiltIn::LocalInvocationIndex)) => local,
            _ => return Err("its entry point has an argument that no merged kernel has".into()),
        });
    }
    of.statement(Statement::Call { function: plain, arguments: passed, result: None });
    of.statement(Statement::Return { value: None });
    Ok(of.function)
}

impl Building {
    fn append(&mut self, expression: Expression) -> Handle<Expression> {
        self.function.expressions.append(expression, Span::UNDEFINED)
    }

    fn statement(&mut self, statement: Statement) {
        self.function.body.push(statement, Span::UNDEFINED);
    }

    fn emit(&mut self, expression: Expression) -> Handle<Expression> {
        let handle = self.append(expression);
        self.statement(Statement::Emit(Range::new_from_bounds(handle, handle)));
        handle
    }

    fn literal(&mut self, number: u32) -> Handle<Expression> {
        self.append(Expression::Literal(Literal::U32(number)))
    }

    fn argument(&mut self, ty: Handle<Type>, builtin: BuiltIn) -> Handle<Expression> {
        let binding = Some(Binding::BuiltIn(builtin));
        self.function.arguments.push(FunctionArgument { name: None, ty, binding });
        self.append(Expression::FunctionArgument(self.function.arguments.len() as u32 - 1))
    }

    fn local(&mut self, ty: Handle<Type>, name: &str) -> Handle<Expression> {
        let variable = LocalVariable { name: Some(name.into()), ty, init: None };
        let variable = self.function.local_variables.append(variable, Span::UNDEFINED);
        self.append(Expression::LocalVariable(variable))
    }

    fn store(&mut self, variable: Handle<GlobalVariable>, value: Handle<Expression>) {
        let pointer = self.append(Expression::GlobalVariable(variable));
        self.statement(Statement::Store { pointer, value });
    }

    /// An element of an array; adds the statements that load it.
    fn word(&mut self, array: Handle<GlobalVariable>, index: Handle<Expression>) -> Handle<Expression> {
        let base = self.append(Expression::GlobalVariable(array));
        let pointer = self.emit(Expression::Access { base, index });
        self.emit(Expression::Load { pointer })
    }

    /// A word of a member's row.
    fn row(&mut self, table: Handle<GlobalVariable>, member: Handle<Expression>, nth: u32) -> Handle<Expression> {
        let [words, nth] = [self.words, nth].map(|number| self.literal(number));
        let row = self.emit(Expression::Binary { op: BinaryOperator::Multiply, left: member, right: words });
        let place = self.emit(Expression::Binary { op: BinaryOperator::Add, left: row, right: nth });
        self.word(table, place)
    }

    /// If the row has an offset in the arena, the numbers of workgroups are the words there.
    fn take_from_arena(
        &mut self,
        arena: Handle<GlobalVariable>,
        said: Handle<Expression>,
        into: [Handle<Expression>; 2],
    ) {
        let [none, one] = [0, 1].map(|number| self.literal(number));
        let elsewhere = self.emit(Expression::Binary { op: BinaryOperator::Greater, left: said, right: none });
        let outside = std::mem::take(&mut self.function.body);
        let place = self.emit(Expression::Binary { op: BinaryOperator::Subtract, left: said, right: one });
        for (index, pointer) in [place, said].into_iter().zip(into) {
            let value = self.word(arena, index);
            self.statement(Statement::Store { pointer, value });
        }
        let accept = std::mem::replace(&mut self.function.body, outside);
        self.statement(Statement::If { condition: elsewhere, accept, reject: Block::new() });
    }
}
