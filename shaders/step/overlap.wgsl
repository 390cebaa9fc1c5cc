// The largest overlap of all pairs and the number of violations; in a second pass the first pair with this overlap, and
// in a third, with one invocation, its bodies. All invocations share the report: each workgroup changes it once, and
// writes only a maximum or minimum that improves it.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> contacts: array<vec4r>;
var<storage, read_write> report: Report;

var<workgroup> group_worst: atomic<u32>;
var<workgroup> group_violations: atomic<u32>;

// Bits of a pair's overlap, zero without overlap.
fn overlap_of(p: u32) -> u32 {
    if p >= parameters.pairs || contacts[3u * p + 2u].w == 0.0 { return 0u; }
    let overlap = f32(-contacts[3u * p].w);
    if !(overlap > 0.0) { return 0u; }
    return bitcast<u32>(overlap);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if parameters.pass_number == 3u {
        let worst = atomicLoad(&report.worst_pair);
        if p == 0u && worst < parameters.pairs {
            report.worst_a = pairs[worst].x;
            report.worst_b = pairs[worst].y;
        }
        return;
    }
    let bits = overlap_of(p);
    if parameters.pass_number == 2u {
        if bits > 0u && bits == atomicLoad(&report.worst) && p < atomicLoad(&report.worst_pair) {
            atomicMin(&report.worst_pair, p);
        }
        return;
    }
    if local == 0u {
        atomicStore(&group_worst, 0u);
        atomicStore(&group_violations, 0u);
    }
    workgroupBarrier();
    if bits > atomicLoad(&group_worst) {
        atomicMax(&group_worst, bits);
    }
    if bits > 0u && contacts[3u * p + 2u].w >= VIOLATING {
        atomicAdd(&group_violations, 1u);
    }
    workgroupBarrier();
    if local > 0u { return; }
    if atomicLoad(&group_worst) > atomicLoad(&report.worst) {
        atomicMax(&report.worst, atomicLoad(&group_worst));
    }
    if atomicLoad(&group_violations) > 0u {
        atomicAdd(&report.violations, atomicLoad(&group_violations));
    }
}
