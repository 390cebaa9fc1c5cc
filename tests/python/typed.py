"""A program that checkers of types accept, with every class of the package; `test_types.py` has them check it."""

import pathlib
from typing import Any, Optional

import numpy as np
import numpy.typing as npt
import relcp

Floats = npt.NDArray[np.float64]


class Rules:
    def update(self, cells: relcp.Cells) -> None:
        cells.rates = 1.0 / (1.0 + np.maximum(cells.pressures, 0.0))
        cells["signal"] = np.zeros(len(cells))

    def divide(self, mother: relcp.Cell, daughters: tuple[relcp.Cell, relcp.Cell]) -> None:
        for daughter in daughters:
            daughter.division_length = 2.0 * mother.length
            daughter.length = 1.0 * daughter.length
            daughter["signal"] = 1.0


def spring(bodies: relcp.Bodies) -> Floats:
    return -2.0 * bodies.positions


def simulate(place: pathlib.Path) -> dict[str, Any]:
    scene: relcp.Scene = relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 0.1})
    simulation = relcp.Simulation(scene, threads=1)
    simulation.rules = Rules()
    simulation.add_force(spring)
    report: relcp.StepReport = simulation.step(2)
    overlap: float = report.max_overlap
    pair: Optional[tuple[int, int]] = report.worst_pair
    ids: npt.NDArray[np.int64] = simulation.ids
    groups: npt.NDArray[np.int32] = simulation.groups
    labels: list[Optional[str]] = simulation.group_labels
    simulation.change({"growth.rate": 0.9})
    simulation.set(of=[0], position=simulation.positions[:1] + 0.0, columns={"signal": 1.0})
    rods: npt.NDArray[np.bool_] = simulation.shapes == relcp.Shape.SPHEROCYLINDER
    near: relcp.Contacts = simulation.contacts(0.01)
    forces: Floats = near.force
    picture: npt.NDArray[np.uint8] = simulation.render(64, view="top", colour="length", range=(1.0, 3.0))
    page: relcp.Page = simulation.show("100%", 400)
    saved: pathlib.Path = page.save(place / "page.html")
    assert overlap < 1.0 and pair is None and ids.size == groups.size == len(labels) and rods.all()
    assert forces.size == 0 and picture.shape == (36, 64, 4) and saved.is_file()
    return simulation.run()


def record(place: pathlib.Path) -> relcp.Table:
    scene = relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 0.1, "output.every": 0.05})
    run: relcp.Run = relcp.run(scene, place / "run", forces=[spring], rules=Rules(), progress=False)
    state: relcp.State = run.states[-1]
    some: relcp.States = run.states[::2]
    times: Floats = some.times
    columns: dict[str, Floats] = state.columns
    status: str = run.status
    again: relcp.Run = run.resume(until=0.2, rules=Rules(), forces=[spring], progress=False)
    files: list[pathlib.Path] = again.export("xyz", place / "xyz")
    page: pathlib.Path = again.view(place / "view.html", colour="length", every=2, end=0.1)
    pictures: relcp.Pictures = again.pictures(64, fit="each", view="top")
    assert pictures[0].shape == (36, 64, 4) and len(pictures[1:]) == len(again.states) - 1
    assert times.size == 2 and list(columns) == ["signal"] and status == "done" and files and page.is_file()
    on_walls: Floats = state.wall_contacts(0.1).force
    vectors: pathlib.Path = run.save_picture(place / "run.svg", width=64, colour="length")
    batch: relcp.Batch = relcp.batch(scene, {"time.dt": [0.01, 0.02]}, seeds=1, out=place / "batch", progress=False)
    assert on_walls.shape == (0, 3) and vectors.is_file() and batch.table.n_rows == 2 and batch[0].status == "done"
    ensemble = relcp.Ensemble([scene], threads=1)
    stopped: list[Optional[Exception]] = ensemble.run()
    assert stopped == [None] and relcp.measures() and relcp.scenes()
    return run.measure("length")
