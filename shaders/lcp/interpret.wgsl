// Instructions that one workgroup reads from the program.
struct Instruction {
    what: u32,
    out: u32,
    a: u32,
    b: u32,
    c: u32,
    s: real,
    t: real,
}

fn instruction(place: u32) -> Instruction {
    let i = program[place];
    let j = program[place + 1u];
    return Instruction(i.x, i.y, i.z, i.w, j.x, number(j.y), number(j.z));
}

// One instruction on a row. Returns the value to reduce.
fn run_row(i: Instruction, row: u32) -> real {
    let value = row_value(i.what, vectors[at(i.a, row)], vectors[at(i.b, row)], vectors[at(i.c, row)], i.s, i.t);
    if i.what < DOT {
        vectors[at(i.out, row)] = value;
    }
    return value;
}
