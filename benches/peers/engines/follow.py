"""What every engine of Python shares: the arguments, the field, the clock of the processor and the frames.

`python on_ENGINE.py scene=FILE poses=FILE frames=FILE dt=0.02 [settings]`, where the scene is JSON of an entry of
`scene.SCENES`. Prints one line of JSON.
"""

import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import numpy  # noqa: E402
import scene as scenes  # noqa: E402


class Settings(dict):
    """Settings as words; `number` and `count` read one, or give its default."""

    def number(self, key, default):
        return float(self.get(key, default))

    def count(self, key, default):
        return int(self.get(key, default))


def main(version, begin):
    """Runs the scene. `begin(scene, poses, dt, settings)` gives an engine with `push(velocity)`, which hands over the
    field's velocity at each body and is not timed, `step()`, which is, and `poses()`."""
    words = dict(word.split("=", 1) for word in sys.argv[1:])
    scene = json.loads(pathlib.Path(words.pop("scene")).read_text())
    poses = scenes.read_poses(words.pop("poses"))
    frames = words.pop("frames")
    dt = float(words.pop("dt"))
    engine = begin(scene, poses, dt, Settings(words))
    steps, stride = round(scene["end"] / dt), max(1, round(scene["every"] / dt))
    seconds, ended = 0.0, None
    with open(frames, "wb") as to:
        for step in range(1, steps + 1):
            engine.push(scenes.field(poses[:, :3]))
            since = time.process_time()
            engine.step()
            seconds += time.process_time() - since
            poses = numpy.asarray(engine.poses(), float)
            if step % stride == 0 or step == steps:
                numpy.array([step * dt], "<f8").tofile(to)
                poses.astype("<f8").tofile(to)
            if not numpy.isfinite(poses).all():
                ended = f"not finite after step {step}"
                break
    said = {"version": version, "steps": step, "cpu_s": round(seconds, 6)}
    print(json.dumps(said if ended is None else {**said, "ended": ended}), flush=True)


def inertia(scene):
    """The principal inertia of a unit mass: with equal damping of both motions, the drag of a slender rod."""
    return scene["length"] ** 2 / 12
