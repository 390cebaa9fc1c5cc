// Fixed directions for undetermined normals, and the separation of two curves from their nearest points.

struct Nearest {
    from_a: vec3r,
    to_b: vec3r,
    normal: vec3r,
    distance: real,
}

// The separation of two curves thickened by these radii.
fn thickened(n: Nearest, radius_a: real, radius_b: real) -> Separation {
    return Separation(n.distance - (radius_a + radius_b), n.normal, n.from_a + n.normal * radius_a, n.to_b - n.normal * radius_b);
}

// `v` normalized, or `other` if `v` is too short to have a direction.
fn unit_or(v: vec3r, other: vec3r) -> vec3r {
    let size = length(v);
    if size * size > 16.0 * TINY {
        return v / size;
    }
    return other;
}

// A unit vector at right angles to `v`: the cross product of `v` and the axis of space along which it has the smallest
// component, the first among equals. The x axis if `v` is zero.
fn perpendicular(v: vec3r) -> vec3r {
    let size = abs(v);
    var least = vec3r(0.0, 0.0, 1.0);
    if size.x <= size.y && size.x <= size.z {
        least = vec3r(1.0, 0.0, 0.0);
    } else if size.y <= size.z {
        least = vec3r(0.0, 1.0, 0.0);
    }
    return unit_or(cross(v, least), vec3r(1.0, 0.0, 0.0));
}

// The part of `v` at right angles to the unit vector `axis`, projected twice if it is small; zero if `v` is along it up
// to rounding.
fn part_across(v: vec3r, axis: vec3r) -> vec3r {
    let all = length(v);
    let once = v - axis * dot(axis, v);
    if length(once) > SMALL_SINE * all {
        return once;
    }
    let twice = once - axis * dot(axis, once);
    return select(vec3r(0.0, 0.0, 0.0), twice, length(twice) > ROUNDING_SINE * all);
}

// The unit vector along u x v of unit vectors, at right angles to both, even if they are nearly parallel; zero if they
// are parallel up to rounding.
fn normal_to(u: vec3r, v: vec3r) -> vec3r {
    let across = cross(u, v);
    let sine = length(across);
    if sine > SMALL_SINE {
        return across / sine;
    }
    return cross(u, unit_or(part_across(v, u), vec3r(0.0, 0.0, 0.0)));
}

// A unit vector at right angles to both; if they are parallel, one at right angles to the longer.
fn common_perpendicular(u: vec3r, v: vec3r) -> vec3r {
    if dot(u, u) > 0.0 && dot(v, v) > 0.0 {
        let unit = normal_to(u, v);
        if dot(unit, unit) > 0.0 {
            return unit;
        }
    }
    if dot(u, u) >= dot(v, v) {
        return perpendicular(u);
    }
    return perpendicular(v);
}

// One of two curves at its nearest point: its unit direction there, zero for a point; whether it continues there, and
// if not, the side along that direction on which it ends, zero for a point.
struct Course {
    along: vec3r,
    goes_on: bool,
    end: real,
}

// A segment at a position on it. A position within rounding of an end is the end.
fn course_of(axis: vec3r, half: real, at: real) -> Course {
    return Course(axis, abs(at) < half * (1.0 - END_ROUNDING), at);
}

// Whether a normal along `way` must be at right angles to the curve: where the curve continues, and at an end from
// which the normal would lean back.
fn holds(course: Course, way: vec3r) -> bool {
    return course.goes_on || dot(way, course.along) * course.end < 0.0;
}

// The unit vector along the common perpendicular of two curves, if the gap is along it; else zero.
fn crossing_normal(a: Course, b: Course, gap: vec3r, distance: real, size: real) -> vec3r {
    let unit = normal_to(a.along, b.along);
    let aside = length(gap - unit * dot(gap, unit));
    return select(vec3r(0.0, 0.0, 0.0), unit, aside <= 32.0 * EPSILON * size + 1e-4 * distance);
}

// The gap between curves that nearly meet, with the conditions of the curves enforced, as in src/separation/meeting.rs.
fn gap_left(a: Course, b: Course, gap: vec3r, distance: real, size: real, sine: real) -> vec3r {
    // The normal points towards b, so for b its sign is opposite. Curves that continue come first.
    var first = a;
    var second = Course(b.along, b.goes_on, -b.end);
    if !a.goes_on {
        first = second;
        second = a;
    }
    if !holds(first, gap) {
        if holds(second, gap) {
            return part_across(gap, second.along);
        }
        return gap;
    }
    let left = part_across(gap, first.along);
    // A normal at right angles to one of two nearly parallel curves is also at right angles to the other.
    if !holds(second, left) || distance >= size * sine {
        return left;
    }
    // The curves determine the common perpendicular better than the gap does.
    let unit = crossing_normal(a, b, gap, distance, size);
    if dot(unit, unit) > 0.0 {
        return unit * dot(gap, unit);
    }
    if abs(dot(gap, first.along)) > abs(dot(gap, second.along)) {
        return part_across(gap, second.along);
    }
    return left;
}

// The unit vector from one curve to the other, given the gap between their nearest points. For curves that nearly meet
// and cross it is their common perpendicular, with the sign of `toward`; if the gap is rounding, a fixed one.
fn normal_between(a: Course, b: Course, gap: vec3r, distance: real, size: real, toward: vec3r) -> vec3r {
    if distance > MEETING * size {
        return gap / distance;
    }
    let sine = length(cross(a.along, b.along));
    if a.goes_on && b.goes_on && distance < MEETING * size * sine {
        let unit = crossing_normal(a, b, gap, distance, size);
        if dot(unit, unit) > 0.0 {
            return select(unit, -unit, dot(toward, unit) < 0.0);
        }
    }
    let left = gap_left(a, b, gap, distance, size, sine);
    let rest = length(left);
    if rest > 4.0 * EPSILON * size {
        return left / rest;
    }
    return common_perpendicular(a.along, b.along);
}
