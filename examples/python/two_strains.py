"""Two strains that grow at different rates: the share of the faster one rises as the exponential of the difference."""

import numpy as np
import relcp


def founder(group, x):
    return {"founder": {"diameter": 1.0, "length": 2.0, "position": [x, 0, 0], "angle": 90, "group": group}}


scene = relcp.Scene({
    "name": "two-strains",
    "planar": True,
    "time": {"dt": 0.02, "end": 3.5},
    "growth": [
        {"group": "slow", "rate": 0.8, "division_length": 4.0, "reorientation_degrees": 3},
        {"group": "fast", "rate": 1.2, "division_length": 4.0, "reorientation_degrees": 3},
    ],
    "generate": [founder("slow", -1), founder("fast", 1)],
})
simulation = relcp.Simulation(scene)
simulation.run()
slow, fast = (simulation.lengths[simulation.groups == group].sum() for group in (0, 1))
expected = np.exp((1.2 - 0.8) * simulation.time)

if __name__ == "__main__":
    print(f"the fast strain is {fast / slow:.4f} times as long; the exponential of the difference is {expected:.4f}")
    simulation.save_picture("two_strains.png", 240, 180, colour="group")
