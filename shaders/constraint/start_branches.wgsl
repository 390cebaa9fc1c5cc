// The starting multipliers of staged rows. A first row starts from the multiplier that its branch had at the end of the
// last part of a step; the multipliers of branches without a row go to the pair's nearest row. Other rows start from
// zero.

var<storage, read> row_start: array<u32>;
var<storage, read> staged: array<vec4r>;
var<storage, read> remembered: array<real>;
var<storage, read_write> gamma: array<real>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    var nearest = NONE;
    var least = real(0.0);
    var own = 0u;
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        let made = u32(staged[3u * row + 2u].w);
        if made == 0u { continue; }
        if nearest == NONE || staged[3u * row].w < least {
            nearest = row;
            least = staged[3u * row].w;
        }
        own |= 1u << (made - 1u);
        gamma[row] = 0.0;
        if parameters.first > 0u {
            gamma[row] = remembered[BRANCHES * p + made - 1u];
        }
    }
    if parameters.first == 0u || nearest == NONE { return; }
    var rest = real(0.0);
    for (var k = 0u; k < BRANCHES; k += 1u) {
        if (own & (1u << k)) == 0u { rest += remembered[BRANCHES * p + k]; }
    }
    gamma[nearest] += rest;
}
