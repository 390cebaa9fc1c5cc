// An ellipse and another, or a rod, in the plane: the circle of normals is divided at equal angles and at normals
// perpendicular to the rod. In each piece in which the slope changes from up to down, halving narrows the maximum. The
// kinks at right angles are tested directly.

// Pieces of the circle: two ellipses of aspect 20:1 have their maxima over 0.05 rad apart.
const PLANE_PIECES: u32 = 128u;
const PLANE_COSINE: real = 0.99879545620517239271;
const PLANE_SINE: real = 0.049067674327418014255;
// The largest number of halvings of a piece.
const PLANE_HALVINGS: u32 = 60u;

// The slope of the function as the normal turns, at `n` and with the rods' ends at `p`.
fn plane_slope(p: vec2r, a: Outline, b: Outline, n: vec2r) -> real {
    let t = vec2r(-n.y, n.x);
    let wa = a.g1 * n.x + a.g2 * n.y;
    let wb = b.g1 * n.x + b.g2 * n.y;
    let fall_a = dot(wa, a.g1 * t.x + a.g2 * t.y) / max(length(wa), TINY);
    let fall_b = dot(wb, b.g1 * t.x + b.g2 * t.y) / max(length(wb), TINY);
    return dot(p, t) - fall_a - fall_b;
}

fn in_plane_normal(delta: vec3r, a: Placed, b: Placed) -> Separation {
    let body_a = outline_of(a);
    let body_b = outline_of(b);
    let tie = TIE * (length(delta) + bounding_radius(a) + bounding_radius(b));
    // At most one of them is a rod.
    let reach = body_a.reach + body_b.reach;
    let long = length(reach);
    var best = -HUGE;
    var normal = vec2r(1.0, 0.0);
    var kink = vec2r(-reach.y, reach.x) / max(long, TINY);
    var from_n = normal;
    // Pieces first, then the first normal and the two kinks.
    for (var i = 0u; i < PLANE_PIECES + 3u; i += 1u) {
        var n = vec2r(1.0, 0.0);
        var parts = 1u;
        var cut = from_n;
        var to_n = from_n;
        if i < PLANE_PIECES {
            let turned = vec2r(from_n.x * PLANE_COSINE - from_n.y * PLANE_SINE, from_n.y * PLANE_COSINE + from_n.x * PLANE_SINE);
            // The last piece ends where the first began.
            to_n = select(normalize(turned), vec2r(1.0, 0.0), i + 1u == PLANE_PIECES);
            if long > tie {
                cut = select(kink, -kink, dot(kink, from_n) < 0.0);
                if from_n.x * cut.y - from_n.y * cut.x > 0.0 && cut.x * to_n.y - cut.y * to_n.x > 0.0 { parts = 2u; }
            }
        } else if i > PLANE_PIECES {
            if !(long > tie) { break; }
            n = select(kink, -kink, i == PLANE_PIECES + 2u);
        }
        for (var part = 0u; part < parts; part += 1u) {
            var is_maximum = i >= PLANE_PIECES;
            if i < PLANE_PIECES {
                var low = select(from_n, cut, part == 1u);
                var high = select(to_n, cut, parts == 2u && part == 0u);
                n = normalize(low + high);
                let side = select(real(1.0), real(-1.0), dot(reach, n) < 0.0);
                let p = delta.xy - reach * side;
                is_maximum = plane_slope(p, body_a, body_b, low) > 0.0 && plane_slope(p, body_a, body_b, high) <= 0.0;
                if is_maximum {
                    for (var k = 0u; k < PLANE_HALVINGS; k += 1u) {
                        if plane_slope(p, body_a, body_b, n) > 0.0 { low = n; } else { high = n; }
                        n = normalize(low + high);
                        if length(high - low) <= EPSILON { break; }
                    }
                }
            }
            if is_maximum {
                let value = dot(n, delta.xy) - outline_height(body_a, n) - outline_height(body_b, n);
                if is_better(value, n, best, normal, tie) {
                    best = value;
                    normal = n;
                }
            }
        }
        from_n = to_n;
    }
    return separation_along(delta, a, b, normal, best);
}
