// The effect of pushing pairs: their separation at the trial, and the relative motion of their bodies. In a second pass
// the first pushing pair with the largest separation. src/step/two_sided.rs has the limits.
//
// A pair pushes if its multipliers move its rows by more than the solver's tolerance. All its rows count together, and
// only its nearest separation is checked: a pair that touches at one branch and pushes at another is not detected.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> row_start: array<u32>;
var<storage, read> gamma: array<real>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read> contacts: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> report: Report;

fn pushes(p: u32) -> bool {
    var moved = real(0.0);
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        if !(gamma[row] > 0.0) { continue; }
        var square = real(0.0);
        for (var k = 0u; k < ROW_VECTORS; k += 1u) {
            let part = jacobian[ROW_VECTORS * row + k].xyz;
            square += dot(part, part);
        }
        moved += gamma[row] * square;
    }
    return moved > real(parameters.least);
}

// The separation at the trial, or a lower bound of it if this exceeds the limit. None if a body no longer has a place
// at a surface.
fn separation_of(p: u32, at_surface: bool) -> real {
    let is_far = contacts[3u * p + 2u].w == FAR;
    if !at_surface && is_far { return contacts[3u * p + 2u].x; }
    return select(contacts[3u * p].w, real(0.0), contacts[3u * p].w >= HUGE);
}

fn thickness_of(body: u32) -> real {
    return thickness(Placed(u32(shapes[body].w), shapes[body].xyz, vec4r(0.0, 0.0, 0.0, 1.0)));
}

fn radius_of(body: u32) -> real {
    return bounding_radius(Placed(u32(shapes[body].w), shapes[body].xyz, vec4r(0.0, 0.0, 0.0, 1.0)));
}

fn is_thrown(pair: vec2<u32>, at_surface: bool, thinner: real) -> bool {
    var against = -contact_move(pair.x);
    var free = length(motions[MOTION * pair.x].xyz);
    if !at_surface {
        against += contact_move(pair.y);
        free += length(motions[MOTION * pair.y].xyz);
    }
    return length(against) > THROWN * thinner + parameters.dt * free + real(parameters.start_overlap);
}

// The largest relative slide by free motions.
fn free_slide(pair: vec2<u32>, at_surface: bool) -> real {
    let a = MOTION * pair.x;
    var linear = -motions[a].xyz;
    var turned = length(motions[a + 1u].xyz) * radius_of(pair.x);
    if !at_surface {
        let b = MOTION * pair.y;
        linear += motions[b].xyz;
        turned += length(motions[b + 1u].xyz) * radius_of(pair.y);
    }
    return parameters.dt * (length(linear) + turned);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs || row_start[p] == row_start[p + 1u] { return; }
    if !pushes(p) { return; }
    let pair = pairs[p];
    let at_surface = is_surface(pair.y);
    let apart = max(separation_of(p, at_surface), real(0.0));
    let bits = bitcast<u32>(f32(apart));
    if parameters.pass_number == 2u {
        if bits > 0u && bits == atomicLoad(&report.push_gap) { atomicMin(&report.push_pair, p); }
        return;
    }
    // All invocations share these values: most do not raise the maximum.
    if bits > atomicLoad(&report.push_gap) {
        atomicMax(&report.push_gap, bits);
    }
    var thinner = thickness_of(pair.x);
    if !at_surface { thinner = min(thinner, thickness_of(pair.y)); }
    let slide = free_slide(pair, at_surface);
    if apart > GAP * thinner + slide * slide / thinner { atomicAdd(&report.apart, 1u); }
    if is_thrown(pair, at_surface, thinner) { atomicAdd(&report.thrown, 1u); }
}
