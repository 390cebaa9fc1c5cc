// The largest distance of near bodies at the step's start: the cutoff plus the motion of both, as in their boxes.

var<storage, read> boxes: array<vec4r>;

fn near_limit(a: u32, b: u32, radius_a: real, radius_b: real) -> real {
    return max(boxes[a].w - radius_a, 0.0) + max(boxes[b].w - radius_b, 0.0);
}

// The value that a near pair keeps beside the lever of its first body: the multiplier of the warm start.
fn kept(p: u32, limit: real) -> real {
    return contacts[3u * p + 1u].w;
}
