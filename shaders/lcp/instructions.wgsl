// One instruction on one row: its value from up to three vectors and two scalars. Instructions from DOT on are reduced
// over all rows.

fn reduction_kind(instruction: u32) -> u32 {
    return select(select(SUM, LEAST, instruction == ROOM), WORST, instruction >= RESIDUAL);
}

fn row_value(instruction: u32, a: real, b: real, c: real, s: real, t: real) -> real {
    switch instruction {
        case ZERO: { return real(0.0); }
        case COPY: { return a; }
        case COPY_IF: { return select(c, a, s > 0.0); }
        case COMBINE: { return s * a + t * b; }
        case PROXIMAL: { return cone_project(a - s * b * c); }
        case ADVANCE: { return cone_project(advanced(a, b, s)); }
        case ADVANCE_LOW: { return left_off(a, b, c, s); }
        case INVERT: { return select(real(0.0), 1.0 / b, a > s); }
        case DOT: { return a * b; }
        case TRIPLE: { return c * a * b; }
        case OBJECTIVE: { return a * (b + c); }
        case ROOM: { return cone_room(a, b); }
        // Of x = a, g = b, s = c.
        case RESIDUAL: { return cone_residual(b, c, a); }
        case LARGEST: { return abs(a); }
        default: { return not_a_number(); }
    }
}
