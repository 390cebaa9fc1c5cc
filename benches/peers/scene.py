"""The scenes: bodies on a cubic lattice, each turned at random, drawn into a ball by a field.

Poses are arrays of `x y z w i j k`, centres and unit quaternions. A file of poses is those numbers, little-endian and
of 8 bytes; a file of frames is a time and the poses, again and again. Every engine, relcp too, starts from the same
file and writes frames.
"""

import json
import math

import numpy
from scenes_table import SCENES  # noqa: F401

SEED = 1


def uniform(seed):
    """Uniform numbers of splitmix64 (Steele, Lea, Flood: "Fast splittable pseudorandom number generators", 2014)."""
    word = (1 << 64) - 1
    state = seed
    while True:
        state = (state + 0x9E3779B97F4A7C15) & word
        z = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & word
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & word
        yield ((z ^ (z >> 31)) >> 11) / float(1 << 53)


def start(scene, seed=SEED):
    """The poses at the start. Orientations are uniform: Shoemake, "Uniform random rotations", Graphics Gems III, 1992."""
    draw = uniform(seed)
    side, middle = scene["side"], (scene["side"] - 1) / 2
    poses = []
    for i in range(side):
        for j in range(side):
            for k in range(side):
                u, a, b = next(draw), 2 * math.pi * next(draw), 2 * math.pi * next(draw)
                s, c = math.sqrt(1 - u), math.sqrt(u)
                place = [scene["spacing"] * (index - middle) for index in (i, j, k)]
                poses.append(place + [c * math.cos(b), s * math.sin(a), s * math.cos(a), c * math.sin(b)])
    return numpy.array(poses)


def field(x):
    """The velocity that the field gives to a body at `x`: inward, `1 - sin r / r` fast."""
    r = numpy.maximum(numpy.linalg.norm(x, axis=1, keepdims=True), 1e-9)
    return -x * (r - numpy.sin(r)) / r**2


def write_poses(path, poses):
    """Writes a file of poses."""
    numpy.asarray(poses, "<f8").tofile(path)


def read_poses(path):
    """Reads one."""
    return numpy.fromfile(path, "<f8").reshape(-1, 7)


def read_frames(path, bodies):
    """Times and poses of a file of frames."""
    frames = numpy.fromfile(path, "<f8").reshape(-1, 1 + 7 * bodies)
    return frames[:, 0], frames[:, 1:].reshape(len(frames), bodies, 7)


def of_relcp(scene, poses, name, dt, tolerance):
    """The scene file of relcp. The drag is one over the length: a unit force moves a body with unit speed, and the
    rotational mobility is `12 / L^2`, as is that of a unit mass with the inertia `L^2 / 12`."""
    if scene["shape"] == "rod":
        shape = {"spherocylinder": {"diameter": 2 * scene["radius"], "length": scene["length"]}}
    else:
        shape = {"ellipsoid": {"radii": scene["radii"]}}
    return json.dumps({
        "name": name,
        "seed": SEED,
        "dynamics": {"overdamped": {"drag": 1 / scene["length"]}},
        "time": {"dt": dt, "end": scene["end"]},
        "contact": {"overlap_tolerance": tolerance},
        "forces": [{"radial_inward": {}}],
        "bodies": [
            {"shape": shape, "position": list(pose[:3]), "orientation": list(pose[3:])} for pose in poses.tolist()
        ],
        "output": {"every": scene["every"], "picture": False},
    })
