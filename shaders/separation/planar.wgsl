// Separations of bodies that cannot leave the plane z = 0: the maximum of n . delta - h_a(n) - h_b(-n) over normals in
// the plane.
//
// If the bodies are apart, or overlap little, the normal of space is already in the plane by symmetry. If they overlap
// deeply it may not be: the shortest separating motion of two rods with crossing axes is along z, for which a planar
// scene has no unknown. Then the maximum is computed over normals in the plane (`in_plane_normal`).

// A normal that leans out of the plane by more than this is not in the plane.
const OUT_OF_PLANE: real = 1e-3;

// The same normal, exactly in the plane.
fn laid_flat(found: Separation) -> Separation {
    var laid = found;
    laid.normal = vec3r(found.normal.xy / length(found.normal.xy), 0.0);
    return laid;
}
