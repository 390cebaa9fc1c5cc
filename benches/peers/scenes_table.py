"""Which scenes there are. Of the standard library alone: `run` reads it before anything is installed."""

# Spherocylinders: the radius and half the length of the axis, so that a rod is 1.5 long from tip to tip. Ellipsoids:
# the radii. Bodies of the lattice are clear of each other in any orientation.
RODS = {"shape": "rod", "radius": 0.25, "half": 0.5, "spacing": 1.6, "length": 1.5}
ELLIPSOIDS = {"shape": "ellipsoid", "radii": [1.0, 1.0, 2.0], "spacing": 4.1, "length": 4.0}

SCENES = {
    "rods-1000": {**RODS, "side": 10, "end": 15.0, "every": 0.1},
    "rods-8000": {**RODS, "side": 20, "end": 15.0, "every": 0.5},
    "ellipsoids-1000": {**ELLIPSOIDS, "side": 10, "end": 20.0, "every": 0.5},
    # Of `run --quick`.
    "rods-1000-short": {**RODS, "side": 10, "end": 8.0, "every": 0.1},
    "ellipsoids-216": {**ELLIPSOIDS, "side": 6, "end": 12.0, "every": 0.5},
    # Of `run --tune`.
    "rods-216": {**RODS, "side": 6, "end": 10.0, "every": 0.1},
}
