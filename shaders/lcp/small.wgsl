// What one workgroup needs for a small problem.
var<storage, read_write> scalars: array<real>;
var<storage, read_write> vectors: array<real>;
var<storage, read_write> velocity: array<vec4r>;
var<storage, read> jacobian: array<vec4r>;
// The pairs, where their rows begin, where the bodies' lists begin, and those lists.
var<storage, read> lists: array<u32>;

var<workgroup> totals: array<real, REDUCTIONS>;
var<workgroup> halted: u32;

fn pair_of(row: u32) -> vec2<u32> { return vec2<u32>(lists[2u * row], lists[2u * row + 1u]); }
fn block_start(slot: u32) -> u32 { return lists[2u * parameters.rows + slot]; }

fn fence() {
    workgroupBarrier();
    storageBarrier();
}

// Reduces the partial sums of the previous work.
fn take_sums(local: u32, count: u32, kinds: u32) {
    reduce(local, kinds);
    if local < count { totals[local] = total(local, kinds); }
    workgroupBarrier();
}

// The range of a body's entries in the lists.
fn entries_of(body: u32) -> vec2<u32> {
    let starts = 2u * parameters.rows + parameters.pairs + 1u;
    let incidence = starts + parameters.bodies + 1u;
    return vec2<u32>(incidence + lists[starts + body], incidence + lists[starts + body + 1u]);
}

fn move_body_plainly(body: u32, x: u32) {
    let span = entries_of(body);
    var sum = vec4r();
    var turn = vec4r();
    for (var place = span.x; place < span.y; place += 1u) {
        let block = lists[place];
        let number = vectors[at(x, block / 2u)];
        sum += number * jacobian[block * WIDTH];
        if WIDTH == 2u {
            turn += number * jacobian[block * WIDTH + 1u];
        }
    }
    velocity[body * WIDTH] = sum;
    if WIDTH == 2u {
        velocity[body * WIDTH + 1u] = turn;
    }
}

fn run_bodies(x: u32, second: u32, bodies: u32, local: u32) {
    for (var body = local; body < bodies; body += WORKGROUP) {
        move_body(body, x, second);
    }
}
