//! The text of a stage's kernel. Stages that differ only in which vectors and numbers they use have the same shape and
//! share a kernel; each dispatch passes the places of its vectors and numbers as parameters.
//!
//! A kernel made for its stage keeps intermediate results in registers. Interpreting the instructions took five to ten
//! times as long on a software adapter.

use super::layout::{FIRST_CONSTANT, MOST_NUMBERS, MOST_VECTORS};
use super::tape::{Action, Stage, Tape, Words};
use std::fmt::Write as _;

/// A number that an instruction uses: a constant by its bits, or a parameter of the dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Operand {
    Constant(u64),
    Parameter(u32),
}

/// An instruction whose vectors are parameters of the dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Line {
    action: Action,
    out: u32,
    vectors: [u32; 3],
    numbers: [Operand; 2],
}

/// The instructions of a stage, without the places of their vectors and numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Shape {
    before: Vec<Line>,
    /// The instruction on whole pairs.
    block: Option<Line>,
    after: Vec<Line>,
    /// The vector that the rows of a product make, where these come first.
    product: Option<u32>,
}

/// A stage's shape, and the places of its vectors and numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct StageArguments {
    pub shape: Shape,
    pub vectors: Vec<u32>,
    pub numbers: Vec<u32>,
}

fn place(of: u32, list: &mut Vec<u32>) -> u32 {
    let place = list.iter().position(|known| *known == of).unwrap_or_else(|| {
        list.push(of);
        list.len() - 1
    });
    place as u32
}

impl StageArguments {
    /// The arguments of a stage of rows or pairs; `None` for other stages.
    pub fn of(tape: &Tape, stage: &Stage) -> Option<StageArguments> {
        let mut arguments = StageArguments::default();
        let instructions = |begin: usize, end: usize| &tape.instructions[begin..end];
        match *stage {
            Stage::Rows { begin, end, product, .. } => {
                arguments.shape.product = product.map(|product| place(product.out, &mut arguments.vectors));
                arguments.shape.before = arguments.lines(tape, instructions(begin, end));
            }
            Stage::Pairs { begin, middle, end, .. } => {
                arguments.shape.before = arguments.lines(tape, instructions(begin, middle));
                arguments.shape.block = arguments.lines(tape, instructions(middle, middle + 1)).pop();
                arguments.shape.after = arguments.lines(tape, instructions(middle + 1, end));
            }
            _ => return None,
        }
        Some(arguments)
    }

    fn lines(&mut self, tape: &Tape, instructions: &[Words]) -> Vec<Line> {
        instructions.iter().map(|words| self.line(tape, words)).collect()
    }

    fn line(&mut self, tape: &Tape, words: &Words) -> Line {
        let [action, out, a, b, c, s, t, _] = *words;
        let action = Action::ALL[action as usize];
        let vectors = [a, b, c].map(|vector| place(vector, &mut self.vectors));
        let numbers = [s, t].map(|number| match tape.constants().get((number.wrapping_sub(FIRST_CONSTANT)) as usize) {
            Some(constant) => Operand::Constant(constant.to_bits()),
            None => Operand::Parameter(place(number, &mut self.numbers)),
        });
        let out = if action.is_sum() { 0 } else { place(out, &mut self.vectors) };
        Line { action, out, vectors, numbers }
    }

    /// Whether the parameters of a dispatch have room for one more instruction.
    pub fn has_room(&self) -> bool {
        self.vectors.len() + 4 <= MOST_VECTORS && self.numbers.len() + 2 <= MOST_NUMBERS
    }
}

impl Shape {
    pub fn has_block(&self) -> bool {
        self.block.is_some()
    }

    pub fn has_product(&self) -> bool {
        self.product.is_some()
    }

    /// The kernel's entry point. `literal` writes a constant.
    pub fn text(&self, literal: impl Fn(f64) -> String) -> String {
        let mut text = String::from(BEGIN);
        let lines: Vec<&Line> = self.before.iter().chain(&self.after).collect();
        for (k, line) in lines.iter().enumerate() {
            for (which, operand) in ["s", "t"].iter().zip(line.numbers) {
                let _ = writeln!(text, "    let {which}{k} = {};", number(operand, &literal));
            }
            if line.action.is_sum() {
                let _ = writeln!(text, "    var sum{k} = identity({}u);", line.action.kind());
            }
        }
        if let Some(line) = &self.block {
            let step = number(line.numbers[0], &literal);
            let [x, g, _] = line.vectors.map(vector_place);
            let out = vector_place(line.out);
            let _ = writeln!(text, "    let step = {step};");
            text.push_str(CHUNK);
            rows(&mut text, ROWS_OF_CHUNK, &self.before, 0, None);
            let block = format!("minimize_block(block_start[slot], block_start[slot + 1u], {x}, {g}, step, {out})");
            let _ = writeln!(
                text,
                "    storageBarrier();\n    if slot < parameters.pairs {{ {block}; }}\n    storageBarrier();"
            );
            rows(&mut text, ROWS_OF_CHUNK, &self.after, self.before.len(), None);
            text.push_str("    storageBarrier();\n    }\n");
        } else {
            rows(&mut text, ALL_ROWS, &self.before, 0, self.product);
        }
        for (nth, k) in (0..lines.len()).filter(|k| lines[*k].action.is_sum()).enumerate() {
            let _ = writeln!(text, "    lanes[(parameters.reduction + {nth}u) * WORKGROUP + local] = sum{k};");
        }
        text.push_str("    leave_sums(group_index(group, groups), local);\n}\n");
        text
    }
}

const BEGIN: &str = "@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
";

const ALL_ROWS: &str = "    for (var row = invocation(group, groups, local); row < parameters.rows; row += parameters.groups * WORKGROUP) {\n";

/// A workgroup computes consecutive pairs. Their rows follow each other, so its invocations share them evenly.
const CHUNK: &str = "    for (var chunk = group_index(group, groups); chunk * WORKGROUP < parameters.pairs; chunk += parameters.groups) {
    let slot = chunk * WORKGROUP + local;
    let begin = block_start[chunk * WORKGROUP];
    let end = block_start[min((chunk + 1u) * WORKGROUP, parameters.pairs)];
";

const ROWS_OF_CHUNK: &str = "    for (var row = begin + local; row < end; row += WORKGROUP) {\n";

fn vector_place(vector: u32) -> String {
    format!("parameters.vectors[{}][{}]", vector / 4, vector % 4)
}

fn number(operand: Operand, literal: &impl Fn(f64) -> String) -> String {
    match operand {
        Operand::Constant(bits) => literal(f64::from_bits(bits)),
        Operand::Parameter(number) => format!("scalars[parameters.numbers[{}][{}]]", number / 4, number % 4),
    }
}

/// Adds a loop over rows. It does `lines`, of which the first has number `first`, after the rows of a product.
fn rows(text: &mut String, head: &str, lines: &[Line], first: usize, product: Option<u32>) {
    if lines.is_empty() && product.is_none() {
        return;
    }
    text.push_str(head);
    // For each vector the variable that holds its number of this row, and whether the loop must store it.
    let mut known: Vec<Option<(String, bool)>> = vec![None; MOST_VECTORS];
    if let Some(out) = product {
        text.push_str("        let product = product_of(row);\n");
        known[out as usize] = Some(("product".into(), true));
    }
    for (k, line) in (first..).zip(lines) {
        let mut names = Vec::new();
        for vector in line.vectors {
            let (name, _) = known[vector as usize].get_or_insert_with(|| {
                let name = format!("v{vector}");
                let _ = writeln!(text, "        let {name} = vectors[at({}, row)];", vector_place(vector));
                (name, false)
            });
            names.push(name.clone());
        }
        let value = format!("row_value({}, {}, s{k}, t{k})", line.action.constant(), names.join(", "));
        if line.action.is_sum() {
            let _ = writeln!(text, "        sum{k} = join({}u, sum{k}, {value});", line.action.kind());
        } else {
            let _ = writeln!(text, "        let r{k} = {value};");
            known[line.out as usize] = Some((format!("r{k}"), true));
        }
    }
    for (vector, known) in known.iter().enumerate() {
        if let Some((name, true)) = known {
            let _ = writeln!(text, "        vectors[at({}, row)] = {name};", vector_place(vector as u32));
        }
    }
    text.push_str("    }\n");
}

impl Action {
    /// All, in their order.
    pub const ALL: [Action; 13] = [
        Action::Zero,
        Action::Copy,
        Action::CopyIf,
        Action::Combine,
        Action::Proximal,
        Action::Project,
        Action::Invert,
        Action::Dot,
        Action::Triple,
        Action::Objective,
        Action::Room,
        Action::Residual,
        Action::Largest,
    ];

    pub fn is_sum(self) -> bool {
        self >= Action::Dot
    }
}
