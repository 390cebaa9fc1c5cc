// Stores the root of a body's translational mobility in the last two vectors of its motion. The law defines
// `translation_roots`.
fn keep_translation(first: u32, shape: vec4r, q: vec4r) {
    let root = axes_matrix(q, translation_roots(shape));
    motions[first + MOTION - 2u] = vec4r(root[0], root[1].y);
    motions[first + MOTION - 1u] = vec4r(root[1].z, root[2].z, 0.0, 0.0);
}
