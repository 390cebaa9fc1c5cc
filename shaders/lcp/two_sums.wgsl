// Sums and products with their rounding errors. T. J. Dekker, Numerische Mathematik 18 (1971); D. E. Knuth, The Art
// of Computer Programming 2, 4.2.2.

// The same number, opaque to the compiler: drivers simplify (a + b) - a to b.
fn steady(x: real) -> real { return bitcast<f32>(bitcast<u32>(x) ^ parameters.zero); }
fn steady4(x: vec4r) -> vec4r { return bitcast<vec4<f32>>(bitcast<vec4<u32>>(x) ^ vec4<u32>(parameters.zero)); }

// The rounding error of the sum of two numbers, and of four of them.
fn sum_error(a: real, b: real, sum: real) -> real {
    let part = steady(sum - a);
    return steady(a - steady(sum - part)) + steady(b - part);
}

fn sum_error4(a: vec4r, b: vec4r, sum: vec4r) -> vec4r {
    let part = steady4(sum - a);
    return steady4(a - steady4(sum - part)) + steady4(b - part);
}

// Twelve bits of the mantissa: products of two such numbers, and of their remainders, are exact.
fn upper(a: real) -> real { return bitcast<f32>(bitcast<u32>(a) & 0xfffff000u); }
fn upper4(a: vec4r) -> vec4r { return bitcast<vec4<f32>>(bitcast<vec4<u32>>(a) & vec4<u32>(0xfffff000u)); }

// The rounding error of a product.
fn product_error(a: real, b: real, product: real) -> real {
    let a_upper = upper(a);
    let b_upper = upper(b);
    let a_lower = a - a_upper;
    let b_lower = b - b_upper;
    return ((a_upper * b_upper - product) + a_upper * b_lower + a_lower * b_upper) + a_lower * b_lower;
}

fn product_error4(a: vec4r, b: vec4r, product: vec4r) -> vec4r {
    let a_upper = upper4(a);
    let b_upper = upper4(b);
    let a_lower = a - a_upper;
    let b_lower = b - b_upper;
    return ((a_upper * b_upper - product) + a_upper * b_lower + a_lower * b_upper) + a_lower * b_lower;
}

fn advanced(a: real, d: real, s: real) -> real { return steady(a + steady(s * d)); }

// The rounding error of x in two parts (a, c) after x = cone_project(x + s d).
fn left_off(a: real, d: real, c: real, s: real) -> real {
    let step = steady(s * d);
    let sum = steady(a + step);
    return select(real(0.0), c + (sum_error(a, step, sum) + product_error(s, d, step)), cone_is_free(sum));
}
