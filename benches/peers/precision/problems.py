"""The scenes of the study of work and precision, as relcp itself begins them, and the error of an end.

What is set of each built-in scene comes from the study's own file, docs/studies/work-precision/work-precision.json. The
poses at the start come from the first state of a run of relcp, the forces from the scene file that it writes there, and
the ends from assets/references. An engine of one shape and one size a scene is enough: all bodies of a scene are equal.
"""

import json
import pathlib
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import checker  # noqa: E402
import scene as scenes  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
STUDY = ROOT / "docs/studies/work-precision/work-precision.json"
REFERENCES = ROOT / "assets/references"
# The curves of the study that are run here again.
CURVES = ["ReLCP", "ReLCP, midpoint"]
# The overlap tolerance of both, the study's and the default of scenes.
TOLERANCE = 1e-5
# A reference is good enough for an error of so many times its own estimate: as the study has it.
CERTAINTY = 3
# Engines have these scenes; by what they lack, not the other two of the study.
SCENES = ["two-ellipsoids", "three-capsules", "compaction"]


class Problem:
    """A scene, its start and its reference."""

    def __init__(self, name, relcp, folder):
        study = json.loads(STUDY.read_text())
        of = next(problem for problem in study["problems"] if problem["problem"] == name)
        self.name, self.scene, self.sets, self.end = name, of["scene"], of["sets"], of["end"]
        rows = [row for row in study["rows"] if row["problem"] == name]
        self.coarsest = min(row["steps"] for row in rows if row["curve"] in CURVES)
        reference = json.loads((REFERENCES / f"{name}.json").read_text())
        self.length, self.estimate = reference["length"], max(reference["estimate"].values())
        self.ends = numpy.array([body["position"] + body["orientation"] for body in reference["bodies"]])
        self._begin(relcp, folder)

    def _begin(self, relcp, folder):
        """Reads the start from a run of relcp with the coarsest step."""
        out = folder / f"{self.name}-start"
        self.run(relcp, out, self.coarsest, "euler", self.end)
        written = json.loads((out / "scene.json").read_text())
        first = numpy.load(sorted((out / "states").glob("*.npz"))[0])
        assert (first["id"] == numpy.arange(len(first["id"]))).all(), "bodies are in the order of their ids"
        assert (first["size"] == first["size"][0]).all(), "all bodies of a scene are equal"
        self.start = poses(first)
        size = first["size"][0].tolist()
        if "capsules" in self.name:
            diameter, length = size[:2]
            self.form = {"shape": "rod", "radius": diameter / 2, "half": (length - diameter) / 2, "length": length}
        else:
            self.form = {"shape": "ellipsoid", "radii": size, "length": 2 * max(size)}
        # A force moves a body with `force / (drag L)`, and a torque turns it with `12 torque / (drag L^3)`.
        self.mobility = 1 / (written["dynamics"]["overdamped"]["drag"] * self.form["length"])
        self.forces = forces(written)

    def run(self, relcp, out, steps, stepping, every):
        """A run of relcp; its states are left in `out`."""
        keys = [*self.sets, f"time.end={self.end}", f"time.dt={self.end / steps!r}", f"time.stepping={stepping}"]
        keys += [f'contact={{"overlap_tolerance":{TOLERANCE}}}', f"output.every={every!r}", "output.picture=false"]
        words = [word for key in keys for word in ("--set", key)]
        command = [relcp, "run", self.scene, "--backend", "cpu", "--threads", "1", "--quiet", "--out", out, *words]
        subprocess.run(command, check=True)

    def velocity(self, x):
        """What the forces make of a body that touches nothing."""
        return self.mobility * (scenes.field(x) * numpy.ones(3) if self.forces is None else self.forces)

    def error(self, ends):
        """The larger of two root mean squares: distances of centres over the length, angles between axes."""
        distance = numpy.linalg.norm(ends[:, :3] - self.ends[:, :3], axis=1) / self.length
        a, b = (checker.rotations(pose[:, 3:])[:, :, 2] for pose in (ends, self.ends))
        angle = numpy.arctan2(numpy.linalg.norm(numpy.cross(a, b), axis=1), numpy.abs((a * b).sum(axis=1)))
        return float(max(numpy.sqrt((part**2).mean()) for part in (distance, angle)))

    def overlap(self, frames):
        """The largest overlap of some frames."""
        return max(checker.largest(self.form, frame) for frame in frames)


def poses(state):
    """Poses of a state of relcp, `x y z w i j k`."""
    order = numpy.argsort(state["id"])
    return numpy.hstack([state["position"], state["orientation"]])[order]


def forces(written):
    """The uniform force on each body of a scene file, or none where the field draws all."""
    kinds = [kind for force in written["forces"] for kind in force]
    if kinds == ["radial_inward"]:
        return None
    assert set(kinds) == {"uniform"}, f"forces {kinds}: uniform ones by group, or the field"
    on = lambda body: sum(
        numpy.array(force["uniform"]["force"]) for force in written["forces"]
        if force["uniform"].get("group") in (None, body.get("group"))
    )
    return numpy.array([on(body) + numpy.zeros(3) for body in written["bodies"]])
