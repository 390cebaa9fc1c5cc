// The nearest integers, the even ones at ties, from floor alone. A software adapter on some processors computes round()
// of f64 with a half that it rounded to f32: values within 3e-8 above a half give the wrong integer.
fn nearest_integer(x: vec3r) -> vec3r {
    let below = floor(x);
    let past = x - below;
    let half = vec3r(0.5);
    let odd = floor(half * below) != half * below;
    return select(below, below + vec3r(1.0), (past > half) | ((past == half) & odd));
}
