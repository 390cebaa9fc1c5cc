// A place at a surface replaces the second body of a pair. Its number, as in src/walls/number.rs:
// FIRST_SURFACE, PLACES times the surface, and the place.

fn is_surface(number: u32) -> bool {
    return number >= FIRST_SURFACE;
}

fn surface_of(number: u32) -> u32 {
    return (number - FIRST_SURFACE) / PLACES;
}

fn place_of(number: u32) -> u32 {
    return (number - FIRST_SURFACE) % PLACES;
}

fn number_of(surface: u32, place: u32) -> u32 {
    return FIRST_SURFACE + PLACES * surface + place;
}
