"""The cells of the atlas: small scenes of rods (and of ellipsoids), each hard in one way, over the time step or another axis.

Bodies are dropped at random into a ball that is as small as they allow, then drawn to its centre by a trap whose pull gives
the outermost body the speed `speed`, or takes it to the centre in one step where that is slower; overdamped, a body's
mobility is one over its length. Rods have a thickness of 0.5
where nothing else is said. A time of 1 is run, in ten steps at least.
"""

import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import checker  # noqa: E402
import scene as scenes  # noqa: E402

RADIUS = 0.25
STEPS = [1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0]
# The least distance of surfaces at the start, over the thickness.
CLEAR = 0.1
# Of the ball: bodies that start in one place have a trap too.
LEAST_RADIUS = 1.0
# A body that does not fit after so many draws makes the ball larger.
DRAWS = 40


class Case:
    """A cell. `poses`, and for rods `sizes` (radius and half length of the axis), for ellipsoids `radii`."""

    def __init__(self, of, x, y, dt, poses, sizes=None, radii=None, **words):
        self.map, self.x, self.y, self.dt = of, x, y, dt
        self.poses, self.sizes, self.radii = poses, sizes, radii
        self.speed = words.pop("speed", 1.0)
        self.spin = words.pop("spin", 0.0)
        self.distance = words.pop("distance", 0.0)
        self.overlapping = words.pop("overlapping", False)
        self.only = words.pop("only", None)
        # How far out bodies are that are clear of each other.
        self.reach = words.pop("reach", float(numpy.linalg.norm(poses[:, :3], axis=1).max()))
        assert not words
        self.steps = max(10, round(1 / dt))
        # No trap is unstable by itself: a long step takes bodies to its centre at most.
        outermost = numpy.linalg.norm(poses[:, :3], axis=1).max()
        slowest = float(self.lengths.min() / self.lengths[0])
        self.stiffness = min(self.speed / max(outermost, LEAST_RADIUS), slowest / dt)
        self.poses = poses + numpy.array([self.distance, 0, 0, 0, 0, 0, 0])

    @property
    def thickness(self):
        """The least of all."""
        return 2 * float(self.sizes[:, 0].min() if self.radii is None else self.radii.min())

    @property
    def lengths(self):
        """From tip to tip, one a body."""
        return 2 * (self.sizes.sum(axis=1) if self.radii is None else self.radii.max(axis=1))

    def overlap(self, poses):
        """The largest of a state, or infinity. Far from the origin the difference to the trap's centre is exact."""
        if not numpy.isfinite(poses).all():
            return float("inf")
        poses = poses - numpy.array([self.distance, 0, 0, 0, 0, 0, 0])
        if self.radii is None:
            return checker.largest_of_rods(poses, self.sizes[:, 0], self.sizes[:, 1])
        return checker.largest_of_ellipsoids(poses, self.radii)

    def thrown(self, poses):
        """How far out the outermost body is, over how far bodies are that are clear of each other."""
        return float(numpy.linalg.norm(poses[:, :3] - [self.distance, 0, 0], axis=1).max()) / self.reach


def draws(seed):
    """Uniform numbers, and orientations by Shoemake's rule."""
    draw = scenes.uniform(seed)

    def turn():
        u, a, b = next(draw), 2 * math.pi * next(draw), 2 * math.pi * next(draw)
        s, c = math.sqrt(1 - u), math.sqrt(u)
        return [c * math.cos(b), s * math.sin(a), s * math.cos(a), c * math.sin(b)]

    return draw, turn


def in_ball(draw, size):
    """A point of a ball."""
    while True:
        point = [size * (2 * next(draw) - 1) for _ in range(3)]
        if sum(x * x for x in point) <= size * size:
            return point


def dropped(sizes, seed=1):
    """Poses of rods that are clear of each other in a ball as small as random draws make it."""
    draw, turn = draws(seed)
    gap = CLEAR * 2 * sizes[:, 0].min()
    ball, poses = 2 * sizes[:, 0].min(), []
    for i, (radius, half) in enumerate(sizes):
        tries = 0
        while True:
            pose = numpy.array(in_ball(draw, ball) + turn())
            if clear(poses, sizes[:i], pose, radius, half, gap):
                poses.append(pose)
                break
            tries += 1
            if tries % DRAWS == 0:
                ball *= 1.05
    return numpy.array(poses)


def clear(poses, sizes, pose, radius, half, gap):
    """Whether a rod is at least `gap` from others."""
    if not len(poses):
        return True
    poses = numpy.array(poses)
    axis = checker.rotations(poses[:, 3:])[:, :, 2] * sizes[:, 1:2]
    own = numpy.broadcast_to(half * checker.rotations(pose[None, 3:])[0, :, 2], axis.shape)
    a = numpy.broadcast_to(pose[:3], axis.shape)
    away = checker.segment_distance(a - own, 2 * own, poses[:, :3] - axis, 2 * axis)
    return (away - radius - sizes[:, 0]).min() >= gap


def rods(count, aspect=3.0):
    """Sizes of rods of a thickness of 0.5 whose length from tip to tip is `aspect` times that."""
    return numpy.tile([RADIUS, RADIUS * (aspect - 1)], (count, 1))


def aspect_ratio():
    for aspect in [1, 3, 10, 30, 100, 300, 1000]:
        sizes = rods(20, aspect)
        poses = dropped(sizes)
        for dt in STEPS:
            yield Case("aspect ratio", aspect, dt, dt, poses, sizes)


def ellipsoids():
    """Of revolution, thickness 0.5, as many times longer as `aspect`. They lie inside of rods that are as long and thick."""
    for aspect in [1, 3, 10, 30, 100, 300, 1000]:
        poses = dropped(rods(20, aspect))
        radii = numpy.tile([RADIUS, RADIUS, RADIUS * aspect], (20, 1))
        for dt in STEPS[1:]:
            yield Case("ellipsoids", aspect, dt, dt, poses, radii=radii, only=["relcp", "mujoco"])


def size_ratio():
    """Twenty rods on the pole of a sphere that is so many times thicker."""
    for ratio in [1, 10, 100, 1000, 10000]:
        big = RADIUS * ratio
        sizes = numpy.vstack([rods(20), [[big, 0.0]]])
        poses = dropped(sizes[:20])
        lift = big - poses[:, 2].min() + 4 * RADIUS
        poses[:, 2] += lift
        poses = numpy.vstack([poses, [[0, 0, 0, 1, 0, 0, 0]]])
        for dt in STEPS:
            yield Case("size ratio", ratio, dt, dt, poses, sizes)


def deep_overlap():
    """Twenty rods shrunk towards their centre until the deepest overlap is this part of the thickness; 1: all in one place."""
    sizes = rods(20)
    start = dropped(sizes)
    reach = float(numpy.linalg.norm(start[:, :3], axis=1).max())
    for part in [0.01, 0.1, 0.5, 0.9, 0.99, 1.0]:
        poses = start.copy()
        poses[:, :3] *= 0.0 if part == 1 else shrunk(start, sizes, part)
        for dt in STEPS:
            yield Case("deep overlap", part, dt, dt, poses, sizes, speed=0.1, overlapping=True, reach=reach)


def shrunk(start, sizes, part):
    """The factor of the centres at which the overlap is `part` of the thickness, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        poses = start.copy()
        poses[:, :3] *= middle
        deeper = checker.largest_of_rods(poses, sizes[:, 0], sizes[:, 1]) > 2 * RADIUS * part
        low, high = (middle, high) if deeper else (low, middle)
    return high


def jammed():
    """So many rods pressed together with a speed of the outermost that grows by decades, steps of 0.01."""
    for count in [10, 30, 100, 300]:
        sizes = rods(count)
        poses = dropped(sizes)
        for speed in [0.1, 1.0, 10.0, 100.0]:
            yield Case("jammed", count, speed, 0.01, poses, sizes, speed=speed)


def spinning():
    """Twenty rods that would each turn about z with this angular velocity."""
    sizes = rods(20)
    poses = dropped(sizes)
    for spin in [1.0, 10.0, 100.0, 1000.0]:
        for dt in STEPS[1:]:
            yield Case("spinning", spin, dt, dt, poses, sizes, spin=spin)


def far():
    """Twenty rods at so many lengths from the origin: f32 and f64."""
    sizes = rods(20)
    poses = dropped(sizes)
    for distance in [0.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12]:
        for dt in [1e-2, 1e-1]:
            yield Case("distance", distance, dt, dt, poses, sizes, distance=distance)


MAPS = {
    "aspect ratio": aspect_ratio,
    "ellipsoids": ellipsoids,
    "size ratio": size_ratio,
    "deep overlap": deep_overlap,
    "jammed": jammed,
    "spinning": spinning,
    "distance": far,
}


def all_cases():
    """Every cell."""
    for make in MAPS.values():
        yield from make()
