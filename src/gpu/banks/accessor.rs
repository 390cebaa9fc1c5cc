//! The functions that load and store a part of an element of a banked array.

use naga::{
    BinaryOperator, Block, Expression, Function, FunctionArgument, FunctionResult, GlobalVariable, Handle, Literal,
    Module, Scalar, Span, Statement, SwitchCase, SwitchValue, Type, TypeInner,
};

/// A step from an array to an element, or from an element to a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Step {
    /// To the part with this number.
    Known(u32),
    /// To the element with a computed index of type `u32`.
    Unsigned,
    /// To the element with a computed index of type `i32`.
    Signed,
}

/// A function, identified by its array, its path, and whether it loads or stores.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Accessor {
    pub array: Handle<GlobalVariable>,
    pub path: Vec<Step>,
    pub stores: bool,
}

/// A function being built.
struct Building<'a> {
    function: Function,
    path: &'a [Step],
    /// The arguments of computed steps, in order.
    indices: Vec<Handle<Expression>>,
    /// The value to store.
    value: Option<Handle<Expression>>,
}

impl Accessor {
    /// The function, for these banks of so many elements.
    ///
    /// # Errors
    /// A path that leads nowhere.
    pub fn function(
        &self,
        module: &mut Module,
        banks: &[Handle<GlobalVariable>],
        elements: u32,
    ) -> Result<Function, String> {
        let found = self.found(module)?;
        let mut building = self.building(module, found);
        let index = building.index();
        let size = building.literal(elements);
        let divided = Expression::Binary { op: BinaryOperator::Divide, left: index, right: size };
        let bank = building.append(divided);
        let mut body = Block::new();
        body.push(Statement::Emit(naga::Range::new_from_bounds(bank, bank)), Span::UNDEFINED);
        let last = banks.len().saturating_sub(1);
        let mut cases = Vec::new();
        for (number, variable) in (0..).zip(banks) {
            let value = if number as usize == last { SwitchValue::Default } else { SwitchValue::U32(number) };
            let case = building.of_bank(*variable, index, number * elements);
            cases.push(SwitchCase { value, body: case, fall_through: false });
        }
        body.push(Statement::Switch { selector: bank, cases }, Span::UNDEFINED);
        let mut function = building.function;
        // The conversion of a signed index must come before the choice of the bank.
        if self.path.first() == Some(&Step::Signed) {
            body.splice(0..0, Block::from_vec(vec![Statement::Emit(naga::Range::new_from_bounds(index, index))]));
        }
        function.body = body;
        Ok(function)
    }

    /// The type of the loaded or stored value.
    fn found(&self, module: &mut Module) -> Result<Handle<Type>, String> {
        let mut found = module.global_variables[self.array].ty;
        for step in &self.path {
            let inner = match (&module.types[found].inner, step) {
                (TypeInner::Array { base, .. }, _) => {
                    found = *base;
                    continue;
                }
                (TypeInner::Struct { members, .. }, Step::Known(member)) => {
                    let member = members.get(*member as usize).ok_or("a struct has no such member")?;
                    found = member.ty;
                    continue;
                }
                (TypeInner::Vector { scalar, .. }, _) => TypeInner::Scalar(*scalar),
                (TypeInner::Matrix { rows, scalar, .. }, _) => TypeInner::Vector { size: *rows, scalar: *scalar },
                _ => return Err("a part of an element is no part of its type".into()),
            };
            found = module.types.insert(Type { name: None, inner }, Span::UNDEFINED);
        }
        Ok(found)
    }

    fn building(&self, module: &mut Module, found: Handle<Type>) -> Building<'_> {
        let mut function = Function::default();
        let name = module.global_variables[self.array].name.clone().unwrap_or_default();
        function.name = Some(if self.stores { format!("{name}_store") } else { format!("{name}_at") });
        let argument = |function: &mut Function, ty| {
            function.arguments.push(FunctionArgument { name: None, ty, binding: None });
            let number = function.arguments.len() as u32 - 1;
            function.expressions.append(Expression::FunctionArgument(number), Span::UNDEFINED)
        };
        let mut indices = Vec::new();
        for step in &self.path {
            let scalar = match step {
                Step::Known(_) => continue,
                Step::Unsigned => Scalar::U32,
                Step::Signed => Scalar::I32,
            };
            let ty = module.types.insert(Type { name: None, inner: TypeInner::Scalar(scalar) }, Span::UNDEFINED);
            indices.push(argument(&mut function, ty));
        }
        let value = self.stores.then(|| argument(&mut function, found));
        function.result = (!self.stores).then_some(FunctionResult { ty: found, binding: None });
        Building { function, path: &self.path, indices, value }
    }
}

impl Building<'_> {
    fn append(&mut self, expression: Expression) -> Handle<Expression> {
        self.function.expressions.append(expression, Span::UNDEFINED)
    }

    fn literal(&mut self, value: u32) -> Handle<Expression> {
        self.append(Expression::Literal(Literal::U32(value)))
    }

    /// The index of the element, as a `u32`.
    fn index(&mut self) -> Handle<Expression> {
        match (self.path.first(), self.indices.first()) {
            (Some(Step::Signed), Some(index)) => {
                let expr = *index;
                self.append(Expression::As { expr, kind: naga::ScalarKind::Uint, convert: Some(4) })
            }
            (Some(Step::Unsigned), Some(index)) => *index,
            (Some(Step::Known(index)), _) => self.literal(*index),
            _ => self.literal(0),
        }
    }

    /// The statements for the bank that begins with element `first`.
    fn of_bank(&mut self, variable: Handle<GlobalVariable>, index: Handle<Expression>, first: u32) -> Block {
        let base = self.append(Expression::GlobalVariable(variable));
        let first = self.literal(first);
        let within = self.append(Expression::Binary { op: BinaryOperator::Subtract, left: index, right: first });
        let mut pointer = self.append(Expression::Access { base, index: within });
        let mut computed = self.indices.clone().into_iter();
        for (number, step) in self.path.iter().enumerate() {
            let index = if matches!(step, Step::Known(_)) { None } else { computed.next() };
            if number == 0 {
                continue;
            }
            let base = pointer;
            pointer = match (step, index) {
                (Step::Known(index), _) => self.append(Expression::AccessIndex { base, index: *index }),
                (_, Some(index)) => self.append(Expression::Access { base, index }),
                _ => base,
            };
        }
        let mut last = pointer;
        let done = match self.value {
            Some(value) => vec![Statement::Store { pointer, value }, Statement::Return { value: None }],
            None => {
                last = self.append(Expression::Load { pointer });
                vec![Statement::Return { value: Some(last) }]
            }
        };
        let mut block = Block::from_vec(vec![Statement::Emit(naga::Range::new_from_bounds(within, last))]);
        block.extend_block(Block::from_vec(done));
        block
    }
}
