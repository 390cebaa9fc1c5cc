"""Bullet 3 by PyBullet. Each body gets the field's velocity and no spin before every step. Settings: `iterations`,
`erp` (the part of an overlap that a step takes back), `substeps`, `processing` (the distance from which contacts are
solved), `slop`, `margin`. Rods only: Bullet has no ellipsoid."""

import importlib.metadata

import pybullet
from follow import inertia, main


class Engine:
    def __init__(self, scene, poses, dt, settings):
        if scene["shape"] != "rod":
            raise SystemExit("Bullet has no ellipsoid")
        pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, 0, 0)
        erp = settings.number("erp", 0.2)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=dt,
            numSolverIterations=settings.count("iterations", 50),
            numSubSteps=settings.count("substeps", 0),
            erp=erp,
            contactERP=erp,
            contactSlop=settings.number("slop", 1e-5),
            deterministicOverlappingPairs=1,
            enableConeFriction=0,
        )
        rod = pybullet.createCollisionShape(
            pybullet.GEOM_CAPSULE, radius=scene["radius"], height=2 * scene["half"]
        )
        self.bodies = []
        for pose in poses.tolist():
            x, (w, i, j, k) = pose[:3], pose[3:]
            body = pybullet.createMultiBody(1.0, rod, -1, x, [i, j, k, w])
            pybullet.changeDynamics(
                body,
                -1,
                lateralFriction=0,
                restitution=0,
                linearDamping=0,
                angularDamping=0,
                localInertiaDiagonal=[inertia(scene)] * 3,
                activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
                contactProcessingThreshold=settings.number("processing", 0.02),
            )
            self.bodies.append(body)

    def push(self, velocity):
        for body, v in zip(self.bodies, velocity.tolist()):
            pybullet.resetBaseVelocity(body, v, [0, 0, 0])

    def step(self):
        pybullet.stepSimulation()

    def poses(self):
        at = (pybullet.getBasePositionAndOrientation(body) for body in self.bodies)
        return [[*x, w, i, j, k] for x, (i, j, k, w) in at]


if __name__ == "__main__":
    main(importlib.metadata.version("pybullet"), Engine)
