"""Overlap of smooth bodies in f64, by code that shares nothing with relcp or an engine.

Two spherocylinders overlap by their diameter less the distance of their axes. Two convex bodies overlap by
`-max_n [d . n - h_a(n) - h_b(n)]` over unit vectors `n`, `d` the vector between their centres and `h` their support
functions: the least translation that parts them. An ellipsoid of the matrix `S = R diag(r^2) R^T` has
`h(n) = sqrt(n . S n)`. Any `n` gives a lower bound of the separation, so a pair is let go at the first `n` that shows
it apart; the rest are refined by Newton's method on the sphere from several starts.
"""

import numpy
from scipy.spatial import cKDTree

# Newton's method of ellipsoids: most iterations, and the tangential gradient at which it ends.
ITERATIONS = 60
GRADIENT = 1e-12
# Starts drawn at random beside the two that are derived from the pair: with 3 or 12 the largest overlap of the scenes
# here is the same to 1e-12.
RANDOM_STARTS = 3


def rotations(q):
    """Matrices of unit quaternions `w i j k`."""
    w, x, y, z = (q / numpy.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return numpy.moveaxis(numpy.array(rows), 2, 0)


def segment_distance(a, u, b, v):
    """Distances of segments `a + s u` and `b + t v`, `s` and `t` in [0, 1]: the interior critical point where there is
    one, else the least of the four ends against the other segment."""

    def to_end(p, a, u):
        square = (u * u).sum(1)
        t = numpy.clip(((p - a) * u).sum(1) / numpy.where(square > 0, square, 1), 0, 1)
        return numpy.linalg.norm(p - a - t[:, None] * u, axis=1)

    least = numpy.minimum.reduce([to_end(a, b, v), to_end(a + u, b, v), to_end(b, a, u), to_end(b + v, a, u)])
    w = a - b
    uu, uv, vv, uw, vw = ((x * y).sum(1) for x, y in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    determinant = uu * vv - uv * uv
    skew = determinant > 1e-12 * uu * vv
    over = numpy.where(skew, determinant, 1)
    s, t = (uv * vw - vv * uw) / over, (uu * vw - uv * uw) / over
    inside = skew & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    at = numpy.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)
    return numpy.where(inside, numpy.minimum(least, at), least)


def support_separation(d, a, b, n):
    """The largest `d . n - sqrt(n . a n) - sqrt(n . b n)` that is found from `n`; for pairs that are apart, any that is
    positive."""
    n = n / numpy.linalg.norm(n, axis=1, keepdims=True)
    half = lambda s, n: numpy.sqrt(numpy.einsum("ki,kij,kj->k", n, s, n))
    value = lambda d, a, b, n: (d * n).sum(1) - half(a, n) - half(b, n)
    best = value(d, a, b, n)
    rest = numpy.flatnonzero(best <= 0)
    for _ in range(ITERATIONS):
        if not len(rest):
            break
        m, f = n[rest], best[rest]
        step, flat = newton_step(d[rest], a[rest], b[rest], m)
        length = numpy.ones(len(rest))
        open_ = ~flat
        for _ in range(30):
            if not open_.any():
                break
            trial = m + length[:, None] * step
            trial /= numpy.linalg.norm(trial, axis=1, keepdims=True)
            found = value(d[rest], a[rest], b[rest], trial)
            better = open_ & (found > f)
            n[rest[better]], best[rest[better]] = trial[better], found[better]
            open_ &= ~better
            length *= 0.5
        # What no step betters is as good as it gets.
        rest = rest[~flat & ~open_ & (best[rest] <= 0)]
    return best


def newton_step(d, a, b, n):
    """A step of ascent in the tangent plane, and where the gradient is as good as nothing."""
    hessian, gradient = 0.0, d
    for s in (a, b):
        v = numpy.einsum("kij,kj->ki", s, n)
        h = numpy.sqrt((n * v).sum(1))[:, None]
        gradient = gradient - v / h
        hessian = hessian + s / h[:, :, None] - v[:, :, None] * v[:, None, :] / h[:, :, None] ** 3
    normal = (gradient * n).sum(1)
    tangent = gradient - normal[:, None] * n
    plane = numpy.eye(3) - n[:, :, None] * n[:, None, :]
    curvature = plane @ hessian @ plane + normal[:, None, None] * plane
    # The normal's own direction is made stiff; negative curvatures are turned, so that every step ascends.
    values, vectors = numpy.linalg.eigh(curvature + 1e6 * n[:, :, None] * n[:, None, :])
    values = numpy.maximum(numpy.abs(values), 1e-3)
    step = numpy.einsum("kij,kj->ki", vectors, numpy.einsum("kji,kj->ki", vectors, tangent) / values)
    size = numpy.linalg.norm(step, axis=1, keepdims=True)
    return step * numpy.minimum(1, 0.5 / numpy.maximum(size, 1e-300)), numpy.abs(tangent).max(1) < GRADIENT


def largest_of_rods(poses, radius, half):
    """The largest overlap of spherocylinders; radius and half length are numbers, or one a body."""
    radius, half = (numpy.broadcast_to(number, len(poses)) for number in (radius, half))
    x, axis = poses[:, :3], rotations(poses[:, 3:])[:, :, 2] * half[:, None]
    i, j = near(x, 2 * (half + radius).max())
    gap = segment_distance(x[i] - axis[i], 2 * axis[i], x[j] - axis[j], 2 * axis[j])
    return max(0.0, float((radius[i] + radius[j] - gap).max(initial=0.0)))


def largest_of_ellipsoids(poses, radii):
    """The largest overlap of ellipsoids; radii are one triple, or one a body."""
    radii = numpy.broadcast_to(radii, (len(poses), 3))
    x, turn = poses[:, :3], rotations(poses[:, 3:])
    s = numpy.einsum("kij,kj,klj->kil", turn, radii**2, turn)
    i, j = near(x, 2 * radii.max())
    d, a, b = x[j] - x[i], s[i], s[j]
    # Neither pairs whose bounding spheres are apart, nor those that are apart along either start.
    best = support_separation(d, a, b, numpy.where(numpy.linalg.norm(d, axis=1, keepdims=True) > 0, d, [0.0, 0.0, 1.0]))
    random = numpy.random.default_rng(0)
    for start in range(1 + RANDOM_STARTS):
        rest = numpy.flatnonzero(best <= 0)
        if not len(rest):
            return 0.0
        if start == 0:
            n = numpy.linalg.solve(a[rest] + b[rest], d[rest][:, :, None])[:, :, 0]
            n = numpy.where(numpy.linalg.norm(n, axis=1, keepdims=True) > 0, n, [0.0, 0.0, 1.0])
        else:
            n = random.normal(size=(len(rest), 3))
        best[rest] = numpy.maximum(best[rest], support_separation(d[rest], a[rest], b[rest], n))
    return max(0.0, float(-best.min(initial=0.0)))


def near(x, distance):
    """Pairs of centres within a distance."""
    pairs = cKDTree(x).query_pairs(distance, output_type="ndarray")
    return pairs[:, 0], pairs[:, 1]


def largest(scene, poses):
    """The largest overlap of a scene's bodies; infinite where a number is not finite."""
    if not numpy.isfinite(poses).all():
        return float("inf")
    if scene["shape"] == "rod":
        return largest_of_rods(poses, scene["radius"], scene["half"])
    return largest_of_ellipsoids(poses, scene["radii"])


def test():
    """Compares with a search over many directions, and with pairs whose overlap is known."""
    random = numpy.random.default_rng(7)
    n = random.normal(size=(200_000, 3))
    n /= numpy.linalg.norm(n, axis=1, keepdims=True)
    for _ in range(20):
        poses = numpy.hstack([0.6 * random.normal(size=(2, 3)), random.normal(size=(2, 4))])
        turn = rotations(poses[:, 3:])
        d = n @ (poses[1, :3] - poses[0, :3])
        radii = numpy.array([1.0, 0.7, 2.0])
        support = [numpy.linalg.norm((n @ r) * radii, axis=1) for r in turn]
        brute = -(d - support[0] - support[1]).max()
        found = largest_of_ellipsoids(poses, radii)
        assert brute - 1e-2 < found <= brute + 1e-12, (found, brute)
        rods = [0.25 + 0.5 * numpy.abs(n @ r[:, 2]) for r in turn]
        brute, found = -(d - rods[0] - rods[1]).max(), largest_of_rods(poses, 0.25, 0.5)
        # The least translation is at least what the distance of the axes tells, and equal where these do not cross.
        assert found <= max(brute, 0) + 1e-4, (found, brute)
    # Along z, a quarter into each other.
    still = [1.0, 0.0, 0.0, 0.0]
    pair = numpy.array([[0.0, 0.0, 0.0, *still], [0.0, 0.0, 3.75, *still]])
    assert abs(largest_of_ellipsoids(pair, [1.0, 1.0, 2.0]) - 0.25) < 1e-12
    pair[1, 2] = 1.45
    assert abs(largest_of_rods(pair, 0.25, 0.5) - 0.05) < 1e-12
    print("the checker agrees with a search over directions and with known pairs")


if __name__ == "__main__":
    test()
