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

from ._relcp import (
    NO_GROUP,
    NO_PARENT,
    Bodies,
    Bonds,
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
from ._rules import Cell, Cells

__all__ = [
    "NO_GROUP",
    "NO_PARENT",
    "Batch",
    "Bodies",
    "Bonds",
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
    "batch",
    "devices",
    "measures",
    "run",
    "scenes",
]

# What is imported when it is first asked for, and its module; with it `import relcp` would take twice as long.
_LATER = {
    "Batch": "_batch", "Page": "_page", "Pictures": "_run", "Run": "_run", "Shape": "_shape", "States": "_run", "Table": "_table",
    "batch": "_batch", "run": "_record",
}  # fmt: skip


def __getattr__(name):
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    found = getattr(importlib.import_module(f".{_LATER[name]}", __name__), name)
    globals()[name] = found
    return found


def __dir__():
    return sorted({*globals(), *__all__})


def scenes():
    """The built-in scenes: a description of each, by its name."""
    return dict(_scenes())


def measures():
    """The measures: a description of each, by its name."""
    return dict(_measures())


def _scene_of_json(text):
    """Restores a scene from its pickle."""
    return Scene.from_json(text, origin="pickle")
