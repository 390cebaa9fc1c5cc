// The largest number of places of a shape at a surface, with superellipsoids; the others' are in find.wgsl.
fn places(kind: u32, surface: u32) -> u32 {
    if !is_superellipsoid(kind) { return places_of_others(kind, surface); }
    return 1u;
}
