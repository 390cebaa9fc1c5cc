// The admissible multipliers: the functions of src/lcp/cone.rs. Multipliers and gaps are both in the ray x >= 0.

fn cone_project(x: real) -> real { return max(x, 0.0); }
fn cone_lack(x: real) -> real { return max(-x, 0.0); }
fn cone_admit(x: real) -> real { return select(real(0.0), x, cone_is_free(x) && is_finite(x)); }
fn cone_contains(x: real) -> bool { return x >= 0.0; }
fn cone_contains3(x: vec3r) -> bool { return all(x >= vec3r()); }
fn cone_is_free(x: real) -> bool { return x > 0.0; }
fn cone_is_bound(x: real) -> bool { return x <= 0.0; }

// Changes of multipliers: the change that moves x to the bound, and the part of a change that stays in the cone.
fn cone_change_to_bound(x: real) -> real { return -x; }
fn cone_change(change: real, x: real) -> real { return max(change, cone_change_to_bound(x)); }
fn cone_allows(change: real, x: real) -> bool { return change >= cone_change_to_bound(x); }

// A row that does not fall has no limit.
fn cone_room(x: real, d: real) -> real { return select(HUGE, x / -d, d < 0.0); }

// The natural residual.
fn cone_residual(g: real, s: real, x: real) -> real {
    let scaled = s * x;
    return select(select(g + scaled, abs(scaled), scaled < g), abs(g), g <= scaled);
}
