// One instruction on one contact: its numbers from up to three vectors and a scalar. What is reduced over all contacts
// is the first number. `friction` has a contact's coefficient, the most part of a change of its correction that is
// made, the scale of its block, and whether its normal row feels its multiplier.

// The law's residual: with mu |s| in place of the correction.
fn law_residual(x: vec3r, g: vec3r, friction: vec4r, correction: real) -> real {
    if friction.x == 0.0 { return join(WORST, friction_residual(x, g, friction.x, friction.z), -g.x); }
    let exact = vec3r(g.x + (friction.x * tangential(g) - correction), g.y, g.z);
    // A cone that is wide open shows little of an overlap.
    return join(WORST, friction_residual(x, exact, friction.x, friction.z), correction - g.x);
}

// A contact's correction: its offset, the part of a change that is made next, the last change wanted, and by how much
// the offset moved. Before the first time the part is zero.
fn followed(old: vec4r, g: vec3r, friction: vec4r) -> vec4r {
    let change = friction.x * tangential(g) - old.x;
    var part = real(1.0);
    var last = real(0.0);
    if old.y > 0.0 {
        let turned = change * old.z < 0.0;
        part = select(min(GROWTH * old.y, friction.y), max(0.5 * old.y, SMALLEST), turned);
        last = change;
    }
    let offset = max(old.x + part * change, real(0.0));
    return vec4r(offset, part, last, offset - old.x);
}

fn one(x: real) -> vec4r { return vec4r(x, 0.0, 0.0, 0.0); }

fn unit_value(instruction: u32, a: vec4r, b: vec4r, c: vec4r, s: real, t: real, friction: vec4r) -> vec4r {
    switch instruction {
        case ZERO: { return vec4r(); }
        case COPY: { return a; }
        case COPY_IF: { return select(c, a, s > 0.0); }
        case COMBINE: { return s * a + t * b; }
        case ADVANCE: { return vec4r(friction_project((a + s * b).xyz, friction.x), 0.0); }
        // A contact whose normal row does not feel its multiplier stays as it is.
        case INVERT: { return vec4r(b.xyz, select(real(0.0), real(1.0), a.x > s)); }
        case DOT: { return one(dot(a, b)); }
        case ROOM: { return one(friction_room(a.xyz, b.xyz, friction.x)); }
        // Of x = a, g = b and the correction c.
        case RESIDUAL: { return one(law_residual(a.xyz, b.xyz, friction, c.x)); }
        case LARGEST: { return one(max(abs(a.x), max(abs(a.y), abs(a.z)))); }
        case COMPLY: { return a + c * b; }
        case FOLLOW: {
            if s > 0.0 && friction.x > 0.0 { return followed(a, b.xyz, friction); }
            return vec4r(a.xyz, 0.0);
        }
        case CORRECT: { return vec4r(a.x + b.w, a.yzw); }
        case RESIDUAL_HELD: { return one(friction_residual(a.xyz, b.xyz, friction.x, friction.z)); }
        case OFF: { return one(abs(friction.x * tangential(a.xyz) - b.x)); }
        case PROXIMAL, ADVANCE_LOW, TRIPLE, OBJECTIVE: { return one(not_a_number()); }
        default: { return one(not_a_number()); }
    }
}
