// A few steps of conjugate gradients in the local LCP of a cluster, by one workgroup: the minimum of
// g . d + 1/2 |J^T d|^2 over x + d >= 0, from d = 0, with a compliance. It is the method of src/lcp/pair_block_cg.rs.
// Every invocation has two rows, whose vectors it keeps itself; workgroup memory has the data that other invocations
// need.
//
// The words in `clusters`: for every cluster the offsets and the numbers of its rows, pairs and bodies; for every row
// its index, its bodies, and the position of its displacement; for every pair its first row and its number of rows,
// pairs with one row first, because invocations of a group with the same work do not wait for each other; for every
// body the offset of its list of rows, and these lists.

// Vectors in `lanes`, each of MOST_ROWS numbers. Six sums at once overwrite all except the last.
const STEEP: u32 = 0u;
const STEP: u32 = 1u;
const START: u32 = 3u;

const MOST_ROWS: u32 = 2u * WORKGROUP;
const UNKNOWNS: u32 = 3u * WIDTH;
const CLUSTER_WORDS: u32 = 6u;
const ROW_WORDS: u32 = 3u;
// A side without mobility.
const NO_BODY: u32 = 255u;

var<workgroup> row_of: array<u32, MOST_ROWS>;
var<workgroup> body_velocity: array<real, MOST_BODIES * UNKNOWNS>;
var<workgroup> found: array<real, REDUCTIONS>;
var<workgroup> awake: u32;

struct Cluster {
    rows_at: u32,
    rows: u32,
    pairs_at: u32,
    pairs: u32,
    bodies_at: u32,
    bodies: u32,
}

fn cluster_at(nth: u32) -> Cluster {
    let at_rows = CLUSTER_WORDS * nth;
    let at_pairs = at_rows + 2u;
    let at_bodies = at_rows + 4u;
    return Cluster(
        clusters[at_rows],
        clusters[at_rows + 1u],
        clusters[at_pairs],
        clusters[at_pairs + 1u],
        clusters[at_bodies],
        clusters[at_bodies + 1u],
    );
}

// The two rows of an invocation.
struct Own {
    row: vec2<u32>,
    is_there: vec2<bool>,
    sides: vec2<u32>,
    place: vec2<u32>,
}

fn own_rows(c: Cluster, local: u32) -> Own {
    let nth = vec2<u32>(local, local + WORKGROUP);
    let is_there = nth < vec2<u32>(c.rows);
    let word = select(vec2<u32>(c.rows_at), c.rows_at + ROW_WORDS * nth, is_there);
    let row = vec2<u32>(clusters[word.x], clusters[word.y]);
    let sides = vec2<u32>(clusters[word.x + 1u], clusters[word.y + 1u]);
    let place = vec2<u32>(clusters[word.x + 2u], clusters[word.y + 2u]);
    return Own(row, is_there, sides, place);
}

fn numbers_of(own: Own, vector: u32) -> vec2r {
    return select(vec2r(), vec2r(vectors[at(vector, own.row.x)], vectors[at(vector, own.row.y)]), own.is_there);
}

fn taken_of(own: Own, vector: u32, local: u32) -> vec2r {
    let numbers = vec2r(held(vector, local), held(vector, local + WORKGROUP));
    return select(vec2r(), numbers, own.is_there);
}

fn share(vector: u32, local: u32, numbers: vec2r) {
    hold(vector, local, numbers.x);
    hold(vector, local + WORKGROUP, numbers.y);
}

// One of the sums of `bring`.
fn leave(sum: u32, local: u32, number: real) { lanes[sum * WORKGROUP + local] = number; }

fn bring(local: u32, count: u32, kinds: u32) {
    reduce(local, kinds);
    if local < count { found[local] = total(local, kinds); }
    workgroupBarrier();
}

fn minimize_pairs(c: Cluster, local: u32, w: u32, g: u32) {
    workgroupBarrier();
    for (var nth = local; nth < c.pairs; nth += WORKGROUP) {
        let word = clusters[c.pairs_at + nth];
        let first = word & 65535u;
        minimize_block(first, first + (word >> 16u), START, w, g, STEP);
    }
    workgroupBarrier();
}

// J^T d for d in STEP.
fn move_cluster(c: Cluster, local: u32) {
    for (var body = local; body < c.bodies; body += WORKGROUP) {
        let last = clusters[c.bodies_at + body + 1u];
        var sum = vec3r();
        var turn = vec3r();
        for (var place = clusters[c.bodies_at + body]; place < last; place += 1u) {
            let entry = clusters[place];
            let number = held(STEP, entry / 2u);
            let block = (2u * row_of[entry / 2u] + entry % 2u) * WIDTH;
            sum += number * jacobian[block].xyz;
            if WIDTH == 2u { turn += number * jacobian[block + 1u].xyz; }
        }
        for (var k = 0u; k < 3u; k += 1u) {
            body_velocity[body * UNKNOWNS + k] = sum[k];
            if WIDTH == 2u { body_velocity[body * UNKNOWNS + 3u + k] = turn[k]; }
        }
    }
}

fn side_product(block: u32, body: u32) -> real {
    if body == NO_BODY { return 0.0; }
    var sum = real(0.0);
    for (var k = 0u; k < WIDTH; k += 1u) {
        let at_body = body * UNKNOWNS + 3u * k;
        let moved = vec3r(body_velocity[at_body], body_velocity[at_body + 1u], body_velocity[at_body + 2u]);
        sum += dot(jacobian[block * WIDTH + k].xyz, moved);
    }
    return sum;
}

fn local_product(row: u32, sides: u32) -> real {
    return side_product(2u * row, sides & 255u) + side_product(2u * row + 1u, (sides >> 8u) & 255u);
}

fn products(own: Own) -> vec2r {
    let both = vec2r(local_product(own.row.x, own.sides.x), local_product(own.row.y, own.sides.y));
    return select(vec2r(), both, own.is_there);
}

struct Direction {
    displacement: vec2r,
    product: vec2r,
    curvature: real,
}

// The parts of two earlier displacements in the next one, from the six sums.
fn parts_of(d: Direction, e: Direction) -> vec2r {
    let right = -vec2r(found[0] + found[1], found[2] + found[3]);
    let across = found[4];
    let diagonal = vec2r(d.curvature, e.curvature) * SHIFT_OF_DIRECTIONS;
    let det = diagonal.x * diagonal.y - across * across;
    if det > 0.0 {
        return vec2r(right.x * diagonal.y - right.y * across, right.y * diagonal.x - right.x * across) / det;
    }
    return vec2r(select(real(0.0), right.x / diagonal.x, d.curvature > 0.0), 0.0);
}

// The displacement of the two rows.
fn descend_in_cluster(c: Cluster, own: Own, local: u32, start: vec2r, steep: vec2r) -> vec2r {
    let ones = SUM;
    let kinds = SUM | (LEAST << 2u);
    let diagonal = numbers_of(own, DIAGONAL);
    var moved = vec2r();
    var g = steep;
    var d = Direction();
    var e = Direction();
    var length = real(1.0);
    for (var step = 0u; step < LOCAL_STEPS; step += 1u) {
        let x = start + moved;
        share(START, local, x);
        share(STEEP, local, g);
        minimize_pairs(c, local, NONE, STEEP);
        let z = taken_of(own, STEP, local);
        workgroupBarrier();
        leave(0u, local, dot(g, d.displacement));
        leave(1u, local, dot(z, d.product));
        leave(2u, local, dot(g, e.displacement));
        leave(3u, local, dot(z, e.product));
        leave(4u, local, dot(d.displacement, e.product));
        leave(5u, local, dot(g, z));
        bring(local, 6u, 0u);
        let part = parts_of(d, e);
        let descent = found[5];
        share(STEP, local, length * z + (length * part.x) * d.displacement + (length * part.y) * e.displacement);
        minimize_pairs(c, local, STEP, NONE);
        var next = taken_of(own, STEP, local);
        workgroupBarrier();
        leave(0u, local, dot(g, next));
        bring(local, 1u, ones);
        var slope = found[0];
        if slope - DESCENT * descent > 0.0 {
            next = z;
            slope = descent;
        }
        share(STEP, local, next);
        workgroupBarrier();
        move_cluster(c, local);
        workgroupBarrier();
        let product = products(own) + COMPLIANCE * diagonal * next;
        leave(0u, local, dot(next, product));
        leave(1u, local, min(cone_room(x.x, next.x), cone_room(x.y, next.y)));
        bring(local, 2u, kinds);
        let curvature = found[0];
        var best = real(1.0);
        if curvature > 0.0 { best = larger(-slope / curvature, real(0.0)); }
        let advance = smaller(best, found[1]);
        // Displacements are added instead of positions, so that small ones are exact.
        let ahead = moved + advance * next;
        moved = vec2r(cone_change(ahead.x, start.x), cone_change(ahead.y, start.y));
        g += advance * product;
        e = d;
        d = Direction(next, product, curvature);
        length = smaller(larger(length * best, SHORTEST), LONGEST);
    }
    return moved;
}

// All clusters of a workgroup.
fn run_clusters(first: u32, groups: u32, local: u32, x: u32, g: u32, tolerance: real) {
    for (var nth = first; nth < parameters.first; nth += groups) {
        let c = cluster_at(nth);
        let own = own_rows(c, local);
        let start = numbers_of(own, x);
        let steep = numbers_of(own, g);
        row_of[local] = own.row.x;
        row_of[local + WORKGROUP] = own.row.y;
        let diagonal = numbers_of(own, DIAGONAL);
        let open = vec2r(cone_residual(steep.x, diagonal.x, start.x), cone_residual(steep.y, diagonal.y, start.y));
        leave(0u, local, max(open.x, open.y));
        bring(local, 1u, WORST);
        if local == 0u { awake = select(0u, 1u, found[0] > QUIET * tolerance); }
        var moved = vec2r();
        if workgroupUniformLoad(&awake) != 0u { moved = descend_in_cluster(c, own, local, start, steep); }
        if own.is_there.x { displacement[own.place.x] = moved.x; }
        if own.is_there.y { displacement[own.place.y] = moved.y; }
        workgroupBarrier();
    }
}
