"""Figures of the Python package: rules beside built-in growth, memory, the interpreter's lock, time of the import.

    python benches/python.py [ruled] [memory] [lock] [import]

The package must be installed. Timings are by turns, in one process; nothing is asserted.
"""

import statistics
import subprocess
import sys
import threading
import time

import numpy as np
import relcp

CELLS, TURNS = 1024, 3
COLONY = {
    "time.dt": 0.005, "time.end": 12, "growth.division_length_noise": 0.1, "growth.stop": {"population": CELLS},
}  # fmt: skip


class Rules:
    """What the scene's `growth` does, decided by Python: a rate and a length at division for each cell."""

    def update(self, cells):
        cells.rates[:] = 1.0
        if "ripe" not in cells:
            cells["ripe"] = np.full(len(cells), 4.0)
        cells.division_lengths[:] = cells["ripe"]

    def divide(self, mother, daughters):
        for daughter in daughters:
            daughter["ripe"] = 4.0 * (1.0 + 0.1 * np.random.default_rng([1, daughter.id]).uniform(-1, 1))


def grow(rules):
    simulation = relcp.Simulation(relcp.Scene.load("colony", COLONY))
    simulation.rules = rules
    begun = time.perf_counter()
    simulation.run()
    return time.perf_counter() - begun, simulation.n_steps, simulation.n_bodies


def ruled():
    """A colony to 1,024 cells by turns."""
    ratios = []
    for _ in range(TURNS):
        (built_in, steps, cells), (own, own_steps, own_cells) = grow(None), grow(Rules())
        ratios.append((own / own_steps) / (built_in / steps))
        print(f"built in: {built_in:.2f} s, {steps} steps, {cells} cells; ruled: {own:.2f} s, {own_steps}, {own_cells}")
    print(f"time of a step by rules over that without: median {statistics.median(ratios):.2f} of {ratios}")


def resident():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096 / 1e6


def memory():
    """What is resident after 1e4 and 1e5 steps of a small scene with a callback at every step."""
    scene = relcp.Scene.load("two-ellipsoids", {"time.dt": 0.001, "time.end": 110})
    simulation = relcp.Simulation(scene, threads=1)
    simulation.add_force(lambda bodies: 0.0 * bodies.positions)
    for steps in (10_000, 100_000):
        while simulation.n_steps < steps:
            simulation.run(until=scene.dt * min(steps, simulation.n_steps + 1000), callback=lambda report: report.time)
        print(f"{simulation.n_steps} steps: {resident():.1f} MB resident")


def lock():
    """How far another thread counts while this one takes steps, over how far it counts alone."""
    simulation = relcp.Simulation(relcp.Scene.load("colony", {"time.dt": 0.01, "time.end": 6}), threads=1)
    simulation.run(until=5)
    counted, over = [0], threading.Event()

    def count():
        while not over.is_set():
            counted[0] += 1

    threading.Thread(target=count).start()
    time.sleep(0.5)
    before = counted[0]
    time.sleep(1.0)
    alone, begun, before = counted[0] - before, time.perf_counter(), counted[0]
    simulation.run()
    meanwhile, spent = counted[0] - before, time.perf_counter() - begun
    over.set()
    print(f"counts a second: {alone:.3g} alone, {meanwhile / spent:.3g} while steps are taken for {spent:.2f} s")


def import_():
    """The time of `import relcp` in a new process, less that of a process that imports nothing."""
    def spent(code):
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        return time.perf_counter() - begun

    pairs = [(spent("import relcp"), spent("pass")) for _ in range(9)]
    own = statistics.median(a - b for a, b in pairs)
    alone = statistics.median(b for _, b in pairs)
    print(f"import relcp: {1e3 * own:.1f} ms beside an interpreter of {1e3 * alone:.1f} ms")


if __name__ == "__main__":
    for name in sys.argv[1:] or ["ruled", "memory", "lock", "import"]:
        {"ruled": ruled, "memory": memory, "lock": lock, "import": import_}[name]()
