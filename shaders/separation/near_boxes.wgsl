// How far apart two bodies may be at the step's start to be near: the cutoff and what both may move by, as their boxes
// have it.

var<storage, read> boxes: array<vec4r>;

fn near_limit(a: u32, b: u32, radius_a: real, radius_b: real) -> real {
    return max(boxes[a].w - radius_a, 0.0) + max(boxes[b].w - radius_b, 0.0);
}

// What a near pair keeps beside the lever of its first body: the multiplier remembered.
fn kept(p: u32, limit: real) -> real {
    return contacts[3u * p + 1u].w;
}
