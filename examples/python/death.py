"""Death: each cell dies at a constant rate. The scene's `removal` can do the same; here Python decides."""

import numpy as np
import relcp

RATE, EVERY = 0.3, 5
scene = relcp.Scene({
    "name": "death",
    "planar": True,
    "time": {"dt": 0.01, "end": 4.0},
    "growth": {"rate": 1.0, "division_length": 4.0, "division_length_noise": 0.1, "reorientation_degrees": 4},
    "generate": [{"isotropic": {
        "count": 12, "shape": {"spherocylinder": {"diameter": 1.0, "length": 2.5}}, "volume_fraction": 0.2,
    }}],
})  # fmt: skip
simulation = relcp.Simulation(scene)
random = np.random.default_rng(5)
died, expected = 0, 0.0
while not simulation.done:
    simulation.step(EVERY)
    probability = 1 - np.exp(-RATE * EVERY * scene.dt)
    dies = random.random(simulation.n_bodies) < probability
    expected += probability * simulation.n_bodies
    died += dies.sum()
    simulation.remove(ids=simulation.ids[dies])

if __name__ == "__main__":
    print(f"{died} cells died, {expected:.1f} were expected; {simulation.n_bodies} live")
    simulation.save_picture("death.png", 240, 180, colour="generation")
