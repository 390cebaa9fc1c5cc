// A whole batch of a small problem in one workgroup: stage after stage, with barriers between them.
@group(0) @binding(1) var<storage, read> program: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> scalars: array<real>;
@group(0) @binding(3) var<storage, read_write> vectors: array<real>;
@group(0) @binding(4) var<storage, read_write> velocity: array<vec4r>;
@group(0) @binding(5) var<storage, read> jacobian: array<vec4r>;
// The pairs, where their rows begin, where the bodies' lists begin, and those lists.
@group(0) @binding(6) var<storage, read> lists: array<u32>;

const ROWS_STAGE: u32 = 0u;
const PAIRS_STAGE: u32 = 1u;
const BODIES_STAGE: u32 = 2u;
const PRODUCT_STAGE: u32 = 3u;
const FINISH_STAGE: u32 = 4u;

var<workgroup> totals: array<real, REDUCTIONS>;

fn number(place: u32) -> real { return numbers[place]; }
fn taken(reduction: u32) -> real { return totals[reduction]; }
fn pair_of(row: u32) -> vec2<u32> { return vec2<u32>(lists[2u * row], lists[2u * row + 1u]); }
fn block_start(slot: u32) -> u32 { return lists[2u * parameters.rows + slot]; }

fn run_stage(kind: u32, begin: u32, end: u32, x: u32, out: u32, add_q: u32, local: u32) {
    if kind == ROWS_STAGE {
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
    } else if kind == BODIES_STAGE {
        let starts = 2u * parameters.rows + parameters.pairs + 1u;
        let incidence = starts + parameters.bodies + 1u;
        for (var body = local; body < parameters.bodies; body += WORKGROUP) {
            let last = lists[starts + body + 1u];
            var sum = vec4r();
            var turn = vec4r();
            for (var place = lists[starts + body]; place < last; place += 1u) {
                let block = lists[incidence + place];
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
    } else if kind == PRODUCT_STAGE {
        for (var row = local; row < parameters.rows; row += WORKGROUP) {
            let g = row_product(row);
            vectors[at(out, row)] = select(g, g + vectors[at(Q, row)], add_q != 0u);
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    for (var place = local; place < NUMBERS; place += WORKGROUP) {
        numbers[place] = scalars[place];
    }
    if local == 0u {
        halted = select(0u, 1u, scalars[HALT] != 0.0);
    }
    for (var place = parameters.first; place < parameters.last; place += 2u) {
        if workgroupUniformLoad(&halted) != 0u { break; }
        let stage = program[place];
        let more = program[place + 1u];
        if stage.x == FINISH_STAGE {
            reduce(local, more.x);
            if local < REDUCTIONS {
                totals[local] = total(local, more.x);
            }
            workgroupBarrier();
            if local == 0u {
                run_numbers(stage.y, stage.z);
            }
        } else {
            run_stage(stage.x, stage.y, stage.z, more.x, more.y, more.z, local);
            run_pairs(stage.x, stage.y, local);
        }
        storageBarrier();
    }
    workgroupBarrier();
    for (var place = local; place < NUMBERS; place += WORKGROUP) {
        scalars[place] = numbers[place];
    }
}
