"""relcp: writes the scene file, runs `relcp run` and reads its states. The seconds are those of the whole process, with
reading the scene and writing states. Settings: `program` (the path), `tolerance`, and any key of a scene."""

import json
import pathlib
import resource
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import numpy  # noqa: E402
import scene as scenes  # noqa: E402


def main():
    words = dict(word.split("=", 1) for word in sys.argv[1:])
    scene = json.loads(pathlib.Path(words.pop("scene")).read_text())
    poses = scenes.read_poses(words.pop("poses"))
    frames, dt, program = words.pop("frames"), float(words.pop("dt")), words.pop("program")
    tolerance = float(words.pop("tolerance", 1e-5))
    with tempfile.TemporaryDirectory() as folder:
        file, out = pathlib.Path(folder, "scene.json"), pathlib.Path(folder, "run")
        file.write_text(scenes.of_relcp(scene, poses, "peers", dt, tolerance))
        keys = [part for key, value in words.items() for part in ("--set", f"{key}={value}")]
        command = [program, "run", file, "--backend", "cpu", "--threads", "1", "--quiet", "--out", out, *keys]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if not (out / "summary.json").exists():
            raise SystemExit(done.stderr)
        summary = json.loads((out / "summary.json").read_text())
        with open(frames, "wb") as to:
            for state in sorted((out / "states").glob("*.npz"))[1:]:
                read = numpy.load(state)
                time = json.loads(bytes(read["header"]))["time"]
                numpy.array([time], "<f8").tofile(to)
                numpy.hstack([read["position"], read["orientation"]]).astype("<f8").tofile(to)
    said = {
        "version": summary["version"],
        "steps": summary["steps"],
        "cpu_s": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 6),
        "own_max_overlap": summary["max_overlap"],
    }
    if done.returncode:
        said["ended"] = f"exit status {done.returncode}: {summary['reason']}"
    print(json.dumps(said))


if __name__ == "__main__":
    main()
