// The smaller and the larger of two numbers. One that is not finite loses against one that is.
fn smaller(a: real, b: real) -> real { return select(select(select(b, a, a < b), a, !is_finite(b)), b, !is_finite(a)); }
fn larger(a: real, b: real) -> real { return select(select(select(b, a, a > b), a, !is_finite(b)), b, !is_finite(a)); }
