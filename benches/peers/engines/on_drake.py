"""Drake's multibody plant, point contact. Each body gets the field's velocity and no spin before every step. Settings:
`approximation` (`sap`, `tamsi`, `lagged`, `similar`), `stiffness` (of a contact), `dissipation`, `relaxation` (the time in steps
in which an overlap is undone, Hunt and Crossley's law apart). Contacts are made where bodies overlap: Drake has none from
a distance."""

import importlib.metadata

import numpy
from follow import inertia, main
from pydrake.geometry import AddContactMaterial, Capsule, Ellipsoid, ProximityProperties, SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.common.eigen_geometry import Quaternion
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder


class Engine:
    def __init__(self, scene, poses, dt, settings):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=dt)
        kinds = {"sap": "kSap", "tamsi": "kTamsi", "lagged": "kLagged", "similar": "kSimilar"}
        kind = kinds[settings.get("approximation", "sap")]
        plant.set_discrete_contact_approximation(getattr(DiscreteContactApproximation, kind))
        plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
        i = inertia(scene)
        mass = SpatialInertia(1.0, [0, 0, 0], UnitInertia(i, i, i))
        form = (
            Capsule(scene["radius"], 2 * scene["half"]) if scene["shape"] == "rod" else Ellipsoid(*scene["radii"])
        )
        bodies = []
        for index in range(len(poses)):
            body = plant.AddRigidBody(f"b{index}", mass)
            surface = ProximityProperties()
            AddContactMaterial(
                settings.number("dissipation", 0.0),
                settings.number("stiffness", 1e5),
                CoulombFriction(0.0, 0.0),
                surface,
            )
            surface.AddProperty("material", "relaxation_time", settings.number("relaxation", 1.0) * dt)
            plant.RegisterCollisionGeometry(body, RigidTransform(), form, f"g{index}", surface)
            bodies.append(body)
        plant.Finalize()
        diagram = builder.Build()
        self.plant, self.n, self.dt = plant, len(poses), dt
        self.simulator = Simulator(diagram)
        self.context = plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        for body, pose in zip(bodies, poses):
            q = pose[3:] / numpy.linalg.norm(pose[3:])
            plant.SetFreeBodyPose(self.context, body, RigidTransform(RotationMatrix(Quaternion(q)), pose[:3]))
        self.simulator.Initialize()
        self.time = 0

    def push(self, velocity):
        moving = numpy.zeros((self.n, 6))
        moving[:, 3:] = velocity
        self.plant.SetVelocities(self.context, moving.reshape(-1))

    def step(self):
        self.time += 1
        self.simulator.AdvanceTo(self.time * self.dt)

    def poses(self):
        q = self.plant.GetPositions(self.context).reshape(-1, 7)
        return numpy.hstack([q[:, 4:], q[:, :4]])


if __name__ == "__main__":
    main(importlib.metadata.version("drake"), Engine)
