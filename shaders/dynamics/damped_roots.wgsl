// The roots of the translational mobility over a step along a body's axes, with inertia and drag.
fn translation_roots(shape: vec4r) -> vec3r {
    return sqrt(parameters.dt / (DENSITY * solid(shape).volume) * damping(shape, parameters.dt).share);
}
