@group(0) @binding(5) var<storage, read> pair: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> jacobian: array<vec4r>;
@group(0) @binding(7) var<storage, read> velocity: array<vec4r>;

fn pair_of(row: u32) -> vec2<u32> { return pair[row]; }

fn begin_rows(first: u32, step: u32) {
    for (var row = first; row < parameters.rows; row += step) {
        let g = row_product(row);
        vectors[at(parameters.out, row)] = select(g, g + vectors[at(Q, row)], parameters.add_q != 0u);
    }
}
