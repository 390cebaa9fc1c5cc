// Sums of products in two floats, for gradients made afresh: `rest` adds up the error of each product and of each sum.
// T. J. Dekker, Numerische Mathematik 18 (1971); D. E. Knuth, The Art of Computer Programming 2, 4.2.2.
struct TwoParts {
    value: vec4r,
    rest: vec4r,
}

// Twelve bits of the mantissa: products of two such numbers, and of what is left of them, are exact.
fn upper(a: vec4r) -> vec4r { return bitcast<vec4<f32>>(bitcast<vec4<u32>>(a) & vec4<u32>(0xfffff000u)); }

// sum + a (x + low).
fn add_product(sum: TwoParts, a: vec4r, x: vec4r, low: vec4r) -> TwoParts {
    let product = a * x;
    let a_upper = upper(a);
    let x_upper = upper(x);
    let a_lower = a - a_upper;
    let x_lower = x - x_upper;
    let error = ((a_upper * x_upper - product) + a_upper * x_lower + a_lower * x_upper) + a_lower * x_lower;
    let value = sum.value + product;
    let part = value - sum.value;
    let lost = (sum.value - (value - part)) + (product - part);
    return TwoParts(value, sum.rest + (lost + error + a * low));
}

// The value and the rest, so that the value is as near as can be.
fn rounded(sum: TwoParts) -> TwoParts {
    let value = sum.value + sum.rest;
    return TwoParts(value, sum.rest - (value - sum.value));
}

// q and the four parts of a sum.
fn all_of(q: real, sum: TwoParts) -> real {
    var value = q;
    var rest = real(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let next = value + sum.value[k];
        let part = next - value;
        rest += (value - (next - part)) + (sum.value[k] - part) + sum.rest[k];
        value = next;
    }
    return value + rest;
}
