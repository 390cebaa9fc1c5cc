// 64-bit floats have one part.
fn advanced(a: real, d: real, s: real) -> real { return a + s * d; }
fn left_off(a: real, d: real, c: real, s: real) -> real { return 0.0; }
