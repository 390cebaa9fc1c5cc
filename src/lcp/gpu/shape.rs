//! A stage's kernel. Stages that differ only in the vectors and scalars that they use have the same shape and share a
//! kernel. Each dispatch passes the offsets of its vectors and scalars as parameters.
//!
//! A kernel specialised for its stage keeps intermediate results in registers. Interpreting the instructions took five
//! to ten times as long on a software adapter.

use super::layout::FIRST_CONSTANT;
use super::number::{Operation, RING};
use super::stage::{Action, Block, Bodies, Clusters, Gather, Product, Rows, Stage, Words, Work};

/// A scalar that a stage uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Operand {
    /// A constant, by its bits.
    Constant(u64),
    /// A scalar computed earlier: a parameter of the dispatch.
    Parameter(u32),
    /// The result of the stage's own nth operation.
    Made(u32),
}

/// An operation on scalars.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct NumberLine {
    pub operation: Operation,
    pub operands: [Operand; 3],
    /// The sum of the stage before that a [`Operation::Take`] takes.
    pub sum: u32,
    /// The offset of the result in the ring, counted from the first scalar that the stage computes. For a check: the
    /// number of checks of the stage before it.
    pub out: u32,
}

/// An instruction whose vectors are parameters of the dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Line {
    pub action: Action,
    pub out: u32,
    pub vectors: [u32; 3],
    pub numbers: [Operand; 2],
}

/// A stage without the offsets of its vectors and scalars.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Shape {
    /// The kinds of the sums of the stage before, if this stage takes some.
    pub taken: Vec<u32>,
    pub numbers: Vec<NumberLine>,
    pub work: ShapeWork,
    /// Whether it is executed only after a check has ended the batch.
    pub confirms: bool,
}

impl Line {
    /// Whether it reads a vector.
    pub fn reads(&self, vector: u32) -> bool {
        self.vectors.into_iter().zip(self.action.reads()).any(|(read, reads)| reads && read == vector)
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) enum ShapeWork {
    #[default]
    Numbers,
    Rows {
        /// The product whose rows are computed first.
        product: Option<Product>,
        /// If the scalar is positive, the second vector becomes the sum of the clusters' displacements, otherwise the
        /// first vector.
        gather: Option<(Operand, [u32; 2])>,
        before: Vec<Line>,
        block: Option<Block>,
        after: Vec<Line>,
    },
    Clusters {
        condition: Operand,
        tolerance: Operand,
        x: u32,
        g: u32,
    },
    Bodies {
        x: u32,
        low: Option<u32>,
        instead: Option<(Operand, u32)>,
        exact: bool,
    },
}

/// A stage's shape, and the offsets of its vectors and scalars.
#[derive(Clone, Debug, Default)]
pub(super) struct StageArguments {
    pub shape: Shape,
    pub vectors: Vec<u32>,
    pub numbers: Vec<u32>,
    /// The offset of the first scalar that the stage computes.
    pub base: u32,
}

fn place(of: u32, list: &mut Vec<u32>) -> u32 {
    let place = list.iter().position(|known| *known == of).unwrap_or_else(|| {
        list.push(of);
        list.len() - 1
    });
    place as u32
}

impl StageArguments {
    /// The arguments of a stage that follows one with sums of these kinds. Stages that prepare or export have none.
    pub fn of(constants: &[f64], stage: &Stage, taken: &[u32]) -> StageArguments {
        let mut arguments = StageArguments::of_operations(constants, &stage.operations, taken);
        // The offsets of the results of the operations.
        let made: Vec<u32> = stage.operations.iter().map(|words| words[0] >> 8).collect();
        arguments.work(constants, &made, &stage.work);
        arguments
    }

    /// The arguments of operations alone, after a stage with sums of these kinds.
    pub fn of_operations(constants: &[f64], operations: &[[u32; 4]], taken: &[u32]) -> StageArguments {
        let mut arguments = StageArguments::default();
        arguments.operations(constants, operations);
        if arguments.shape.numbers.iter().any(|line| line.operation == Operation::Take) {
            arguments.shape.taken = taken.to_vec();
        }
        arguments
    }

    /// The arguments of work alone.
    pub fn of_work(constants: &[f64], work: &Work) -> StageArguments {
        let mut arguments = StageArguments::default();
        arguments.work(constants, &[], work);
        arguments
    }

    fn work(&mut self, constants: &[f64], made: &[u32], work: &Work) {
        self.shape.work = match work {
            Work::Rows(Rows { product, gather, before, block, after, .. }) => ShapeWork::Rows {
                product: product.map(|product| Product { out: place(product.out, &mut self.vectors), ..product }),
                gather: gather.map(|Gather { condition, instead, out }| {
                    let vectors = [instead, out].map(|vector| place(vector, &mut self.vectors));
                    (self.operand(constants, made, condition), vectors)
                }),
                before: self.lines(constants, made, before),
                block: block.map(|block| self.block(block)),
                after: self.lines(constants, made, after),
            },
            Work::Clusters(Clusters { condition, tolerance, x, g }) => ShapeWork::Clusters {
                condition: self.operand(constants, made, *condition),
                tolerance: self.given(made, *tolerance),
                x: place(*x, &mut self.vectors),
                g: place(*g, &mut self.vectors),
            },
            Work::Bodies(Bodies { x, low, instead, exact }) => ShapeWork::Bodies {
                exact: *exact,
                x: place(*x, &mut self.vectors),
                low: low.map(|low| place(low, &mut self.vectors)),
                instead: instead.map(|[condition, from]| {
                    (self.operand(constants, made, condition), place(from, &mut self.vectors))
                }),
            },
            _ => ShapeWork::Numbers,
        };
    }

    fn operations(&mut self, constants: &[f64], operations: &[[u32; 4]]) {
        let mut made = Vec::new();
        let mut looks = 0;
        let kind = |words: &[u32; 4]| Operation::ALL[(words[0] & 0xff) as usize];
        let first = operations.iter().find(|words| kind(words) != Operation::Look);
        self.base = first.map_or(0, |words| words[0] >> 8);
        for words in operations {
            let [head, a, b, c] = *words;
            let operation = kind(words);
            // The last word of a check is its number.
            let used = match operation {
                Operation::Take => [None; 3],
                Operation::Look => [Some(a), Some(b), None],
                _ => [Some(a), Some(b), Some(c)],
            };
            let none = Operand::Constant(0);
            let mut operands = used.map(|place| place.map_or(none, |place| self.operand(constants, &made, place)));
            if operation == Operation::Look {
                operands[1] = self.given(&made, b);
            }
            let out = match operation {
                Operation::Look => looks,
                _ => (head >> 8).wrapping_sub(self.base) % RING,
            };
            looks += u32::from(operation == Operation::Look);
            let sum = if operation == Operation::Take { a } else { 0 };
            self.shape.numbers.push(NumberLine { operation, operands, sum, out });
            made.push(head >> 8);
        }
    }

    /// The operand for a scalar at an offset; `made` has the offsets of the results so far.
    fn operand(&mut self, constants: &[f64], made: &[u32], number: u32) -> Operand {
        if let Some(constant) = constants.get((number.wrapping_sub(FIRST_CONSTANT)) as usize) {
            return Operand::Constant(constant.to_bits());
        }
        self.given(made, number)
    }

    /// The same for a scalar that differs between solves, such as a tolerance: as a constant of the kernel, it would
    /// require a new kernel for every solve.
    fn given(&mut self, made: &[u32], number: u32) -> Operand {
        match made.iter().rposition(|place| *place == number) {
            Some(nth) => Operand::Made(nth as u32),
            None => Operand::Parameter(place(number, &mut self.numbers)),
        }
    }

    fn block(&mut self, Block { x, w, g, out }: Block) -> Block {
        let mut of = |vector| place(vector, &mut self.vectors);
        Block { x: of(x), w: w.map(&mut of), g: g.map(&mut of), out: of(out) }
    }

    fn lines(&mut self, constants: &[f64], made: &[u32], instructions: &[Words]) -> Vec<Line> {
        instructions.iter().map(|words| self.line(constants, made, words)).collect()
    }

    fn line(&mut self, constants: &[f64], made: &[u32], words: &Words) -> Line {
        let [action, out, a, b, c, s, t, _] = *words;
        let action = Action::ALL[action as usize];
        let vectors = [a, b, c].map(|vector| place(vector, &mut self.vectors));
        let numbers = [s, t].map(|number| self.operand(constants, made, number));
        let out = if action.is_sum() { out } else { place(out, &mut self.vectors) };
        Line { action, out, vectors, numbers }
    }
}

impl Shape {
    pub fn has_block(&self) -> bool {
        matches!(&self.work, ShapeWork::Rows { block: Some(_), .. })
    }

    pub fn has_product(&self) -> bool {
        matches!(&self.work, ShapeWork::Rows { product: Some(_), .. })
    }

    pub fn is_clusters(&self) -> bool {
        matches!(self.work, ShapeWork::Clusters { .. })
    }

    pub fn gathers(&self) -> bool {
        matches!(&self.work, ShapeWork::Rows { gather: Some(_), .. })
    }

    pub fn is_bodies(&self) -> bool {
        matches!(self.work, ShapeWork::Bodies { .. })
    }

    /// Whether its velocities are in two parts.
    pub fn is_exact(&self) -> bool {
        match &self.work {
            ShapeWork::Rows { product, .. } => product.is_some_and(|product| product.exact),
            ShapeWork::Bodies { exact, .. } => *exact,
            ShapeWork::Numbers | ShapeWork::Clusters { .. } => false,
        }
    }

    /// Whether a check is among its operations.
    pub fn looks(&self) -> bool {
        self.numbers.iter().any(|line| line.operation == Operation::Look)
    }

    /// The number of sums that it computes.
    pub fn sums(&self) -> usize {
        match &self.work {
            ShapeWork::Rows { before, after, .. } => {
                before.iter().chain(after).filter(|line| line.action.is_sum()).count()
            }
            _ => 0,
        }
    }
}
