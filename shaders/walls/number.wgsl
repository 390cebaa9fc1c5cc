// A place at a surface stands where a pair has its second body. Its number: FIRST_SURFACE, four times the surface, and
// the place.

fn is_surface(number: u32) -> bool {
    return number >= FIRST_SURFACE;
}

fn surface_of(number: u32) -> u32 {
    return (number - FIRST_SURFACE) >> 2u;
}

fn place_of(number: u32) -> u32 {
    return number & 3u;
}

fn number_of(surface: u32, place: u32) -> u32 {
    return FIRST_SURFACE + 4u * surface + place;
}
