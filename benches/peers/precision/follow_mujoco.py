"""MuJoCo on a scene of `problems.py`: `follow_mujoco.py PROBLEM FOLDER`, where PROBLEM is a file that `run.py` writes.

For each number of steps the frames go to `FOLDER/STEPS.f64`, and a line of JSON has the least seconds of the repeats.
Only MuJoCo's own steps count: where nothing is handed over between them, all steps to the next frame in one call.
"""

import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "engines"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import mujoco  # noqa: E402
import numpy  # noqa: E402
import scene as scenes  # noqa: E402
from follow import Settings  # noqa: E402
from on_mujoco import Engine  # noqa: E402


def spent(call):
    """Seconds of a call: the less of the processor's clock, which counts its own reading, and of the other one, which
    counts other programs."""
    cpu, clock = time.process_time(), time.perf_counter()
    call()
    clock = time.perf_counter() - clock
    return min(clock, time.process_time() - cpu)


def once(engine, problem, stride):
    """Steps from the start to the end; the seconds and the poses of the frames."""
    mujoco.mj_resetData(engine.model, engine.data)
    uniform = problem["velocity"]
    seconds, frames = 0.0, []
    for _ in range(problem["frames"]):
        if uniform is not None and engine.drag:
            engine.push(numpy.array(uniform))
            seconds += spent(lambda: mujoco.mj_step(engine.model, engine.data, nstep=stride))
        else:
            for _ in range(stride):
                x = engine.data.qpos.reshape(-1, 7)[:, :3]
                engine.push(problem["mobility"] * scenes.field(x) if uniform is None else numpy.array(uniform))
                seconds += spent(engine.step)
        frames.append(engine.poses())
    return seconds, frames


def main():
    problem, folder = json.loads(pathlib.Path(sys.argv[1]).read_text()), pathlib.Path(sys.argv[2])
    for stride in problem["strides"]:
        steps = problem["frames"] * stride
        dt = problem["end"] / steps
        engine = Engine(problem["form"], numpy.array(problem["start"]), dt, Settings(problem["settings"]))
        begun, least = time.monotonic(), float("inf")
        for repeat in range(problem["repeats"]):
            if repeat and time.monotonic() - begun > problem["repeat_within"]:
                break
            seconds, frames = once(engine, problem, stride)
            least = min(least, seconds)
        numpy.array(frames).astype("<f8").tofile(folder / f"{steps}.f64")
        print(json.dumps({"steps": steps, "cpu_s": round(least, 9), "version": mujoco.__version__}), flush=True)


if __name__ == "__main__":
    main()
