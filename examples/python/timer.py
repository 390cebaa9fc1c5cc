"""Division by a clock: a cell divides at an age, whatever its length, by a rule or by the scene's `rule: "timer"`."""

import numpy as np
import relcp


class Clock:
    def update(self, cells):
        # A cell whose length is set as its division length divides in this step.
        cells.division_lengths[:] = np.where(cells.ages >= 0.9 - 1e-9, cells.lengths, np.inf)


scene = relcp.Scene({
    "name": "timer",
    "planar": True,
    "time": {"dt": 0.02, "end": 4.0},
    "growth": {"rate": np.log(2) / 0.9, "division_length": 100, "reorientation_degrees": 4},
    "generate": [{"founder": {"diameter": 1.0, "length": 2.5}}],
})
simulation = relcp.Simulation(scene)
simulation.rules = Clock()
simulation.run()
# Everything is in the births: those of a generation are at its number of clock times.
late = simulation.births - 0.9 * simulation.generations

if __name__ == "__main__":
    print(f"{simulation.n_bodies} cells, {simulation.generations.max()} generations, late by at most {late.max():.3f}")
    simulation.save_picture("timer.png", 240, 180, colour="length")
