"""A mother machine: cells grow in trenches, and those that are pushed out of the open end are washed away."""

import numpy as np
import relcp

scene = relcp.Scene.load("mother-machine", {"time.dt": 0.02, "time.end": 6.0, "output.measures": []})
simulation = relcp.Simulation(scene)
summary = simulation.run()
cells = simulation.groups == scene.group_names.index("cells")
trench = np.rint(simulation.positions[:, 0] / 4).astype(int)
# The mother of each trench is its lowest cell.
mothers = [np.flatnonzero(cells & (trench == nth))[simulation.positions[cells & (trench == nth), 1].argmin()]
           for nth in range(8)]  # fmt: skip
filled = [simulation.lengths[cells & (trench == nth)].sum() for nth in range(8)]

if __name__ == "__main__":
    print(f"{cells.sum()} cells in 8 trenches, {summary['removed']} washed away; {np.mean(filled):.1f} long a trench")
    simulation.save_picture("mother_machine.png", 240, 180, colour="age")
