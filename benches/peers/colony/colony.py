"""A colony of growing rods in the plane, from one cell to 1,024: relcp's built-in scene, and the same cells in Rapier,
whose harness lengthens and divides them (`rapier/src/colony.rs`): `colony.py ENGINE PROGRAM dt=... SETTING=...`."""

import json
import pathlib
import resource
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import checker  # noqa: E402
import numpy  # noqa: E402

CELLS = 1024
EVERY = 0.25
# The cells of the built-in scene.
CELL = {"radius": 0.25, "length": 2, "division": 4, "rate": 1, "turn": 0.01}


def looked_at(frames):
    """The largest overlap of frames (poses, radii, half lengths), and the last one's radius of gyration."""
    largest = 0.0
    for poses, radius, half in frames:
        if len(poses) > 1:
            largest = max(largest, checker.largest_of_rods(poses, radius, half))
    spread = poses[:, :3] - poses[:, :3].mean(axis=0)
    return {"max_overlap": largest, "gyration": float(numpy.sqrt((spread**2).sum(1).mean()))}


def of_relcp(program, tolerance, dt, **more):
    """A run by relcp, with more keys of the scene; the CPU time is that of the whole process."""
    with tempfile.TemporaryDirectory() as folder:
        keys = [f"contact.overlap_tolerance={tolerance}", f"time.dt={dt}", "time.end=9", f"output.every={EVERY}"]
        keys += [f"growth.stop.population={CELLS}", "output.picture=false", *(f"{key}={more[key]}" for key in more)]
        sets = [word for key in keys for word in ("--set", key)]
        command = [program, "run", "colony", "--backend", "cpu", "--threads", "1", "--quiet", "--out", folder + "/run"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([*command, *sets], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        out = pathlib.Path(folder, "run")
        summary = json.loads((out / "summary.json").read_text())
        frames = []
        for state in sorted((out / "states").glob("*.npz")):
            read = numpy.load(state)
            radius, length = read["size"][:, 0] / 2, read["size"][:, 1]
            frames.append((numpy.hstack([read["position"], read["orientation"]]), radius, length / 2 - radius))
        return {
            "bodies": summary["bodies"],
            "steps": summary["steps"],
            "cpu_s": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 3),
            "own_max_overlap": summary["max_overlap"],
            "version": summary["version"],
            **looked_at(frames),
        }


def of_rapier(program, settings, dt):
    """A run by Rapier; the CPU time is that of growth, division and steps."""
    with tempfile.TemporaryDirectory() as folder:
        words = {"frames": pathlib.Path(folder, "frames.f64"), "dt": dt, "cells": CELLS, "every": EVERY, **CELL, **settings}
        command = [program, "version=0.36-colony", *(f"{key}={value}" for key, value in words.items())]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        numbers, frames, at = numpy.fromfile(words["frames"], "<f8"), [], 0
        while at < len(numbers):
            rods = int(numbers[at + 1])
            rows = numbers[at + 2 : at + 2 + 9 * rods].reshape(rods, 9)
            at += 2 + 9 * rods
            frames.append((numpy.hstack([rows[:, :3], along_z(rows[:, 3:7])]), rows[:, 7], rows[:, 8]))
        said = json.loads(done.stdout.splitlines()[-1])
        return {**said, "bodies": said["cells"], **looked_at(frames)}


def along_z(q):
    """Orientations `w, x, y, z` of rods along their z axis, from those of rods along their x axis."""
    w, x, y, z = q.T
    return numpy.sqrt(0.5) * numpy.stack([w - y, x - z, w + y, x + z], axis=1)


def main():
    engine, program, *words = sys.argv[1:]
    settings = dict(word.split("=", 1) for word in words)
    dt = float(settings.pop("dt"))
    row = of_relcp(program, dt=dt, **settings) if engine == "relcp" else of_rapier(program, settings, dt)
    print(json.dumps(row))


if __name__ == "__main__":
    main()
