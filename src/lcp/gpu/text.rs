//! The text of a stage's kernel. It comes after the fragments that the kernel calls.

use super::elements::Elements;
use super::layout::MOST_VECTORS;
use super::number::Operation;
use super::shape::{Line, NumberLine, Operand, Shape, ShapeWork};
use super::stage::{Action, Block, Product, packed};
use std::fmt::Write as _;

/// A storage variable of a stage's kernel: its name, whether it is written, its element type.
pub(super) type Variable = (&'static str, bool, &'static str);

const BEGIN: &str = "@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let leads = local == 0u && group_index(group, groups) == 0u;
    let places = Places(parameters.vectors, parameters.numbers, parameters.base, parameters.looks);
";

/// In one workgroup: a confirmation is executed only after a check has ended the batch, all other work only before.
const BEGIN_ROUNDS: &str = "
// Where the vectors and numbers of each element of a round are.
var<storage, read> rounds: array<Places>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    let leads = local == 0u;
    if leads { halted = select(0u, 1u, scalars[HALT] != 0.0); }
    if workgroupUniformLoad(&halted) != parameters.looks { return; }
";

/// Work after a check that ended the batch is skipped.
const GO_ON: &str = "    if local == 0u {
        let ended = scalars[HALT];
        halted = select(0u, 1u, ended != 0.0 && ended <= real(places.looks));
    }
    if workgroupUniformLoad(&halted) != 0u { return; }
";

/// A confirmation is skipped unless a check has ended the batch.
const CONFIRM: &str = "    if local == 0u { halted = select(1u, 0u, scalars[HALT] != 0.0); }
    if workgroupUniformLoad(&halted) != 0u { return; }
";

const HALTS: &str = "    if leads && ended != 0u {
        scalars[HALT] = real(ended);
        for (var word = 0u; word < GRID_WORDS; word += 1u) { grid[word] = 0u; }
    }
    if local == 0u { halted = ended; }
    if workgroupUniformLoad(&halted) != 0u { return; }
";

/// In one workgroup, a check that ends the batch leaves the loop over the rounds.
const LEAVES: &str = "    if leads && ended != 0u { scalars[HALT] = real(ended); }
    if leads { halted = ended; }
    if workgroupUniformLoad(&halted) != 0u { break; }
";

const ALL_BODIES: &str = "invocation(group, groups, local), groups.x * groups.y * WORKGROUP";

const ALL_GROUPS: &str = "group_index(group, groups), groups.x * groups.y";

const ALL_ROWS: &str = "    for (var row = invocation(group, groups, local); row < parameters.rows; row += parameters.groups * WORKGROUP) {\n";

/// A workgroup computes the pairs whose first row is in its range of rows, which has as many rows as the workgroup has
/// invocations. A row's span is the end of its pair's rows, with a mark at the first one.
const CHUNK: &str = "    for (var chunk = group_index(group, groups); chunk * WORKGROUP < parameters.rows; chunk += parameters.groups) {
    let here = chunk * WORKGROUP;
    let next = here + WORKGROUP;
    let begin = first_from(here);
    let end = first_from(next);
    let own = here + local;
";

const ROWS_OF_WORKGROUP: &str = "    for (var row = local; row < parameters.rows; row += WORKGROUP) {\n";

const ROWS_OF_CHUNK: &str = "    for (var row = begin + local; row < end; row += WORKGROUP) {\n";

impl Shape {
    /// Its storage variables, of rows or of contacts with friction.
    pub fn variables(&self, elements: Elements) -> Vec<Variable> {
        let element = elements.name();
        let sums = self.sums() > 0;
        let makes = self.numbers.iter().any(|line| line.operation != Operation::Look);
        let mut all = vec![("scalars", makes || self.looks(), "real")];
        match &self.work {
            ShapeWork::Numbers => {}
            ShapeWork::Rows { .. } => all.push(("vectors", true, element)),
            ShapeWork::Bodies { .. } | ShapeWork::Clusters { .. } => all.push(("vectors", false, element)),
        }
        if sums || !self.taken.is_empty() {
            all.push(("partial", sums, "real"));
        }
        if self.has_block() {
            let of_blocks = match elements {
                Elements::Rows => ("entries", false, "real"),
                Elements::Contacts => ("units", false, "vec4r"),
            };
            all.extend([("span", false, "u32"), of_blocks]);
        }
        if self.gathers() {
            all.extend([("part_start", false, "u32"), ("displacement", false, "real")]);
        }
        if self.is_clusters() {
            all.extend([("entries", false, "real"), ("jacobian", false, "vec4r")]);
            all.extend([("clusters", false, "u32"), ("displacement", true, "real")]);
        }
        if self.has_product() {
            let blocks = match elements {
                Elements::Rows => "jacobian",
                Elements::Contacts => "units",
            };
            all.extend([("pair", false, "vec2<u32>"), (blocks, false, "vec4r"), ("velocity", false, "vec4r")]);
        }
        if self.is_bodies() {
            all.extend([
                ("incidence_start", false, "u32"),
                ("incidence", false, "u32"),
                ("gathered", false, "vec4r"),
                ("velocity", true, "vec4r"),
            ]);
        }
        if self.is_exact() {
            all.push(("velocity_rest", self.is_bodies(), "vec4r"));
        }
        if self.looks() {
            all.push(("grid", true, "u32"));
        }
        all
    }

    /// The declarations of its variables.
    pub fn declarations(&self, elements: Elements) -> String {
        let mut text = String::new();
        for (name, written, element) in self.variables(elements) {
            let access = if written { "read_write" } else { "read" };
            let _ = writeln!(text, "var<storage, {access}> {name}: array<{element}>;");
        }
        text
    }

    /// The kernel's entry point. `literal` writes a constant.
    pub fn entry_point(&self, elements: Elements, literal: impl Fn(f64) -> String) -> String {
        let mut text = String::from(BEGIN);
        if self.confirms {
            text.push_str(CONFIRM);
        } else if self.looks() || self.is_clusters() {
            text.push_str(GO_ON);
        }
        self.add_numbers(&mut text, &literal);
        if self.looks() {
            text.push_str(HALTS);
        }
        match &self.work {
            ShapeWork::Numbers => {}
            ShapeWork::Rows { product, gather, before, block, after } => {
                let first = match (product, gather) {
                    (Some(product), _) => First::Product(product),
                    (_, Some((condition, vectors))) => {
                        let condition = number(*condition, &literal);
                        let _ = writeln!(text, "    let gathers = {condition} > 0.0;");
                        First::Gather(*vectors)
                    }
                    (None, None) => First::Nothing,
                };
                let [before, after] = [before, after].map(|lines| &lines[..]);
                let setting = Setting::Apart(elements);
                add_rows(&mut text, setting, first, [before, after], block.as_ref(), &literal);
            }
            ShapeWork::Clusters { condition, tolerance, x, g } => {
                let [condition, tolerance] = [condition, tolerance].map(|operand| number(*operand, &literal));
                let [x, g] = [x, g].map(|vector| vector_place(*vector));
                let _ = writeln!(text, "    if local == 0u {{ halted = select(1u, 0u, {condition} > 0.0); }}");
                text.push_str("    if workgroupUniformLoad(&halted) != 0u { return; }\n");
                let _ = writeln!(text, "    run_clusters({ALL_GROUPS}, local, {x}, {g}, {tolerance});");
            }
            ShapeWork::Bodies { x, low, instead, exact } => {
                let x = vector_place(*x);
                let vector = match instead {
                    None => x,
                    Some((condition, from)) => {
                        let condition = number(*condition, &literal);
                        format!("select({x}, {}, {condition} > 0.0)", vector_place(*from))
                    }
                };
                let _ = writeln!(text, "    let vector = {vector};");
                let low = low.map_or("NONE".into(), vector_place);
                let _ = match exact {
                    true => writeln!(text, "    move_bodies_exactly(vector, {low}, {ALL_BODIES});"),
                    false => writeln!(text, "    move_bodies(vector, {ALL_BODIES});"),
                };
            }
        }
        text.push_str("}\n");
        text
    }

    /// The code that one workgroup executes for it, in the loop over the rounds of `straight_line`.
    fn element(&self, literal: &impl Fn(f64) -> String) -> String {
        let mut text = String::new();
        self.add_numbers(&mut text, literal);
        if self.looks() {
            text.push_str(LEAVES);
        }
        match &self.work {
            ShapeWork::Rows { product, before, block, after, .. } => {
                let first = product.as_ref().map_or(First::Nothing, First::Product);
                let lines = [before, after].map(|lines| &lines[..]);
                add_rows(&mut text, Setting::Resident, first, lines, block.as_ref(), literal);
            }
            ShapeWork::Bodies { x, low, exact, .. } => {
                // Zero for velocities in one part; otherwise the offset of the second part of the vector, plus one.
                let second = match (exact, low) {
                    (false, _) => "0u".into(),
                    (true, None) => "NONE".into(),
                    (true, Some(low)) => format!("{} + 1u", vector_place(*low)),
                };
                let x = vector_place(*x);
                let _ = writeln!(text, "    run_bodies({x}, {second}, parameters.bodies, local);");
            }
            ShapeWork::Numbers | ShapeWork::Clusters { .. } => {}
        }
        text
    }

    /// Takes the sums of the stage before and executes the operations; every invocation does so itself.
    fn add_numbers(&self, text: &mut String, literal: &impl Fn(f64) -> String) {
        if !self.taken.is_empty() {
            let (count, kinds) = (self.taken.len(), packed(&self.taken));
            let _ = writeln!(text, "    take_sums(local, {count}u, {kinds}u);");
        }
        if self.looks() {
            text.push_str("    var ended = 0u;\n");
        }
        for (nth, line) in self.numbers.iter().enumerate() {
            add_number(text, nth, line, literal);
        }
        let made = |line: &&NumberLine| line.operation != Operation::Look;
        if self.numbers.iter().any(|line| made(&line)) {
            text.push_str("    if leads {\n");
            for (nth, line) in self.numbers.iter().enumerate().filter(|(_, line)| made(line)) {
                let _ = writeln!(text, "        scalars[(places.base + {}u) % RING] = n{nth};", line.out);
            }
            text.push_str("    }\n");
        }
    }
}

/// Adds an operation.
fn add_number(text: &mut String, nth: usize, line: &NumberLine, literal: &impl Fn(f64) -> String) {
    let [a, b, c] = line.operands.map(|operand| number(operand, literal));
    let value = match line.operation {
        Operation::Take => format!("totals[{}]", line.sum),
        Operation::Add => format!("{a} + {b}"),
        Operation::Sub => format!("{a} - {b}"),
        Operation::Mul => format!("{a} * {b}"),
        Operation::Div => format!("{a} / {b}"),
        Operation::Neg => format!("-{a}"),
        Operation::Min => format!("smaller({a}, {b})"),
        Operation::Max => format!("larger({a}, {b})"),
        Operation::IfPositive => format!("select({c}, {b}, {a} > 0.0)"),
        Operation::Look => {
            let look = format!("places.looks + {}u", line.out);
            let _ = writeln!(text, "    if ended == 0u {{");
            let _ = writeln!(text, "        if leads {{ scalars[HALT + 1u + ({look}) % LOOKS] = {a}; }}");
            let _ = writeln!(text, "        if !({a} > {b} && is_finite({a})) {{ ended = {look} + 1u; }}");
            let _ = writeln!(text, "    }}");
            return;
        }
    };
    let _ = writeln!(text, "    let n{nth} = {value};");
}

/// The entry point of one workgroup that executes these stages in order, round after round. `literal` writes a
/// constant.
pub(super) fn straight_line(shapes: &[Shape], literal: impl Fn(f64) -> String) -> String {
    let mut text = String::from(BEGIN_ROUNDS);
    let _ = writeln!(
        text,
        "    for (var round = parameters.first; round < parameters.last; round += {}u) {{",
        shapes.len()
    );
    for (nth, shape) in shapes.iter().enumerate() {
        let _ = writeln!(text, "    {{\n    let places = rounds[round + {nth}u];");
        text.push_str(&shape.element(&literal));
        text.push_str("    }\n    fence();\n");
    }
    text.push_str("    }\n}\n");
    text
}

/// The executor of a stage: all workgroups of a dispatch, or one workgroup that also executes other stages.
#[derive(Clone, Copy, PartialEq)]
enum Setting {
    Apart(Elements),
    Resident,
}

impl Setting {
    fn elements(self) -> Elements {
        match self {
            Setting::Apart(elements) => elements,
            Setting::Resident => Elements::Rows,
        }
    }
}

/// The work on a row before all instructions.
#[derive(Clone, Copy)]
enum First<'a> {
    Nothing,
    Product(&'a Product),
    /// The sum of the clusters' displacements, or the first vector, stored in the second.
    Gather([u32; 2]),
}

/// Adds work on rows: lines before and after the instruction on whole pairs.
fn add_rows(
    text: &mut String,
    setting: Setting,
    work: First,
    [before, after]: [&[Line]; 2],
    block: Option<&Block>,
    literal: &impl Fn(f64) -> String,
) {
    let lines: Vec<&Line> = before.iter().chain(after).collect();
    for (k, line) in lines.iter().enumerate() {
        for (which, operand) in ["s", "t"].iter().zip(line.numbers) {
            let _ = writeln!(text, "    let {which}{k} = {};", number(operand, literal));
        }
        if line.action.is_sum() {
            let _ = writeln!(text, "    var sum{k} = identity({}u);", line.action.kind());
        }
    }
    match (block, setting) {
        (Some(block), _) => add_pairs(text, setting, work, [before, after], block),
        (None, Setting::Apart(elements)) => add_loop(text, elements, ALL_ROWS, (before, 0), work, None),
        (None, Setting::Resident) => add_loop(text, Elements::Rows, ROWS_OF_WORKGROUP, (before, 0), work, None),
    }
    let kinds: Vec<(usize, &&Line)> = lines.iter().enumerate().filter(|(_, line)| line.action.is_sum()).collect();
    for (k, line) in &kinds {
        let _ = writeln!(text, "    lanes[{}u * WORKGROUP + local] = sum{k};", line.out);
    }
    if !kinds.is_empty() && setting != Setting::Resident {
        let packed = packed(&kinds.iter().map(|(_, line)| line.action.kind()).collect::<Vec<_>>());
        let count = kinds.len();
        let _ = writeln!(text, "    leave_sums(group_index(group, groups), local, {count}u, {packed}u);");
    }
}

/// Adds work on rows with the small problems of the pairs in between.
fn add_pairs(text: &mut String, setting: Setting, work: First, [before, after]: [&[Line]; 2], block: &Block) {
    let unread = (![Some(block.x), block.w, block.g].contains(&Some(block.out))).then_some(block.out);
    let [w, g] = [block.w, block.g].map(|vector| vector.map_or("NONE".into(), vector_place));
    let (x, out) = (vector_place(block.x), vector_place(block.out));
    let elements = setting.elements();
    if setting == Setting::Resident {
        add_loop(text, elements, ROWS_OF_WORKGROUP, (before, 0), work, unread);
        let _ =
            writeln!(text, "    fence();\n    run_pairs({x}, {w}, {g}, {out}, parameters.pairs, local);\n    fence();");
        add_loop(text, elements, ROWS_OF_WORKGROUP, (after, before.len()), First::Nothing, None);
        return;
    }
    text.push_str(CHUNK);
    add_loop(text, elements, ROWS_OF_CHUNK, (before, 0), work, unread);
    let minimize = format!("minimize_block(own, span[own] & ~FIRST_OF_PAIR, {x}, {w}, {g}, {out})");
    let _ = writeln!(text, "    storageBarrier();\n    if begins_pair(own) {{ {minimize}; }}\n    storageBarrier();");
    add_loop(text, elements, ROWS_OF_CHUNK, (after, before.len()), First::Nothing, None);
    text.push_str("    storageBarrier();\n    }\n");
}

fn vector_place(vector: u32) -> String {
    format!("((places.vectors[{}][{}] >> {}u) & 255u)", vector / 16, vector / 4 % 4, 8 * (vector % 4))
}

fn number(operand: Operand, literal: &impl Fn(f64) -> String) -> String {
    match operand {
        Operand::Constant(bits) => literal(f64::from_bits(bits)),
        Operand::Made(nth) => format!("n{nth}"),
        Operand::Parameter(number) => {
            let place = format!("(places.numbers[{}][{}] >> {}u)", number / 8, number / 2 % 4, 16 * (number % 2));
            format!("scalars[{place} & 65535u]")
        }
    }
}

/// Adds a copy that is executed if a scalar is positive. Otherwise it reads and writes nothing, except what is read
/// later.
fn add_copy(text: &mut String, k: usize, line: &Line, known: &mut [Option<(String, bool)>], read_later: bool) {
    let value = |vector: u32| match &known[vector as usize] {
        Some((name, _)) => name.clone(),
        None => format!("vectors[at({}, row)]", vector_place(vector)),
    };
    let [from, _, _] = line.vectors;
    let (copied, kept) = (value(from), value(line.out));
    let stored = known[line.out as usize].as_ref().is_some_and(|(_, stored)| *stored);
    if read_later || stored {
        let _ = writeln!(text, "        var r{k} = {copied};");
        let _ = writeln!(text, "        if !(s{k} > 0.0) {{ r{k} = {kept}; }}");
    }
    if stored {
        known[line.out as usize] = Some((format!("r{k}"), true));
        return;
    }
    let out = vector_place(line.out);
    let _ = writeln!(text, "        if s{k} > 0.0 {{ vectors[at({out}, row)] = {copied}; }}");
    known[line.out as usize] = read_later.then(|| (format!("r{k}"), false));
}

/// Adds a loop over rows. It executes other `work`, then `lines`, the first of which has number `first`. The vector
/// `unread` is not read afterwards.
fn add_loop(
    text: &mut String,
    elements: Elements,
    head: &str,
    (lines, first): (&[Line], usize),
    work: First,
    unread: Option<u32>,
) {
    if lines.is_empty() && matches!(work, First::Nothing) {
        return;
    }
    text.push_str(head);
    if elements == Elements::Contacts {
        text.push_str("        let friction = vectors[at(INVERSE, row)];\n");
    }
    // For each vector, the variable with its value in this row, and whether the loop must store it.
    let mut known: Vec<Option<(String, bool)>> = vec![None; MOST_VECTORS];
    if let First::Gather([instead, out]) = work {
        let place = vector_place(instead);
        let _ = writeln!(text, "        var gathered = vectors[at({place}, row)];");
        text.push_str("        if gathers { gathered = sum_of_parts(row, gathered); }\n");
        known[out as usize] = Some(("gathered".into(), true));
    }
    if let First::Product(Product { out, add_q, exact }) = work {
        let product = match (exact, add_q) {
            (true, true) => "row_product_exactly(row, vectors[at(Q, row)])",
            (true, false) => "row_product_exactly(row, 0.0)",
            (false, true) => "row_product(row) + vectors[at(Q, row)]",
            (false, false) => "row_product(row)",
        };
        let _ = writeln!(text, "        let product = {product};");
        known[*out as usize] = Some(("product".into(), true));
    }
    for (at, (k, line)) in (first..).zip(lines).enumerate() {
        if line.action == Action::CopyIf {
            let read_later = lines[at + 1..].iter().any(|later| later.reads(line.out));
            add_copy(text, k, line, &mut known, read_later);
            continue;
        }
        let mut names = Vec::new();
        for (vector, read) in line.vectors.into_iter().zip(line.action.reads()) {
            if !read {
                names.push(elements.zero().into());
                continue;
            }
            let (name, _) = known[vector as usize].get_or_insert_with(|| {
                let name = format!("v{vector}");
                let _ = writeln!(text, "        let {name} = vectors[at({}, row)];", vector_place(vector));
                (name, false)
            });
            names.push(name.clone());
        }
        let value = elements.value(line, k, &names.join(", "));
        if line.action.is_sum() {
            let _ = writeln!(text, "        sum{k} = join({}u, sum{k}, {value});", line.action.kind());
        } else {
            let _ = writeln!(text, "        let r{k} = {value};");
            known[line.out as usize] = Some((format!("r{k}"), true));
        }
    }
    for (vector, known) in (0..).zip(&known) {
        if let Some((name, true)) = known
            && unread != Some(vector)
        {
            let _ = writeln!(text, "        vectors[at({}, row)] = {name};", vector_place(vector));
        }
    }
    text.push_str("    }\n");
}
