"""Scenes with friction, what is right in each, and how far an engine is off it.

Balls of radius 1 and mass 1, rods of half length 1.5 and radius 0.5, gravity 9.81, a step of 0.01. A slope is a level
floor with gravity turned. Every case has its closed form but the heap, where contact that holds leaves no overlap and a
heap at rest no speed.
"""

import math

import numpy

G = 9.81
DT = 0.01
BALL, ROD = {"radius": 1.0, "half": 0.0}, {"radius": 0.5, "half": 1.5}
FLOOR = [[0.0, 0.0, 1.0, 0.0]]


def slope(angle):
    """Gravity on a slope that falls along x."""
    return [G * math.sin(angle), 0.0, -G * math.cos(angle)]


def body(kind, position, velocity=(0, 0, 0), spin=(0, 0, 0), axis=(0, 0, 1)):
    return {**kind, "position": list(position), "velocity": list(velocity), "spin": list(spin), "axis": list(axis)}


def case(about, mu, bodies, end, measures, gravity=(0, 0, -G), planes=FLOOR, every=None):
    """`measures` are `(what, right value, function of the frames)`; `frames.at(t)` has `position`, `velocity` and
    `spin` of all bodies."""
    return {
        "about": about,
        "mu": mu,
        "gravity": list(gravity),
        "planes": planes,
        "bodies": bodies,
        "end": end,
        "every": every or end,
        "measures": measures,
    }


class Frames:
    """States over time: `rows[t, body]` is position, velocity and spin."""

    def __init__(self, times, rows):
        self.times, self.rows = numpy.asarray(times), numpy.asarray(rows, float)

    def at(self, time):
        row = self.rows[int(numpy.argmin(abs(self.times - time)))]
        return {"position": row[:, :3], "velocity": row[:, 3:6], "spin": row[:, 6:9]}


def speed(time):
    return lambda frames: float(numpy.linalg.norm(frames.at(time)["velocity"][0]))


def moved(time):
    """How far the farthest body is from where it was at the start."""
    return lambda frames: float(numpy.linalg.norm(frames.at(time)["position"] - frames.at(0)["position"], axis=1).max())


def lift(frames):
    """The largest distance of the first body from the floor, over all frames."""
    return float((frames.rows[:, 0, 2] - frames.rows[0, 0, 2]).max())


def aside(frames):
    """The largest angle between where a ball was thrown and where it went, degrees."""
    way = (frames.at(1.0)["position"] - frames.at(0)["position"])[:, :2]
    thrown = frames.at(0)["velocity"][:, :2]
    cross = way[:, 0] * thrown[:, 1] - way[:, 1] * thrown[:, 0]
    return float(numpy.degrees(abs(numpy.arctan2(cross, (way * thrown).sum(1)))).max())


def thrown_around():
    angles = [2 * math.pi * k / 19 for k in range(19)]
    place = lambda k: (10.0 * (k % 5), 10.0 * (k // 5), 1.0)
    return [body(BALL, place(k), (5 * math.cos(a), 5 * math.sin(a), 0)) for k, a in enumerate(angles)]


def pile():
    """Ten balls: six, three and one."""
    side, at = 2.0, []
    layers = [(3, 0.0, 0.0, 1.0), (2, 1.0, 1 / math.sqrt(3), 1 + math.sqrt(8 / 3)), (1, 2.0, 2 / math.sqrt(3), 1 + 2 * math.sqrt(8 / 3))]
    for rows, x, y, z in layers:
        for j in range(rows):
            at += [(x + side * i + j, y + j * math.sqrt(3), z) for i in range(rows - j)]
    return [body(BALL, place) for place in at]


BOX, HEAP = 10.0, 200


def heap():
    """Balls that fall into a box, in layers of sixteen, shifted at random."""
    random = numpy.random.default_rng(1)
    bodies = []
    for k in range(HEAP):
        layer, j, i = k // 16, (k // 4) % 4, k % 4
        shift = random.uniform(-0.15, 0.15, 3)
        place = numpy.array([-3.6 + 2.4 * i, -3.6 + 2.4 * j, 1.5 + 2.4 * layer]) + shift
        bodies.append(body(BALL, place.tolist()))
    return bodies


WALLS = FLOOR + [[1.0, 0, 0, -BOX / 2], [-1.0, 0, 0, -BOX / 2], [0, 1.0, 0, -BOX / 2], [0, -1.0, 0, -BOX / 2]]


def overlap(frames):
    """The largest overlap of balls, and with the box, in parts of a radius, over all frames."""
    most = 0.0
    for row in frames.rows:
        x = row[:, :3]
        apart = numpy.linalg.norm(x[:, None] - x[None], axis=2) + 1e9 * numpy.eye(len(x))
        wall = min(float((x @ numpy.array(p[:3]) - p[3]).min()) for p in WALLS)
        most = max(most, 2 - float(apart.min()), 1 - wall)
    return most


def last_second(frames):
    """How far the median ball moved in the last second."""
    end = frames.times[-1]
    way = frames.at(end)["position"] - frames.at(end - 1)["position"]
    return float(numpy.median(numpy.linalg.norm(way, axis=1)))


ALONG_X = (1, 0, 0)
CASES = {
    "slides": case(
        "rod on a slope of 0.4 rad, mu 0.3",
        0.3,
        [body(ROD, (0, 0, 0.5), axis=ALONG_X)],
        1.0,
        [("speed after 1", G * (math.sin(0.4) - 0.3 * math.cos(0.4)), speed(1.0)), ("lifts by", 0.0, lift)],
        slope(0.4),
        every=0.1,
    ),
    "rests": case(
        "the same, mu 0.5",
        0.5,
        [body(ROD, (0, 0, 0.5), axis=ALONG_X)],
        10.0,
        [("creeps in 10", 0.0, moved(10.0))],
        slope(0.4),
    ),
    "rolls": case(
        "ball thrown at 5, mu 0.3",
        0.3,
        [body(BALL, (0, 0, 1), (5, 0, 0))],
        2.0,
        [("speed at 0.2", 5 - 0.3 * G * 0.2, speed(0.2)), ("speed at 2", 25 / 7, speed(2.0)), ("lifts by", 0.0, lift)],
        every=0.1,
    ),
    "around": case(
        "19 balls thrown at 5 around, mu 0.3",
        0.3,
        thrown_around(),
        1.0,
        [("turns aside by, degrees", 0.0, aside)],
    ),
    "pile": case("pile of ten balls, mu 0.6", 0.6, pile(), 20.0, [("moves in 20", 0.0, moved(20.0))]),
    "heap": case(
        "200 balls fall into a box, mu 0.5, to time 6",
        0.5,
        heap(),
        6.0,
        [("largest overlap", 0.0, overlap), ("median move in the last 1", 0.0, last_second)],
        planes=WALLS,
        every=0.25,
    ),
}
