"""MuJoCo on a cell of the atlas."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import checker  # noqa: E402
import mujoco  # noqa: E402
import numpy  # noqa: E402


def model_of(case):
    """The bodies, each with the mass and the inertia that give it the drag of its length."""
    settings = case["settings"]
    words = lambda numbers: " ".join(map(repr, map(float, numbers)))
    reference = words([settings.get("timeconst", 0.02), 1.0])

    def body(pose, size, mass, inertia):
        # A capsule whose axis has no length is a sphere.
        kind = "ellipsoid" if len(size) == 3 else "capsule" if size[1] > 0 else "sphere"
        size = size if kind != "sphere" else size[:1]
        return (
            f'<body pos="{words(pose[:3])}" quat="{words(pose[3:])}"><freejoint/>'
            f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{words([inertia] * 3)}"/>'
            f'<geom type="{kind}" size="{words(size)}" condim="1" solref="{reference}"/></body>'
        )

    bodies = "".join(map(body, case["poses"], case["sizes"], case["mass"], case["inertia"]))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><size memory="1G"/><option timestep="{case["dt"]}" gravity="0 0 0" '
        f'solver="{settings.get("solver", "Newton")}" integrator="implicitfast"/><worldbody>{bodies}</worldbody></mujoco>'
    )


def run(case, frames):
    """Steps a cell, writes its frames, and gives the names of what it warned of."""
    model = model_of(case)
    data = mujoco.MjData(model)
    drag = case["settings"].get("drag", 0.0)
    mass, inertia = numpy.array(case["mass"])[:, None], numpy.array(case["inertia"])[:, None]
    damping = model.dof_damping.reshape(-1, 6)
    damping[:, :3], damping[:, 3:] = drag * mass, drag * inertia
    spin, centre = numpy.array([0.0, 0.0, case["spin"]]), numpy.array([case["centre"], 0.0, 0.0])
    with open(frames, "wb") as to:
        for step in range(1, case["steps"] + 1):
            velocity = case["trap"] * (centre - data.qpos.reshape(-1, 7)[:, :3]) / mass
            if drag:
                data.xfrc_applied[1:, :3] = drag * mass * velocity
                data.xfrc_applied[1:, 3:] = drag * inertia * spin
            else:
                moving = data.qvel.reshape(-1, 6)
                moving[:, :3], moving[:, 3:] = velocity, 0.0
                if case["spin"]:
                    # Angular velocities are in the axes of the body.
                    turned = checker.rotations(data.qpos.reshape(-1, 7)[:, 3:])
                    moving[:, 3:] = numpy.einsum("kji,j->ki", turned, spin)
            mujoco.mj_step(model, data)
            if step % case["stride"] == 0 or step == case["steps"]:
                numpy.array([step * case["dt"]], "<f8").tofile(to)
                data.qpos.astype("<f8").tofile(to)
    kinds = [kind for kind in range(int(mujoco.mjtWarning.mjNWARNING)) if data.warning[kind].number]
    return [mujoco.mjtWarning(kind).name for kind in kinds]
