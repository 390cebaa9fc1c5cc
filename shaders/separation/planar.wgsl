// Separations of bodies that cannot leave the plane z = 0: the maximum of n . delta - h_a(n) - h_b(-n) over normals in
// the plane alone.
//
// Where the bodies are apart, or overlap by little, symmetry puts the normal of space in the plane already. Where they
// overlap deeply it may not: two rods whose axes cross are pushed apart least along z, which a planar scene has no
// unknown for. There the maximum is sought among normals in the plane (`in_plane_normal`).

// A normal leaning out of the plane by more than this is one that the plane does not have.
const OUT_OF_PLANE: real = 1e-3;

// The same normal in the plane to the last digit.
fn laid_flat(found: Separation) -> Separation {
    var laid = found;
    laid.normal = vec3r(found.normal.xy / length(found.normal.xy), 0.0);
    return laid;
}
