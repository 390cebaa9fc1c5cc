// Operations on numbers, one after the other, in a copy of them in workgroup memory.

var<workgroup> numbers: array<real, NUMBERS>;
var<workgroup> halted: u32;

fn operate(what: u32, a: real, b: real, c: real) -> real {
    switch what {
        case ADD: { return a + b; }
        case SUB: { return a - b; }
        case MUL: { return a * b; }
        case DIV: { return a / b; }
        case NEG: { return -a; }
        case MIN: { return smaller(a, b); }
        case MAX: { return larger(a, b); }
        case IF_POSITIVE: { return select(c, b, a > 0.0); }
        case TAKE, LOOK: { return a; }
        default: { return not_a_number(); }
    }
}

// By one invocation. A look whose residual is at most the tolerance, or not finite, ends the program.
fn run_numbers(first: u32, last: u32) {
    for (var place = first; place < last; place += 1u) {
        let i = program[place];
        let what = i.x & 255u;
        let out = i.x >> 8u;
        if what == TAKE {
            numbers[out] = taken(i.y);
            continue;
        }
        let a = numbers[i.y];
        let b = numbers[i.z];
        if what == LOOK {
            numbers[out] = a;
            if a > b && is_finite(a) { continue; }
            halted = 1u;
            numbers[HALT] = real(i.w);
            break;
        }
        numbers[out] = operate(what, a, b, numbers[i.w]);
    }
}
