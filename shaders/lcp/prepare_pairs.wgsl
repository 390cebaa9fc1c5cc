// For pairs of two rows B_01 and 1 / det B. The determinant comes from what is left of one row after its part along the other is
// taken off: a c - b b would lose it where the rows are nearly parallel.
@group(0) @binding(1) var<storage, read> block_start: array<u32>;
@group(0) @binding(2) var<storage, read> pair: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> jacobian: array<vec4r>;
@group(0) @binding(4) var<storage, read_write> vectors: array<real>;

fn pair_of(row: u32) -> vec2<u32> { return pair[row]; }

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let slot = invocation(group, groups, local);
    if slot >= parameters.pairs || block_start[slot + 1u] != block_start[slot] + 2u { return; }
    let i = block_start[slot];
    let j = i + 1u;
    let a = diagonal_of_block(i);
    let c = diagonal_of_block(j);
    var b = real(0.0);
    var det = a * c;
    if alive(i) && alive(j) {
        b = entry(i, j);
        let part = b / vectors[at(DIAGONAL, i)];
        let turned = select(0u, 1u, any(pair[i] != pair[j]));
        var left = real(0.0);
        for (var side = 0u; side < 2u; side += 1u) {
            for (var k = 0u; k < WIDTH; k += 1u) {
                let other = jacobian[(2u * i + (side ^ turned)) * WIDTH + k];
                let across = jacobian[(2u * j + side) * WIDTH + k] - part * other;
                left += dot(across, across);
            }
        }
        det = vectors[at(DIAGONAL, i)] * (left + SHIFT_OF_DETERMINANT * vectors[at(DIAGONAL, j)]);
    }
    vectors[at(COUPLING, i)] = b;
    vectors[at(COUPLING, j)] = 1.0 / det;
}
