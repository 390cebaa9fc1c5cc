// The rays of tiles, one workgroup per tile: each is tested against the bodies of its tile, from front to back, until
// none can be nearer.

struct Band {
    // The first tile, tiles in a row of the picture, and how many there are.
    first_tile: u32,
    columns: u32,
    tiles: u32,
}

// A body in the camera's axes.
struct Drawn {
    // The camera's right, up and toward in body axes. With them: the body's size; one sample in units of it; the height
    // of its front.
    right: vec4<f32>,
    up: vec4<f32>,
    toward: vec4<f32>,
    // Sizes in units of the size; the height of the centre.
    sizes: vec4<f32>,
    // The fractional position of the centre, in samples.
    rest: vec2<f32>,
    kind: u32,
    body: u32,
    // The position of the centre in whole samples.
    place: vec2<i32>,
    // First and last column, first and last row.
    columns: vec2<u32>,
    rows: vec2<u32>,
    unused: vec2<u32>,
}

struct Sample {
    body: u32,
    height: f32,
    normal: vec2<f32>,
}

var<uniform> band: Band;
var<storage, read> first: array<u32>;
var<storage, read> members: array<u32>;
var<storage, read> drawn: array<Drawn>;
var<storage, read_write> samples: array<Sample>;

fn nearest(tile: u32, x: u32, y: u32) -> Sample {
    var best = Sample(NOTHING, -MISS, vec2<f32>(0.0));
    for (var k = first[tile]; k < first[tile + 1u]; k += 1u) {
        let member = members[k];
        let front = drawn[member].toward.w;
        if best.height >= front {
            break;
        }
        let columns = drawn[member].columns;
        let rows = drawn[member].rows;
        if x < columns.x || x > columns.y || y < rows.x || y > rows.y {
            continue;
        }
        let d = drawn[member];
        let offset = (vec2<f32>(vec2<i32>(i32(x), i32(y)) - d.place) + (vec2<f32>(0.5) - d.rest)) * d.up.w;
        let origin = d.right.xyz * offset.x - d.up.xyz * offset.y;
        let t = first_hit(d.kind, d.sizes.xyz, origin, -d.toward.xyz);
        if t >= MISS {
            continue;
        }
        let height = d.sizes.w - t * d.right.w;
        if height > best.height {
            let normal = normal_at(d.kind, d.sizes.xyz, origin - d.toward.xyz * t);
            best = Sample(d.body, height, vec2<f32>(dot(normal, d.right.xyz), dot(normal, d.up.xyz)));
        }
    }
    return best;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let here = group_index(group, groups);
    if here >= band.tiles {
        return;
    }
    let tile = band.first_tile + here;
    let corner = vec2<u32>(tile % band.columns, tile / band.columns) * TILE;
    for (var s = local; s < TILE * TILE; s += WORKGROUP) {
        samples[here * TILE * TILE + s] = nearest(tile, corner.x + s % TILE, corner.y + s / TILE);
    }
}
