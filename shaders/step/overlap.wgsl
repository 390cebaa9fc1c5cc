// The largest overlap of all pairs and how many violate the tolerance; in a second pass the first pair that overlaps by
// that much, and in a third, of one invocation, its bodies.

struct Parameters { pairs: u32, pass_number: u32, b: u32, c: u32 }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> contacts: array<vec4r>;
@group(0) @binding(3) var<storage, read_write> report: Report;

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
    if p >= parameters.pairs || contacts[3u * p + 2u].w == 0.0 { return; }
    let overlap = f32(-contacts[3u * p].w);
    if !(overlap > 0.0) { return; }
    let bits = bitcast<u32>(overlap);
    if parameters.pass_number == 1u {
        atomicMax(&report.worst, bits);
        if contacts[3u * p + 2u].w >= VIOLATING {
            atomicAdd(&report.violations, 1u);
        }
    } else if bits == atomicLoad(&report.worst) {
        atomicMin(&report.worst_pair, p);
    }
}
