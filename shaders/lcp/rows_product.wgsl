// The row half of a product, after the bodies' half.
@group(0) @binding(4) var<storage, read> pair: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> jacobian: array<vec4r>;
@group(0) @binding(6) var<storage, read> velocity: array<vec4r>;

fn pair_of(row: u32) -> vec2<u32> { return pair[row]; }

fn product_of(row: u32) -> real {
    let g = row_product(row);
    return select(g, g + vectors[at(Q, row)], parameters.add_q != 0u);
}
