// What one workgroup does once in a solve, read from a program: turn after turn, with barriers inside.
var<storage, read> program: array<vec4<u32>>;

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

fn run_product(out: u32, add_q: u32, rows: u32, local: u32) {
    for (var row = local; row < rows; row += WORKGROUP) {
        vectors[at(out, row)] = product_of(row, select(real(0.0), vectors[at(Q, row)], add_q != 0u));
    }
}

// A turn does one of each kind, in this order, so a driver that executes all branches wastes little.
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    take_up_numbers(local);
    if local == 0u {
        halted = select(0u, 1u, scalars[HALT] != 0.0);
    }
    for (var place = parameters.first; place < parameters.last; place += 4u) {
        // Work that confirms a check is done only after a check that ended the batch.
        if workgroupUniformLoad(&halted) != min(parameters.looks, 1u) { break; }
        // Instructions before and after.
        let rows = program[place];
        // The instruction for pairs, and their number; whether a product is a gradient.
        let blocks = program[place + 1u];
        // A product: bodies, their vector, rows, their result.
        let product = program[place + 2u];
        // Operations on scalars, kinds of sums; the second part of the product's vector.
        let finish = program[place + 3u];
        run_rows(rows.x, rows.y, local);
        fence();
        run_block(blocks.x, blocks.y, local);
        fence();
        run_bodies(product.y, finish.w, product.x, local);
        fence();
        run_product(product.w, blocks.z, product.z, local);
        fence();
        run_rows(rows.z, rows.w, local);
        if finish.x < finish.y {
            take_sums(local, REDUCTIONS, finish.z);
            if local == 0u {
                run_numbers(finish.x, finish.y);
            }
        }
        fence();
    }
    leave_numbers(local);
}
