"""PhysX 5 on the CPU, by SAPIEN. Each body gets the field's velocity and no spin before every step. Settings: `tgs` (1:
the temporal Gauss-Seidel solver, 0: the projected one), `iterations` (of positions), `velocity_iterations`, `contact_offset` (half
of the distance from which contacts are solved), `corrective` (most speed at which overlaps are undone), `drag` (a force
and a damping of that coefficient). Rods only: PhysX has no ellipsoid."""

import numpy
import sapien
import sapien.physx
from follow import inertia, main

# PhysX's capsules lie along x, rods here along z: a turn by a quarter about y.
TURN = numpy.array([numpy.sqrt(0.5), 0.0, -numpy.sqrt(0.5), 0.0])


def product(p, q):
    """Of quaternions `w i j k`."""
    a, b, c, d = numpy.moveaxis(numpy.asarray(p), -1, 0)
    w, x, y, z = numpy.moveaxis(numpy.asarray(q), -1, 0)
    parts = [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
    return numpy.stack(parts, -1)


class Engine:
    def __init__(self, scene, poses, dt, settings):
        if scene["shape"] != "rod":
            raise SystemExit("PhysX has no ellipsoid")
        physx = sapien.physx
        config = physx.get_scene_config()
        config.gravity = [0, 0, 0]
        config.enable_tgs = bool(settings.count("tgs", 1))
        config.enable_pcm = True
        physx.set_scene_config(config)
        surface = physx.get_shape_config()
        surface.contact_offset = settings.number("contact_offset", 0.01)
        surface.rest_offset = 0.0
        physx.set_shape_config(surface)
        self.system = physx.PhysxCpuSystem()
        self.system.timestep = dt
        self.scene = sapien.Scene([self.system])
        material = physx.PhysxMaterial(0.0, 0.0, 0.0)
        self.drag = settings.number("drag", 0.0)
        self.bodies = []
        for pose in poses:
            body = physx.PhysxRigidDynamicComponent()
            body.attach(physx.PhysxCollisionShapeCapsule(scene["radius"], scene["half"], material))
            body.mass = 1.0
            body.inertia = [inertia(scene)] * 3
            body.cmass_local_pose = sapien.Pose()
            body.linear_damping = body.angular_damping = self.drag
            body.solver_position_iterations = settings.count("iterations", 10)
            body.solver_velocity_iterations = settings.count("velocity_iterations", 1)
            body.max_depenetration_velocity = settings.number("corrective", 1e9)
            body.sleep_threshold = 0.0
            entity = sapien.Entity()
            entity.add_component(body)
            entity.set_pose(sapien.Pose(pose[:3], product(pose[3:], TURN)))
            self.scene.add_entity(entity)
            self.bodies.append(body)

    def push(self, velocity):
        for body, v in zip(self.bodies, velocity):
            if self.drag:
                body.add_force_torque(self.drag * v, [0, 0, 0])
            else:
                body.set_linear_velocity(v)
                body.set_angular_velocity([0, 0, 0])

    def step(self):
        self.system.step()

    def poses(self):
        at = numpy.array([[*body.entity_pose.p, *body.entity_pose.q] for body in self.bodies])
        at[:, 3:] = product(at[:, 3:], TURN * [1, -1, -1, -1])
        return at


if __name__ == "__main__":
    # The wheel does not tell the release of PhysX 5 that it holds.
    main(f"5 (SAPIEN {sapien.__version__})", Engine)
