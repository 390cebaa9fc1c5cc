"""Engines that take a case of `rough.py`. `run(case, dt, settings)` gives the frames and the CPU seconds of the steps.

Settings are of each engine; the first one of each in `SETTINGS` is its default.
"""

import json
import math
import pathlib
import resource
import subprocess
import tempfile
import time

import numpy
from rough import Frames

DENSITY = 3 / (4 * math.pi)


def mass(body):
    r, h = body["radius"], body["half"]
    return DENSITY * (4 / 3 * math.pi * r**3 + 2 * math.pi * r * r * h)


def turn_to(axis):
    """The quaternion w, x, y, z that turns z to `axis`, which is x or z."""
    return [math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0] if axis[0] else [1.0, 0.0, 0.0, 0.0]


def follow(case, dt, step, state):
    """Takes the steps; only these are timed."""
    times, rows, seconds = [0.0], [state()], 0.0
    stride = round(case["every"] / dt)
    for k in range(1, round(case["end"] / dt) + 1):
        since = time.process_time()
        step()
        seconds += time.process_time() - since
        if k % stride == 0:
            times.append(k * dt)
            rows.append(state())
    return Frames(times, rows), seconds


class Relcp:
    """The whole process counts."""

    name = "relcp"

    def __init__(self, program):
        self.program = program

    def run(self, case, dt, settings):
        shape = lambda b: (
            {"spherocylinder": {"diameter": 2 * b["radius"], "length": 2 * (b["half"] + b["radius"])}}
            if b["half"]
            else {"sphere": {"radius": b["radius"]}}
        )
        scene = {
            "name": "friction",
            "dynamics": {"inertial": {"density": DENSITY}},
            "time": {"dt": dt, "end": case["end"]},
            "contact": {"friction": case["mu"], **settings.get("contact", {})},
            "solver": settings.get("solver", {}),
            "forces": [{"gravity": {"acceleration": case["gravity"]}}],
            "walls": [{"half_space": {"normal": p[:3], "offset": p[3]}} for p in case["planes"]],
            "bodies": [
                {
                    "shape": shape(b),
                    "position": b["position"],
                    "orientation": turn_to(b["axis"]),
                    "velocity": b["velocity"],
                    "angular_velocity": b["spin"],
                }
                for b in case["bodies"]
            ],
            "output": {"every": case["every"]},
        }
        with tempfile.TemporaryDirectory() as folder:
            file, out = pathlib.Path(folder, "scene.json"), pathlib.Path(folder, "run")
            file.write_text(json.dumps(scene))
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            command = [self.program, "run", file, "--backend", "cpu", "--threads", "1", "--quiet", "--out", out]
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            if done.returncode:
                raise RuntimeError(f"exit status {done.returncode}: {done.stderr.strip()[-200:]}")
            times, rows = [], []
            for state in sorted((out / "states").glob("*.npz")):
                read = numpy.load(state)
                times.append(json.loads(bytes(read["header"]))["time"])
                rows.append(numpy.hstack([read["position"], read["velocity"], read["angular_velocity"]]))
        return Frames(times, rows), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Mujoco:
    name = "MuJoCo"

    def run(self, case, dt, settings):
        import mujoco

        given = {"cone": "pyramidal", "impratio": 1, "iterations": 100, "noslip": 0, "solref": "0.02 1", **settings}
        words = lambda numbers: " ".join(map(repr, map(float, numbers)))
        surface = f'friction="{case["mu"]} 0 0" condim="3" solref="{given["solref"]}"'
        if "solimp" in given:
            surface += f' solimp="{given["solimp"]}"'
        xml = "".join(
            f'<body pos="{words(b["position"])}" quat="{words(turn_to(b["axis"]))}"><freejoint/>'
            f'<geom type="{"capsule" if b["half"] else "sphere"}" density="{DENSITY}" {surface} '
            f'size="{words([b["radius"], b["half"]] if b["half"] else [b["radius"]])}"/></body>'
            for b in case["bodies"]
        )
        planes = "".join(
            f'<geom type="plane" size="0 0 1" zaxis="{words(p[:3])}" {surface} '
            f'pos="{words([p[3] * x for x in p[:3]])}"/>'
            for p in case["planes"]
        )
        model = mujoco.MjModel.from_xml_string(
            f'<mujoco><size memory="1G"/><option timestep="{dt}" gravity="{words(case["gravity"])}" cone="{given["cone"]}" '
            f'impratio="{given["impratio"]}" iterations="{given["iterations"]}" noslip_iterations="{given["noslip"]}"/>'
            f"<worldbody>{planes}{xml}</worldbody></mujoco>"
        )
        data = mujoco.MjData(model)
        data.qvel[:] = numpy.array([[*b["velocity"], *b["spin"]] for b in case["bodies"]]).ravel()

        def state():
            q, v = data.qpos.reshape(-1, 7), data.qvel.reshape(-1, 6)
            return numpy.hstack([q[:, :3], v]).copy()

        return follow(case, dt, lambda: mujoco.mj_step(model, data), state)


class Bullet:
    name = "Bullet"

    def run(self, case, dt, settings):
        import pybullet

        given = {"iterations": 50, "cone": 0, "erp": 0.2, "slop": 1e-5, **settings}
        client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(*case["gravity"])
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=dt,
            numSolverIterations=given["iterations"],
            erp=given["erp"],
            contactERP=given["erp"],
            contactSlop=given["slop"],
            deterministicOverlappingPairs=1,
            enableConeFriction=given["cone"],
        )
        # Coefficients of two surfaces are multiplied.
        surface = dict(lateralFriction=math.sqrt(case["mu"]), restitution=0, spinningFriction=0, rollingFriction=0)
        surface.update(linearDamping=0, angularDamping=0)
        for plane in case["planes"]:
            shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=plane[:3])
            wall = pybullet.createMultiBody(0, shape, -1, [plane[3] * x for x in plane[:3]])
            pybullet.changeDynamics(wall, -1, **surface)
        bodies = []
        for b in case["bodies"]:
            rod = b["half"] > 0
            kind = pybullet.GEOM_CAPSULE if rod else pybullet.GEOM_SPHERE
            more = {"height": 2 * b["half"]} if rod else {}
            shape = pybullet.createCollisionShape(kind, radius=b["radius"], **more)
            w, i, j, k = turn_to(b["axis"])
            body = pybullet.createMultiBody(mass(b), shape, -1, b["position"], [i, j, k, w])
            pybullet.changeDynamics(body, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, **surface)
            pybullet.resetBaseVelocity(body, b["velocity"], b["spin"])
            bodies.append(body)

        def state():
            of = lambda b: [*pybullet.getBasePositionAndOrientation(b)[0], *sum(pybullet.getBaseVelocity(b), ())]
            return [of(body) for body in bodies]

        found = follow(case, dt, pybullet.stepSimulation, state)
        pybullet.disconnect(client)
        return found


class Physx:
    name = "PhysX"

    def run(self, case, dt, settings):
        import sapien
        import sapien.physx

        given = {"tgs": 1, "iterations": 10, "velocity_iterations": 1, "pcm": 1, **settings}
        physx = sapien.physx
        config = physx.get_scene_config()
        config.gravity = case["gravity"]
        config.enable_tgs, config.enable_pcm = bool(given["tgs"]), bool(given["pcm"])
        config.enable_friction_every_iteration = True
        # Every bounce: restitution is zero.
        physx.set_scene_config(config)
        surface = physx.get_shape_config()
        surface.contact_offset, surface.rest_offset = given.get("offset", 0.01), 0.0
        physx.set_shape_config(surface)
        system = physx.PhysxCpuSystem()
        system.timestep = dt
        scene = sapien.Scene([system])
        material = physx.PhysxMaterial(case["mu"], case["mu"], 0.0)
        turned = lambda normal: next(
            q
            for q, n in [
                ([math.sqrt(0.5), 0, -math.sqrt(0.5), 0], [0, 0, 1]),
                ([1, 0, 0, 0], [1, 0, 0]),
                ([0, 0, 0, 1], [-1, 0, 0]),
                ([math.sqrt(0.5), 0, 0, math.sqrt(0.5)], [0, 1, 0]),
                ([math.sqrt(0.5), 0, 0, -math.sqrt(0.5)], [0, -1, 0]),
            ]
            if list(map(float, n)) == list(map(float, normal))
        )
        for plane in case["planes"]:
            wall = physx.PhysxRigidStaticComponent()
            wall.attach(physx.PhysxCollisionShapePlane(material))
            entity = sapien.Entity()
            entity.add_component(wall)
            entity.set_pose(sapien.Pose([plane[3] * x for x in plane[:3]], turned(plane[:3])))
            scene.add_entity(entity)
        bodies = []
        for b in case["bodies"]:
            body = physx.PhysxRigidDynamicComponent()
            # Capsules lie along x, as the rods of the cases.
            shape = (
                physx.PhysxCollisionShapeCapsule(b["radius"], b["half"], material)
                if b["half"]
                else physx.PhysxCollisionShapeSphere(b["radius"], material)
            )
            shape.density = DENSITY
            body.attach(shape)
            body.linear_damping = body.angular_damping = 0.0
            body.solver_position_iterations = given["iterations"]
            body.solver_velocity_iterations = given["velocity_iterations"]
            body.sleep_threshold = 0.0
            entity = sapien.Entity()
            entity.add_component(body)
            entity.set_pose(sapien.Pose(b["position"]))
            scene.add_entity(entity)
            body.set_linear_velocity(b["velocity"])
            body.set_angular_velocity(b["spin"])
            bodies.append(body)

        def state():
            return [[*b.entity_pose.p, *b.get_linear_velocity(), *b.get_angular_velocity()] for b in bodies]

        return follow(case, dt, system.step, state)


class Rapier:
    name = "Rapier 0.36"

    def __init__(self, program):
        self.program = program

    def run(self, case, dt, settings):
        numbers = [dt, case["end"], case["every"], case["mu"], *case["gravity"], len(case["planes"])]
        numbers += [x for plane in case["planes"] for x in plane]
        for b in case["bodies"]:
            w, i, j, k = turn_to(b["axis"])
            numbers += [b["radius"], b["half"], *b["position"], w, i, j, k, *b["velocity"], *b["spin"]]
        with tempfile.TemporaryDirectory() as folder:
            scene, frames = pathlib.Path(folder, "scene"), pathlib.Path(folder, "frames")
            numpy.array(numbers, "<f8").tofile(scene)
            words = [f"{key}={value}" for key, value in settings.items()]
            command = [self.program, "version=0.36-friction", f"scene={scene}", f"frames={frames}", *words]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                raise RuntimeError(done.stderr.strip()[-200:])
            found = numpy.fromfile(frames, "<f8").reshape(-1, 1 + 9 * len(case["bodies"]))
        rows = found[:, 1:].reshape(len(found), -1, 9)
        return Frames(found[:, 0], rows), json.loads(done.stdout)["cpu_s"]


# Each engine's default, and what was found best for friction.
SETTINGS = {
    "relcp": {
        "default": {},
        # The overlap of Rapier's heap, the least of the engines.
        "as much overlap as Rapier": {
            "contact": {"overlap_tolerance": 0.032, "elastic_slip": 0.001},
            "solver": {"tolerance": 0.03},
        },
    },
    "Rapier 0.36": {
        "default": {},
        "16 iterations, stiff": {"iterations": 16, "frequency": 300, "damping_ratio": 5},
    },
    "MuJoCo": {
        "default": {},
        "elliptic, stiff, no slip": {
            "cone": "elliptic",
            "impratio": 100,
            "noslip": 20,
            "solref": "0.02 1",
            "solimp": "0.99 0.999 0.001 0.5 2",
        },
    },
    "PhysX": {"default": {}, "32 iterations": {"iterations": 32, "velocity_iterations": 4}},
    "Bullet": {"default": {}, "cone, 200 iterations": {"cone": 1, "iterations": 200}},
}
