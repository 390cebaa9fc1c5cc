"""A plasmid that is lost at random: of each division one daughter goes without it with some probability."""

import numpy as np
import relcp

LOSS = 0.3


class Plasmid:
    def update(self, cells):
        if "plasmid" not in cells:
            cells["plasmid"] = np.ones(len(cells))

    def divide(self, mother, daughters):
        # Drawn from the mother's id, so that a run that is resumed draws the same.
        random = np.random.default_rng([11, mother.id])
        if mother["plasmid"] and random.random() < LOSS:
            daughters[random.integers(2)]["plasmid"] = 0.0


scene = relcp.Scene({
    "name": "plasmid",
    "planar": True,
    "time": {"dt": 0.02, "end": 2.9},
    "growth": {"rate": 1.0, "division_length": 4.0, "division_length_noise": 0.05, "reorientation_degrees": 4},
    "generate": [{"isotropic": {
        "count": 24, "shape": {"spherocylinder": {"diameter": 1.0, "length": 2.0}}, "volume_fraction": 0.1,
    }}],
})  # fmt: skip
simulation = relcp.Simulation(scene)
simulation.rules = Plasmid()
simulation.run()
holds = simulation.columns["plasmid"] == 1
expected = np.mean((1 - LOSS / 2) ** simulation.generations.astype(float))

if __name__ == "__main__":
    print(f"{holds.mean():.3f} of {len(holds)} cells have it; {expected:.3f} were expected")
    simulation.save_picture("plasmid.png", 240, 180, colour="generation")
