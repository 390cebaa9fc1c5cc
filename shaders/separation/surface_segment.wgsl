// A rod touches a surface with its ends, a sphere in one place.
fn arm_of_segment(body: Placed, place: u32) -> Arm {
    let half = half_segment(body);
    let arm = body_z(body.orientation) * select(half, -half, place == 0u);
    return Arm(arm, tube_radius(body), place == 0u || (place == 1u && half > 0.0));
}
