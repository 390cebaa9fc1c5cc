// The separation of one place of a body from a surface. The function `arm_of`, assembled for the scene's shapes, has
// the places of each shape.

// The vector from a body's centre to the middle of a place, the radius about it, and whether the body has this place.
struct Arm {
    arm: vec3r,
    radius: real,
    there: bool,
}

// The separation is HUGE if the body has no such place.
fn separate_place(surface: Surface, offset: Offset, body: Placed, place: u32) -> Separation {
    let arm = arm_of(surface, offset, body, place);
    let gap = gap_of(surface, Offset(offset.whole, offset.part + arm.arm));
    let separation = select(HUGE, gap.distance - arm.radius, arm.there);
    return Separation(separation, gap.normal, arm.arm + arm.radius * gap.normal, vec3r());
}
