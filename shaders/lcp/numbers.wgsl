// Operations on scalars, one after the other. `numbers_in_workgroup.wgsl` or `numbers_in_storage.wgsl` defines their
// memory.

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

// By one invocation. A check whose residual is at most the tolerance, or not finite, ends the program.
fn run_numbers(first: u32, last: u32) {
    for (var place = first; place < last; place += 1u) {
        let i = program[place];
        let what = i.x & 255u;
        let out = i.x >> 8u;
        if what == TAKE {
            keep(out, totals[i.y]);
            continue;
        }
        let a = number(i.y);
        let b = number(i.z);
        if what == LOOK {
            keep(out, a);
            if a > b && is_finite(a) { continue; }
            halted = 1u;
            keep(HALT, real(i.w));
            break;
        }
        keep(out, operate(what, a, b, number(i.w)));
    }
}
