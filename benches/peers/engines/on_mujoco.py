"""MuJoCo on the CPU. Settings: `solver` (Newton, CG, PGS), `iterations`, `tolerance`, `timeconst` and `dampratio` of
`solref`, `dmin`, `dmax` and `width` of `solimp`, `margin`, `drag` (a force and a damping of that coefficient; without it
each body gets the field's velocity and no spin before every step), `integrator`, `ccd_tolerance` and `ccd_iterations` of
the distance of ellipsoids."""

import mujoco
import numpy
from follow import inertia, main


class Engine:
    def __init__(self, scene, poses, dt, settings):
        rod = scene["shape"] == "rod"
        size = [scene["radius"], scene["half"]] if rod else scene["radii"]
        reference = [settings.number("timeconst", 0.02), settings.number("dampratio", 1.0)]
        impedance = [settings.number("dmin", 0.9), settings.number("dmax", 0.95), settings.number("width", 1e-3), 0.5, 2]
        words = lambda numbers: " ".join(map(repr, map(float, numbers)))
        i = inertia(scene)
        bodies = "".join(
            f'<body pos="{words(pose[:3])}" quat="{words(pose[3:])}"><freejoint/>'
            f'<inertial pos="0 0 0" mass="1" diaginertia="{i} {i} {i}"/>'
            f'<geom type="{"capsule" if rod else "ellipsoid"}" size="{words(size)}" condim="1" '
            f'margin="{settings.number("margin", 0.0)}" solref="{words(reference)}" solimp="{words(impedance)}"/></body>'
            for pose in poses
        )
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><size memory="4G"/><option timestep="{dt}" gravity="0 0 0" '
            f'solver="{settings.get("solver", "Newton")}" iterations="{settings.count("iterations", 100)}" '
            f'tolerance="{settings.number("tolerance", 1e-8)}" '
            f'integrator="{settings.get("integrator", "implicitfast")}"/><worldbody>{bodies}</worldbody></mujoco>'
        )
        if "ccd_tolerance" in settings:
            self.model.opt.ccd_tolerance = settings.number("ccd_tolerance", 1e-6)
            self.model.opt.ccd_iterations = settings.count("ccd_iterations", 35)
        self.data = mujoco.MjData(self.model)
        self.drag = settings.number("drag", 0.0)
        damping = self.model.dof_damping.reshape(-1, 6)
        damping[:, :3], damping[:, 3:] = self.drag, self.drag * i

    def push(self, velocity):
        if self.drag:
            self.data.xfrc_applied[1:, :3] = self.drag * velocity
        else:
            moving = self.data.qvel.reshape(-1, 6)
            moving[:, :3], moving[:, 3:] = velocity, 0.0

    def step(self):
        mujoco.mj_step(self.model, self.data)

    def poses(self):
        # What MuJoCo gives up on it sets back to the start, and warns.
        unstable = self.data.warning[int(mujoco.mjtWarning.mjWARN_BADQACC)].number
        unstable += self.data.warning[int(mujoco.mjtWarning.mjWARN_BADQPOS)].number
        return numpy.full((self.model.nbody - 1, 7), numpy.nan) if unstable else self.data.qpos.reshape(-1, 7).copy()


if __name__ == "__main__":
    main(mujoco.__version__, Engine)
