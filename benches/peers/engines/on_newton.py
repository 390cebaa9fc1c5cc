"""Newton (Warp) on the CPU. Each body gets the field's velocity and no spin before every step. Settings: `solver`
(`dvi_apgd`, `dvi_pgs`: complementarity, of Kamino; `padmm`; `xpbd`), `iterations`, `tolerance`, `gap` (the distance from which
contacts are solved), `speculative` (1: contacts that are still apart have the whole of their gap in the right-hand side,
as in relcp; 0: Newton's default)."""

import newton
import numpy
import warp
from follow import inertia, main


class Engine:
    def __init__(self, scene, poses, dt, settings):
        warp.config.quiet = True
        warp.set_device("cpu")
        i = inertia(scene)
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
        surface = newton.ModelBuilder.ShapeConfig(
            density=0.0,
            mu=0.0,
            restitution=0.0,
            gap=settings.number("gap", 0.1),
            mu_torsional=0.0,
            mu_rolling=0.0,
        )
        for pose in poses.tolist():
            w, x, y, z = pose[3:]
            body = builder.add_body(
                xform=warp.transform(warp.vec3(*pose[:3]), warp.quat(x, y, z, w)),
                mass=1.0,
                inertia=warp.mat33(i, 0, 0, 0, i, 0, 0, 0, i),
                lock_inertia=True,
            )
            if scene["shape"] == "rod":
                builder.add_shape_capsule(body, radius=scene["radius"], half_height=scene["half"], cfg=surface)
            else:
                rx, ry, rz = scene["radii"]
                builder.add_shape_ellipsoid(body, rx=rx, ry=ry, rz=rz, cfg=surface)
        self.model = builder.finalize(device="cpu")
        most = max(2000, 16 * len(poses))
        self.pipeline = newton.CollisionPipeline(self.model, broad_phase="sap", rigid_contact_max=most)
        self.contacts = self.pipeline.contacts()
        self.solver = solver(self.model, settings)
        self.dt = dt
        self.now, self.next, self.control = self.model.state(), self.model.state(), self.model.control()
        # Kernels are compiled at the first step: once, on states that are thrown away.
        spare = self.model.state(), self.model.state()
        self.pipeline.collide(spare[0], self.contacts)
        self.solver.step(*spare, self.control, self.contacts, dt)

    def push(self, velocity):
        moving = numpy.zeros((len(velocity), 6), numpy.float32)
        moving[:, :3] = velocity
        self.now.body_qd.assign(moving)
        self.now.joint_qd.assign(moving.reshape(-1))
        self.now.clear_forces()

    def step(self):
        self.pipeline.collide(self.now, self.contacts)
        self.solver.step(self.now, self.next, self.control, self.contacts, self.dt)
        self.now, self.next = self.next, self.now

    def poses(self):
        return self.now.body_q.numpy()[:, [0, 1, 2, 6, 3, 4, 5]].astype(float)


def solver(model, settings):
    kind, iterations = settings.get("solver", "dvi_apgd"), settings.count("iterations", 0)
    if kind == "xpbd":
        return newton.solvers.SolverXPBD(model, iterations=iterations or 10)
    config = newton.solvers.SolverKamino.Config(
        dynamics_solver=kind.split("_")[0], sparse_dynamics=True, sparse_jacobian=True
    )
    if settings.count("speculative", 1):
        config.dynamics.cull_speculative_contacts = False
        config.constraints.gamma = 1.0
        config.constraints.delta = 0.0
    if kind.startswith("dvi"):
        config.dvi.unilateral_solver = kind.split("_")[1]
        config.dvi.apgd.max_iterations = iterations or 200
        config.dvi.apgd.tolerance = settings.number("tolerance", 1e-5)
        if iterations:
            config.dvi.max_alternating_iterations = iterations
    return newton.solvers.SolverKamino(model, config=config)


if __name__ == "__main__":
    main(newton.__version__, Engine)
