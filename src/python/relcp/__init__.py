"""Smooth rigid bodies in contact: spheres, rods, ellipsoids and rings that do not overlap, by the ReLCP method.

    import relcp

    scene = relcp.Scene.load("two-ellipsoids", {"time.end": 20})
    simulation = relcp.Simulation(scene)
    while not simulation.done:
        report = simulation.step()
        assert report.max_overlap <= 1e-5
    print(simulation.positions)        # (N, 3), a read-only copy; simulation.set(position=...) writes
    print(simulation.contacts(0.01).pairs)

Lengths, times and forces are in the scene's own units. Orientations are [w, x, y, z], body axes to space.
"""

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
    StepReport,
    WallContacts,
    __version__,
    devices,
)
from ._relcp import scenes as _scenes
from ._rules import Cell, Cells

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
    "RecordError",
    "Scene",
    "SceneError",
    "Simulation",
    "SimulationError",
    "StepReport",
    "WallContacts",
    "__version__",
    "devices",
    "scenes",
]


def scenes():
    """The built-in scenes: a description of each, by its name."""
    return dict(_scenes())


def _scene_of_json(text):
    """Restores a scene from its pickle."""
    return Scene.from_json(text, origin="pickle")
