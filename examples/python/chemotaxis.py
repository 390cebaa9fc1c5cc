"""Chemotaxis by runs and tumbles: a swimmer that goes up the gradient tumbles less often, and so drifts up it."""

import numpy as np
import relcp

SPEED, TUMBLES, SENSE = 1.0, 4.0, 0.8  # a rod tumbles at TUMBLES (1 - SENSE cos), of the angle to the gradient, x
rod = {"spherocylinder": {"diameter": 0.4, "length": 1.0}}
scene = relcp.Scene({
    "name": "chemotaxis",
    "planar": True,
    "time": {"dt": 0.02, "end": 10.0},
    "periodic": {"lengths": [80, 80, None]},
    "forces": [{"propulsion": {"force": SPEED}}],  # of rods of length 1 and drag 1
    "generate": [{"isotropic": {"count": 200, "shape": rod}}],
})
simulation = relcp.Simulation(scene)
random = np.random.default_rng(2)
start = simulation.positions
while not simulation.done:
    simulation.step()
    rate = TUMBLES * (1 - SENSE * simulation.axes[:, 0])
    tumbles = np.flatnonzero(random.random(len(rate)) < rate * scene.dt)
    angle = random.uniform(0, 2 * np.pi, len(tumbles))
    # A turn about z by the angle, after the quarter turn that lays the rod along x.
    cos, sin = np.sqrt(0.5) * np.cos(angle / 2), np.sqrt(0.5) * np.sin(angle / 2)
    simulation.set(of=tumbles, orientation=np.stack([cos, -sin, cos, sin], axis=1))
drift = (simulation.positions - start)[:, 0] / simulation.time
error = drift.std() / np.sqrt(len(drift))
expected = SPEED * (1 - np.sqrt(1 - SENSE**2)) / SENSE

if __name__ == "__main__":
    print(f"they drift by {drift.mean():.3f} +- {error:.3f} up the gradient; the closed form is {expected:.3f}")
    simulation.save_picture("chemotaxis.png", 240, 180, colour="plain")
