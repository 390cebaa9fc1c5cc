"""Asymmetric division: the daughter at the lower end gets two fifths of her mother, and divides later."""

import relcp


class Asymmetric:
    share = 0.4

    def divide(self, mother, daughters):
        whole = sum(daughter.length for daughter in daughters)
        for daughter, part in zip(daughters, (self.share, 1 - self.share)):
            daughter.length = part * whole
            daughter["share"] = part


scene = relcp.Scene({
    "name": "asymmetric",
    "planar": True,
    "time": {"dt": 0.01, "end": 4.0},
    "growth": {"rate": 1.0, "division_length": 5.0, "reorientation_degrees": 2},
    "generate": [{"founder": {"diameter": 1.0, "length": 3.0}}],
})
simulation = relcp.Simulation(scene)
simulation.rules = Asymmetric()
births, shares, lives = {}, {}, {0.4: [], 0.6: []}
while not simulation.done:
    simulation.step(5)
    cells = zip(simulation.ids, simulation.births, simulation.parents, simulation.columns.get("share", [0.0]))
    for cell, birth, parent, share in cells:
        if cell not in births and shares.get(parent):
            lives[shares[parent]].append(birth - births[parent])
        births[cell], shares[cell] = birth, share
small, large = (sum(times) / len(times) for times in lives.values())

if __name__ == "__main__":
    print(f"a small daughter lives {small:.3f}, a large one {large:.3f}: ln(1 / 0.4) and ln(1 / 0.6)")
    simulation.save_picture("asymmetric.png", 240, 180, colour="length")
