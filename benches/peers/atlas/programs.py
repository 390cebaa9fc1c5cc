"""A cell run by relcp, Rapier or MuJoCo. Each gives frames (times and poses) and what the program itself said.

Where an engine has several settings here, each is run, and the best verdict counts: what a user can have from it.
"""

import json
import multiprocessing
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys

import numpy
import on_mujoco

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import scene as scenes  # noqa: E402

# CPU seconds that a cell may take, and by the clock so many times that.
LIMIT = 60
WALL = 10
# Frames that are kept of a cell at most.
FRAMES = 100
# relcp's tolerance: over the thickness of 0.5 it is two hundred-thousandths.
TOLERANCE = 1e-5
# The drag of engines that are driven by a force: motion is smoothed over a tenth of a unit of time.
DRAG = 10.0

RAPIER = {
    "default": {},
    "stiff": {
        "drag": DRAG,
        "iterations": 16,
        "frequency": 1000,
        "damping_ratio": 1,
        "prediction": 0.2,
        "corrective": 1e9,
        "recycling": 0,
    },
}
MUJOCO = {"default": {}, "CG, drag": {"solver": "CG", "drag": DRAG, "timeconst": 0.01}}


def said(kind, words=""):
    """How a program ended, by itself: `done`, `reported` or `crashed`."""
    return {"end": kind, "words": " ".join(words.split())[-300:]}


def message(text):
    """relcp's message without its frame: what stands between the cross and the excerpt of the scene."""
    text = text.rsplit("×", 1)[-1].split("╭")[0].replace("│", " ")
    return re.sub(r"^\S*scene\.json:\d+:\d+: ", "", " ".join(text.split()))


def limited():
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT + 5))


def launch(command):
    """A process that is limited in its time: its standard output, or how it ended."""
    environment = {**os.environ, "RAYON_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            list(map(str, command)), env=environment, capture_output=True, text=True, preexec_fn=limited,
            timeout=WALL * LIMIT, check=False,
        )
    except subprocess.TimeoutExpired:
        return None, said("slow", f"{WALL * LIMIT} s of the clock")
    if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return None, said("slow", f"{LIMIT} s of CPU time")
    return done, None


def by_relcp(case, tools, folder, settings):
    """`relcp run`. Its status 2 and 3 are reports; any other but 0 is a failure."""
    scene, out = folder / "scene.json", folder / "run"
    scene.write_text(json.dumps(of_relcp(case)))
    command = [tools["relcp"], "run", scene, "--threads", "1", "--quiet", "--out", out, *settings]
    done, ended = launch(command)
    if ended:
        return [], ended
    frames = []
    for state in sorted((out / "states").glob("*.npz"))[1:]:
        read = numpy.load(state)
        time = json.loads(bytes(read["header"]))["time"]
        frames.append((time, numpy.hstack([read["position"], read["orientation"]])))
    if done.returncode == 5 and "coordinate" not in done.stderr:
        return None, said("refused", message(done.stderr))
    # A device refuses coordinates that it does not have.
    if done.returncode in (2, 3, 5):
        return frames, said("reported", message(done.stderr))
    if done.returncode:
        return frames, said("crashed", f"status {done.returncode}: {done.stderr}")
    summary = json.loads((out / "summary.json").read_text())
    return frames, {**said("done"), "own": summary["final_max_overlap" if case.overlapping else "max_overlap"]}


def of_relcp(case):
    """The scene file. A unit force moves the first body with unit speed."""
    first = float(case.lengths[0])
    shapes = (
        [{"ellipsoid": {"radii": list(map(float, radii))}} for radii in case.radii]
        if case.radii is not None
        else [rod_of_relcp(*map(float, size)) for size in case.sizes]
    )
    forces = [{"trap": {"center": [case.distance, 0, 0], "stiffness": case.stiffness}}]
    if case.spin:
        forces.append({"torque": {"torque": [0, 0, case.spin * first**2 / 12]}})
    end = case.steps * case.dt
    return {
        "name": "atlas",
        "seed": 1,
        "dynamics": {"overdamped": {"drag": 1 / first}},
        "time": {"dt": case.dt, "end": end},
        "contact": {"overlap_tolerance": TOLERANCE},
        "forces": forces,
        "bodies": [
            {"shape": shape, "position": list(pose[:3]), "orientation": list(pose[3:])}
            for shape, pose in zip(shapes, case.poses.tolist())
        ],
        "output": {"every": stride(case) * case.dt, "picture": False},
    }


def rod_of_relcp(radius, half):
    if half == 0:
        return {"sphere": {"radius": radius}}
    return {"spherocylinder": {"diameter": 2 * radius, "length": 2 * (half + radius)}}


def stride(case):
    """Steps from a frame to the next."""
    return max(1, -(-case.steps // FRAMES))


def by_rapier(case, tools, folder, settings, version="0.36"):
    poses, sizes, frames = folder / "poses.f64", folder / "sizes.f64", folder / "frames.f64"
    scenes.write_poses(poses, case.poses)
    scenes.write_poses(sizes, case.sizes)
    words = {"version": version, "poses": poses, "sizes": sizes, "frames": frames, "dt": case.dt}
    words.update(end=case.steps * case.dt, every=stride(case) * case.dt, centre=case.distance, trap=case.stiffness)
    words.update(spin=case.spin, **settings)
    done, ended = launch([tools["rapier"], *(f"{key}={value}" for key, value in words.items())])
    if ended:
        return [], ended
    if done.returncode:
        return [], said("crashed", done.stderr)
    times, read = scenes.read_frames(frames, len(case.poses))
    return list(zip(times, read)), said("done")


def by_rapier_f64(case, tools, folder, settings):
    return by_rapier(case, tools, folder, settings, "0.36-f64")


def by_mujoco(case, tools, folder, settings):
    """A process of its own, forked from this one, where the library is loaded; what MuJoCo warns of is its report."""
    frames, mass = folder / "frames.f64", case.lengths / case.lengths[0]
    given = {
        "poses": case.poses.tolist(),
        "sizes": (case.sizes if case.radii is None else case.radii).tolist(),
        "mass": mass.tolist(),
        "inertia": (mass * case.lengths**2 / 12).tolist(),
        "trap": case.stiffness,
        "centre": case.distance,
        "spin": case.spin,
        "dt": case.dt,
        "steps": case.steps,
        "stride": stride(case),
        "settings": settings,
    }
    context = multiprocessing.get_context("fork")
    into, out = context.Pipe(duplex=False)

    def child():
        limited()
        # Its warnings are read from its data.
        os.chdir(folder)
        out.send(on_mujoco.run(given, frames))

    process = context.Process(target=child, daemon=True)
    process.start()
    out.close()
    try:
        warned = into.recv() if into.poll(WALL * LIMIT) else None
    except EOFError:
        warned = None
    process.kill()
    process.join()
    if warned is None:
        slow = process.exitcode in (-signal.SIGXCPU, -signal.SIGKILL)
        return [], said("slow", f"{LIMIT} s of CPU time") if slow else said("crashed", f"status {process.exitcode}")
    times, read = scenes.read_frames(frames, len(case.poses))
    return list(zip(times, read)), said("reported" if warned else "done", ", ".join(warned))


CPU = ["--backend", "cpu"]
# The programs, the call, its settings, and the maps that it is in (`None`: all).
PROGRAMS = {
    "relcp": (by_relcp, {"1e-5": CPU}, None),
    "relcp, f32": (by_relcp, {"1e-5": ["--backend", "gpu", "--precision", "f32"]}, ["distance"]),
    "rapier": (by_rapier, RAPIER, None),
    "rapier, f64": (by_rapier_f64, RAPIER, ["distance"]),
    "mujoco": (by_mujoco, MUJOCO, None),
}
