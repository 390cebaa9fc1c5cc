"""Adhesion by bonds: daughters stay bonded end to end, and a founder becomes a filament that buckles as it grows."""

import numpy as np
import relcp

scene = relcp.Scene({
    "name": "adhesion",
    "planar": True,
    "time": {"dt": 0.01, "end": 3.6},
    "growth": {
        "rate": 1.0, "division_length": 4.0, "division_length_noise": 0.1, "reorientation_degrees": 1,
        "bond_daughters": {"stiffness": "rigid", "bending": 2.0},
    },
    "generate": [{"founder": {"diameter": 1.0, "length": 2.0}}],
})  # fmt: skip
simulation = relcp.Simulation(scene)
summary = simulation.run()
# Ends with the same number are bonded: the upper end of one cell, the lower one of another.
lower, upper = (simulation.columns[name] for name in ("lower_bond", "upper_bond"))
bonds = [(a, b) for a in range(len(upper)) for b in range(len(lower)) if upper[a] > 0 and upper[a] == lower[b]]
a, b = np.array(bonds).T
reach = 0.5 * (simulation.lengths - 1.0)[:, None] * simulation.axes
gaps = np.linalg.norm((simulation.positions + reach)[a] - (simulation.positions - reach)[b], axis=1) - 1.0

if __name__ == "__main__":
    print(f"{simulation.n_bodies} cells, {len(bonds)} bonds; the caps are {gaps.min():.5f} to {gaps.max():.5f} apart")
    simulation.save_picture("adhesion.png", 240, 180, colour="length")
