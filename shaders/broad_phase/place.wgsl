// The column of every body, and the number of bodies in each column.
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> classes: array<u32>;
var<storage, read> survey: array<u32>;
var<storage, read_write> columns: array<u32>;
var<storage, read_write> members: array<u32>;
var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.bodies { return; }
    var level = 0u;
    if classes[i] > 0u { level = level_of(survey[CLASSES], classes[i]); }
    let cell = grid_cell(cells[i].xyz, level);
    let column = (row(level, cell.y, cell.z) + bitcast<u32>(cell.x)) & parameters.mask;
    columns[i] = column;
    members[i] = i | (level << LEVEL_SHIFT);
    atomicAdd(&counts[column], 1u);
}
