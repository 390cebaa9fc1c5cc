"""What a decade of the overlap tolerance buys: `run.py RESULTS RELCP RAPIER`.

Each scene is run at tolerances from 1e-2 to 1e-8, and at 1e-9 for its path, from several draws of the start. A row has the
CPU time of the whole process, the largest overlap, the distance of the centres to those of the run at 1e-9 (root mean
square over the bodies) after a fifth of the time and at the end, and what `relcp measure` finds at the end.
"""

import csv
import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import numpy  # noqa: E402
import scene as scenes  # noqa: E402

TOLERANCES = [10.0**-k for k in range(2, 10)]
REFERENCE = TOLERANCES[-1]
SEEDS = [1, 2, 3]
# The lattice scene or the built-in one, the step, the end.
SCENES = {"rods": ("rods-216", 0.02, 10.0), "ellipsoids": ("ellipsoids-216", 0.1, 12.0), "colony": ("colony", 0.01, 5.7)}
# The column of `relcp measure` and its name here.
QUANTITIES = {
    "radius_gyration": "radius",
    "nematic_local": "order",
    "pressure": "pressure",
    "pushing_per_body": "contacts a body",
}


def run(relcp, folder, name, tolerance, seed):
    """A run: its row, and the centres at a fifth of the time and at the end."""
    scene, dt, end = SCENES[name]
    if scene == "colony":
        file, keys = scene, [f"time.dt={dt}", f"seed={seed}", f"contact.overlap_tolerance={tolerance}"]
    else:
        of = {**scenes.SCENES[scene], "end": end}
        file, keys = folder / "scene.json", []
        file.write_text(scenes.of_relcp(of, scenes.start(of, seed), name, dt, tolerance))
    keys += [f"time.end={end}", f"output.every={end / 5}", "output.picture=false"]
    out = folder / f"{name}-{tolerance}"
    command = [relcp, "run", file, "--backend", "cpu", "--threads", "1", "--quiet", "--out", out]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([*command, *(word for key in keys for word in ("--set", key))], check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    summary = json.loads((out / "summary.json").read_text())
    row = {
        "scene": name,
        "tolerance": tolerance,
        "seed": seed,
        "status": done.returncode,
        "cpu_s": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 3),
        "max_overlap": summary["max_overlap"],
        "bodies": summary["bodies"],
        "version": summary["version"],
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
    }
    only = ["--only", "nematic,radius,stress,contacts", "--last", "--threads", "1", "--quiet"]
    subprocess.run([relcp, "measure", out, *only], check=True)
    with open(out / "measures/measures.csv", newline="") as read:
        last = list(csv.DictReader(read))[-1]
    row.update({short: float(last[column]) for column, short in QUANTITIES.items() if last[column]})
    states = [numpy.load(state)["position"] for state in sorted((out / "states").glob("*.npz"))]
    return row, [states[1], states[-1]]


def away(here, there):
    """Root mean square over the bodies, or none where there are more of one."""
    return None if here.shape != there.shape else float(numpy.sqrt(((here - there) ** 2).sum(axis=1).mean()))


def main():
    file, relcp = pathlib.Path(sys.argv[1]), sys.argv[2]
    have = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["scene"], row["seed"], row["tolerance"]) for row in have}
    for name in SCENES:
        for seed in SEEDS:
            if all((name, seed, tolerance) in done for tolerance in TOLERANCES):
                continue
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                made = {tolerance: run(relcp, folder, name, tolerance, seed) for tolerance in TOLERANCES}
            for tolerance, (row, states) in made.items():
                paths = [away(here, there) for here, there in zip(states, made[REFERENCE][1])]
                row.update(path_early=paths[0], path_end=paths[1])
                with open(file, "a") as to:
                    to.write(json.dumps(row) + "\n")
                print(row, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
