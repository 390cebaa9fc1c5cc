"""A switch: a cell that is pressed for long enough stops growing, for good."""

import numpy as np
import relcp


class Switch:
    threshold, patience = 2.0, 0.3

    def update(self, cells):
        pressed = cells["pressed"] if "pressed" in cells else np.zeros(len(cells))
        # The time under pressure, which a cell forgets when it is free; a cell that has switched stays so.
        forgets = np.where(pressed > self.patience, pressed, 0.0)
        cells["pressed"] = pressed = np.where(cells.pressures > self.threshold, pressed + 0.01, forgets)
        cells.rates[:] = np.where(pressed > self.patience, 0.0, 1.0)


scene = relcp.Scene.load("colony", {
    "time.dt": 0.01, "time.end": 5.5, "growth.division_length_noise": 0.2, "growth.reorientation_degrees": 5,
})  # fmt: skip
simulation = relcp.Simulation(scene)
simulation.rules = Switch()
switched = []  # after each tenth of time, the ids of the cells that rest
while not simulation.done:
    simulation.step(10)
    switched.append(set(simulation.ids[simulation.rates == 0]))
rests = simulation.rates == 0
distance = np.linalg.norm(simulation.positions - simulation.positions.mean(axis=0), axis=1)

if __name__ == "__main__":
    print(f"{rests.sum()} of {len(rests)} cells rest, at {distance[rests].mean():.1f} from the middle on average;")
    print(f"the others are at {distance[~rests].mean():.1f}")
    simulation.save_picture("pressure_switch.png", 240, 180, colour="age")
