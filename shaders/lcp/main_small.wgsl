// A whole batch of a small problem in one workgroup: turn after turn, with barriers inside.
@group(0) @binding(1) var<storage, read> program: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> scalars: array<real>;
@group(0) @binding(3) var<storage, read_write> vectors: array<real>;
@group(0) @binding(4) var<storage, read_write> velocity: array<vec4r>;
@group(0) @binding(5) var<storage, read> jacobian: array<vec4r>;
// The pairs, where their rows begin, where the bodies' lists begin, and those lists.
@group(0) @binding(6) var<storage, read> lists: array<u32>;

var<workgroup> totals: array<real, REDUCTIONS>;

fn number(place: u32) -> real { return numbers[place]; }
fn taken(reduction: u32) -> real { return totals[reduction]; }
fn pair_of(row: u32) -> vec2<u32> { return vec2<u32>(lists[2u * row], lists[2u * row + 1u]); }
fn block_start(slot: u32) -> u32 { return lists[2u * parameters.rows + slot]; }

fn run_rows(begin: u32, end: u32, local: u32) {
    for (var place = begin; place < end; place += 2u) {
        let i = instruction(place);
        let kind = reduction_kind(i.what);
        var sum = identity(kind);
        for (var row = local; row < parameters.rows; row += WORKGROUP) {
            sum = join(kind, sum, run_row(i, row));
        }
        if i.what >= DOT {
            lanes[i.out * WORKGROUP + local] = sum;
        }
    }
}

// Where a body's entries stand among the lists.
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

fn run_product(out: u32, add_q: u32, rows: u32, local: u32) {
    for (var row = local; row < rows; row += WORKGROUP) {
        vectors[at(out, row)] = product_of(row, select(real(0.0), vectors[at(Q, row)], add_q != 0u));
    }
}

fn fence() {
    workgroupBarrier();
    storageBarrier();
}

// A turn does one of each kind, in this order; a driver that runs all branches does little in vain so.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    for (var place = local; place < NUMBERS; place += WORKGROUP) {
        numbers[place] = scalars[place];
    }
    if local == 0u {
        halted = select(0u, 1u, scalars[HALT] != 0.0);
    }
    for (var place = parameters.first; place < parameters.last; place += 4u) {
        // What confirms a look is done only after one that ended the batch.
        if workgroupUniformLoad(&halted) != min(parameters.looks, 1u) { break; }
        // Instructions before and after.
        let rows = program[place];
        // The instruction for pairs, and their number; whether a product is a gradient.
        let blocks = program[place + 1u];
        // A product: bodies, their vector, rows, their result.
        let product = program[place + 2u];
        // Operations on numbers, kinds of sums; the second part of the product's vector.
        let finish = program[place + 3u];
        // Once in the text for both, which halves what a driver makes of it.
        for (var half = 0u; half < 2u; half += 1u) {
            let span = select(rows.xy, rows.zw, half == 1u);
            run_rows(span.x, span.y, local);
            if half == 1u { break; }
            fence();
            run_pairs(blocks.x, blocks.y, local);
            fence();
            run_bodies(product.y, finish.w, product.x, local);
            fence();
            run_product(product.w, blocks.z, product.z, local);
            fence();
        }
        if finish.x < finish.y {
            reduce(local, finish.z);
            if local < REDUCTIONS {
                totals[local] = total(local, finish.z);
            }
            workgroupBarrier();
            if local == 0u {
                run_numbers(finish.x, finish.y);
            }
        }
        fence();
    }
    workgroupBarrier();
    for (var place = local; place < NUMBERS; place += WORKGROUP) {
        scalars[place] = numbers[place];
    }
}
