"""Loads the text exports with ASE and OVITO and compares what they read with the states.

    check_text.py RUN --lammps FILE --xyz FILE

RUN is a run's folder or a state (.npz). It needs numpy and ase; with ovito, that reads both files too. It prints a line a check and ends with
status 1 where one fails, 3 where a package is missing.
"""
import argparse
import os
import sys

sys.path.insert(0, os.path.dirname(__file__))
try:
    import ase.io
    import numpy as np
except ImportError as missing:
    print(f"SKIP: {missing}")
    sys.exit(3)
try:
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    import ovito.io
except ImportError:
    ovito = None

FAILED = []
SPHERE, ROD, ELLIPSOID, TORUS, _, SUPERELLIPSOID = range(6)


def check(what, holds, said=""):
    print(f"{'ok  ' if holds else 'FAIL'} {what} {said}", flush=True)
    if not holds:
        FAILED.append(what)


def extents(kind, size):
    """Full extents along the body's axes."""
    a, b, c = size
    box = (2 * a, 2 * b, 2 * c)
    ring = (2 * (a + b), 2 * (a + b), 2 * b)
    return {SPHERE: (2 * a,) * 3, ROD: (a, a, b), ELLIPSOID: box, TORUS: ring, SUPERELLIPSOID: box}[int(kind)]


def drawn(kind, size):
    """The three numbers that OVITO draws."""
    a, b, c = size
    own = (a, b, c)
    return {SPHERE: (a, a, a), ROD: (a / 2, 0, b - a), ELLIPSOID: own, TORUS: (0, 0, 0), SUPERELLIPSOID: own}[int(kind)]


def near(a, b):
    return np.allclose(a, b, rtol=1e-12, atol=1e-12)


def check_ase(lammps, xyz, states):
    frames = ase.io.read(lammps, index=":", format="lammps-dump-text", order=False)
    check("ase: lammps frames", len(frames) == len(states), f"{len(frames)}")
    for frame, state in zip(frames, states):
        check("ase: lammps positions", near(frame.get_positions(), state["position"]))
    frames = ase.io.read(xyz, index=":", format="extxyz")
    check("ase: xyz frames", len(frames) == len(states), f"{len(frames)}")
    for frame, state in zip(frames, states):
        same = near(frame.get_positions(), state["position"]) and near(frame.arrays["size"], state["size"])
        check("ase: xyz positions, sizes, ids", same and np.array_equal(frame.arrays["id"], state["id"].astype(int)))
        check("ase: xyz orientations", near(frame.arrays["orientation"][:, [3, 0, 1, 2]], state["orientation"]))


def check_ovito(path, states, shape, tolerance):
    pipeline = ovito.io.import_file(path)
    name = os.path.basename(path)
    check(f"ovito: {name} frames", pipeline.source.num_frames == len(states))
    for k, state in enumerate(states):
        particles = pipeline.compute(k).particles
        order = np.argsort(particles["Particle Identifier"]) if "lammps" in path else np.arange(len(state["position"]))
        own = np.argsort(state["id"]) if "lammps" in path else order
        check(f"ovito: {name} positions", np.allclose(particles.positions[order], state["position"][own], atol=tolerance))
        turned = particles["Orientation"][order][:, [3, 0, 1, 2]]
        check(f"ovito: {name} orientations", np.allclose(turned, state["orientation"][own], atol=tolerance))
        wanted = np.array([shape(kind, size) for kind, size in zip(state["shape"][own], state["size"][own])])
        check(f"ovito: {name} shapes", np.allclose(particles["Aspherical Shape"][order], wanted, atol=tolerance))
        if name.endswith("xyz") and "exponents" in state:
            exponents = np.where(state["exponents"] > 0, state["exponents"], 2)
            found = np.asarray(particles["superquadric_roundness"])
            check(f"ovito: {name} roundness", np.allclose(found, 2 / exponents[:, ::-1], atol=tolerance))


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("run")
    arguments.add_argument("--lammps", required=True)
    arguments.add_argument("--xyz", required=True)
    arguments = arguments.parse_args()
    import glob

    if os.path.isfile(arguments.run):
        paths = [arguments.run]
    else:
        paths = sorted(glob.glob(os.path.join(arguments.run, "states", "state_*.npz")))
    states = [np.load(path) for path in paths]
    check_ase(arguments.lammps, arguments.xyz, states)
    if ovito:
        half = lambda kind, size: np.array(extents(kind, size)) / 2
        check_ovito(arguments.lammps, states, half, 1e-6)
        check_ovito(arguments.xyz, states, drawn, 1e-6)
    else:
        print("SKIP ovito: not installed")
    sys.exit(1 if FAILED else 0)


main()
