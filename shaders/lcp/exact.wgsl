// Sums of products in two parts: `rest` accumulates the rounding errors of products and sums.
struct TwoParts {
    value: vec4r,
    rest: vec4r,
}

// sum + a (x + low).
fn add_product(sum: TwoParts, a: vec4r, x: vec4r, low: vec4r) -> TwoParts {
    let product = steady4(a * x);
    let value = steady4(sum.value + product);
    let lost = sum_error4(sum.value, product, value) + product_error4(a, x, product);
    return TwoParts(value, sum.rest + (lost + a * low));
}

// The same number with its value correctly rounded.
fn rounded(sum: TwoParts) -> TwoParts {
    let value = steady4(sum.value + sum.rest);
    return TwoParts(value, sum.rest - steady4(value - sum.value));
}

// q plus the four numbers of a sum.
fn all_of(q: real, sum: TwoParts) -> real {
    var value = q;
    var rest = real(0.0);
    for (var k = 0u; k < 4u; k += 1u) {
        let next = steady(value + sum.value[k]);
        rest += sum_error(value, sum.value[k], next) + sum.rest[k];
        value = next;
    }
    return value + rest;
}
