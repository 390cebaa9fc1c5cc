// Fixed surfaces, and the gap of a point inside one, as in src/separation/surface.rs.
//
// A wall is far from most of its own points: in 32 bits, the distance of a point from the centre of a sphere of a
// thousand thicknesses has an error of a ten-thousandth of one. So the offset of a point from a surface's reference is
// a whole number of UNITs along each axis plus a part about as long as a body. Products of the whole numbers are
// computed in integers modulo 2^32; only products with parts are rounded.

// A unit vector, and the same as `coarse` / 2^COARSE_BITS + `fine`.
struct Direction {
    unit: vec3r,
    coarse: vec3<i32>,
    fine: vec3r,
}

struct Surface {
    kind: u32,
    cell: vec3<i32>,
    remainder: vec3r,
    // The radius in whole UNITs and its remainder, also in UNITs.
    radius_whole: i32,
    radius_part: real,
    // A plane's normal, or two directions across a cylinder's axis.
    first: Direction,
    second: Direction,
}

// From a surface's reference: UNITs, and a part as a length.
struct Offset {
    whole: vec3<i32>,
    part: vec3r,
}

struct Coordinate {
    whole: i32,
    part: real,
}

// The distance of a point from a surface, negative beyond it, and the unit vector there, away from the bodies' side.
struct Gap {
    distance: real,
    normal: vec3r,
}

fn direction_at(place: u32) -> Direction {
    return Direction(surfaces[place].xyz, vec3<i32>(surfaces[place + 1u].xyz), surfaces[place + 2u].xyz);
}

fn surface_at(index: u32) -> Surface {
    let place = SURFACE_VECTORS * index;
    let high = vec3<i32>(surfaces[place + 1u].xyz);
    let low = vec3<i32>(surfaces[place + 2u].xyz);
    return Surface(
        u32(surfaces[place].w),
        high * CELL_PARTS + low,
        surfaces[place].xyz,
        i32(surfaces[place + 1u].w),
        surfaces[place + 2u].w,
        direction_at(place + 3u),
        direction_at(place + 6u),
    );
}

fn offset_from(surface: Surface, cell: vec3<i32>, remainder: vec3r) -> Offset {
    let pitches = cell - surface.cell;
    let whole = (pitches + vec3<i32>(1 << (UNIT_BITS - 1u))) >> vec3<u32>(UNIT_BITS);
    let rest = pitches - (whole << vec3<u32>(UNIT_BITS));
    return Offset(whole, vec3r(rest) * PITCH + (remainder - surface.remainder));
}

fn as_vector(offset: Offset) -> vec3r {
    return vec3r(offset.whole) * UNIT + offset.part;
}

// The coordinate along a direction. The sum in integers is exact modulo 2^32, that is 4096 UNITs; the estimate selects
// the right one.
fn coordinate(direction: Direction, offset: Offset) -> Coordinate {
    let products = bitcast<vec3<u32>>(direction.coarse) * bitcast<vec3<u32>>(offset.whole);
    let sum = bitcast<i32>(products.x + products.y + products.z);
    let estimate = dot(direction.unit, vec3r(offset.whole));
    let turns = round((estimate - real(sum) * COARSE_PITCH) * TURNS_A_UNIT);
    let whole = i32(turns) * UNITS_A_TURN + (sum >> COARSE_BITS);
    let fraction = real(sum & COARSE_MASK) * COARSE_PITCH + dot(direction.fine, vec3r(offset.whole));
    return Coordinate(whole, UNIT * fraction + dot(direction.unit, offset.part));
}

// The gap of a point at `whole`, `part` from the centre inside the surface's radius R, as (R^2 - x^2) / (R + |x|), and
// the outward direction; the first direction at the centre up to `rounding`, a length.
fn out_of(surface: Surface, whole: vec3<i32>, part: vec3r, rounding: real) -> Gap {
    let units = vec3r(whole);
    let rest = part * INVERSE_UNIT;
    let radius_units = real(surface.radius_whole);
    let radius = radius_units + surface.radius_part;
    let place = units + rest;
    let distance = length(place);
    var room = radius - distance;
    // Elsewhere the gap is so large that its rounding does not matter.
    if abs(room) * (radius + distance) < LARGEST_SQUARE {
        let squares = bitcast<vec3<u32>>(whole) * bitcast<vec3<u32>>(whole);
        let square = bitcast<u32>(surface.radius_whole) * bitcast<u32>(surface.radius_whole);
        let left = real(bitcast<i32>(square - squares.x - squares.y - squares.z));
        let mixed = 2.0 * (radius_units * surface.radius_part - dot(units, rest));
        let parts = surface.radius_part * surface.radius_part - dot(rest, rest);
        room = (left + mixed + parts) / (radius + distance);
    }
    var normal = vec3r(1.0, 0.0, 0.0);
    if distance > rounding * INVERSE_UNIT {
        normal = place / distance;
    }
    return Gap(UNIT * room, normal);
}

fn gap_of(surface: Surface, offset: Offset) -> Gap {
    switch surface.kind {
        case SURFACE_PLANE: {
            let along = coordinate(surface.first, offset);
            return Gap(UNIT * real(along.whole) + along.part, -surface.first.unit);
        }
        case SURFACE_SPHERE: { return out_of(surface, offset.whole, offset.part, real(0.0)); }
        case SURFACE_CYLINDER: {
            let first = coordinate(surface.first, offset);
            let second = coordinate(surface.second, offset);
            let rounding = 4.0 * EPSILON * (UNIT + length(offset.part));
            let place = vec3<i32>(first.whole, second.whole, 0);
            let across = out_of(surface, place, vec3r(first.part, second.part, 0.0), rounding);
            return Gap(across.distance, across.normal.x * surface.first.unit + across.normal.y * surface.second.unit);
        }
        default: { return Gap(not_a_number(), vec3r(not_a_number())); }
    }
}
