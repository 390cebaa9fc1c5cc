// The fixed order of a pair of one family: by position, and for equal positions by bounding radius, orientation and
// thickness.

// The sign of the first nonzero component.
fn first_sign(v: vec4r) -> real {
    if v.x != 0.0 { return sign(v.x); }
    if v.y != 0.0 { return sign(v.y); }
    if v.z != 0.0 { return sign(v.z); }
    return sign(v.w);
}

// Whether b precedes a.
fn out_of_order(delta: vec3r, a: Placed, b: Placed) -> bool {
    let place = first_sign(vec4r(delta, 0.0));
    if place != 0.0 { return place < 0.0; }
    let size = bounding_radius(b) - bounding_radius(a);
    if size != 0.0 { return size < 0.0; }
    let turn = first_sign(b.orientation - a.orientation);
    if turn != 0.0 { return turn < 0.0; }
    return thickness(b) < thickness(a);
}
