"""Smooth rigid bodies in contact: spheres, rods, ellipsoids and rings that do not overlap, by the ReLCP method.

    import relcp

    scene = relcp.Scene.load("two-ellipsoids", {"time.end": 20})
    simulation = relcp.Simulation(scene)
    while not simulation.done:
        report = simulation.step()
        assert report.max_overlap <= 1e-5
    print(simulation.positions)        # (N, 3), a read-only copy; simulation.set(position=...) writes
    print(simulation.contacts(0.01).pairs)

    run = relcp.run(scene, "two")      # the same, recorded as by the program: relcp.Run("two") reads it back
    print(run.steps["max_overlap"].max(), run.states[-1].positions)

Lengths, times and forces are in the scene's own units. Orientations are [w, x, y, z], body axes to space.
"""

import enum

from ._relcp import (
    NO_GROUP,
    NO_PARENT,
    Bodies,
    Contacts,
    DeviceError,
    Ensemble,
    Error,
    RecordError,
    Scene,
    SceneError,
    Simulation,
    SimulationError,
    State,
    StepReport,
    WallContacts,
    __version__,
    devices,
)
from ._relcp import measures as _measures
from ._relcp import scenes as _scenes
from ._relcp import shapes as _shapes
from ._page import Page
from ._rules import Cell, Cells
from ._run import Pictures, Run, States, run
from ._table import Table

__all__ = [
    "NO_GROUP",
    "NO_PARENT",
    "Bodies",
    "Cell",
    "Cells",
    "Contacts",
    "DeviceError",
    "Ensemble",
    "Error",
    "Page",
    "Pictures",
    "RecordError",
    "Run",
    "Scene",
    "SceneError",
    "Shape",
    "Simulation",
    "SimulationError",
    "State",
    "States",
    "StepReport",
    "Table",
    "WallContacts",
    "__version__",
    "devices",
    "measures",
    "run",
    "scenes",
]

Shape = enum.IntEnum("Shape", [(name, code) for name, code in _shapes()], module=__name__)
Shape.__doc__ = "The shapes, as `shapes` has them: `simulation.shapes == relcp.Shape.TORUS`."


def scenes():
    """The built-in scenes: a description of each, by its name."""
    return dict(_scenes())


def measures():
    """The measures: a description of each, by its name."""
    return dict(_measures())


def _scene_of_json(text):
    """Restores a scene from its pickle."""
    return Scene.from_json(text, origin="pickle")
