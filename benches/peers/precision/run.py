"""What an error at the end costs, relcp beside Rapier and MuJoCo: `run.py RESULTS RELCP RAPIER`.

Scenes, starts and references are those of `relcp-lab work-precision` (see `problems.py`). A row is a program with a
setting at a number of steps: the error at the end, the largest overlap of the saved frames by the checker of this
folder, and the seconds of the steps. All is measured in rounds, each program in turn; a row that is there is not
measured again.

Seconds are those of the steps alone, on one core, and where another program shares it as nearly as can be those of
this one. relcp has no clock of the processor: of a run its seconds are the least of the study's, which runs here
again and repeats short runs in one process, and the sum over the steps of the least that a step took by the clock in
any round. Of engines see `follow_mujoco.py` and `../rapier/src/run.rs`: the least of some repeats in one process.
"""

import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy
import problems

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import scene as scenes  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ENGINES = json.loads((HERE.parent / "engines.json").read_text())
# "hard" settings are those of some trials that came nearest to the references. On two ellipsoids, 12,800 steps,
# MuJoCo's error is 3e-4 with distances to 1e-9 and to 1e-12, which takes a fifth more time, and 2e-3 or more with its
# own 1e-6. On three capsules, 6,400 steps, Rapier's is 1e-2 at the frequency 1e3 of its contacts and 2e-4 at 1e4 and
# 1e5.
OWN = json.loads((HERE / "settings.json").read_text())
# Rapier has no ellipsoid.
HAVE = {"rapier-0.36": ["three-capsules"], "mujoco": problems.SCENES}
# The coarsest step of the study is halved up to so many times.
HALVINGS = 8
# How often everything is measured; and the repeats of a run in one process, as in the study.
ROUNDS = 2
REPEATS, REPEAT_WITHIN = 5, 0.1
# Runs of relcp in a round beside the study, each in a process of its own.
RUNS = 2
# The study's error and the one that is computed here from the states of the same run differ by roundings.
ROUNDING = 1e-6
STEPPING = {"ReLCP": "euler", "ReLCP, midpoint": "midpoint"}


def settings(engine):
    """Each set by name: those of engines.json, and those of this folder, of which some go out from others."""

    def whole(given):
        base = {}
        if "named" in given:
            named = ENGINES[engine]["settings"][given["named"]]
            base = {key: value for key, value in named.items() if not key.startswith("for_")}
        elif "from" in given:
            base = whole(OWN[engine][given["from"]])
        return {**base, **{key: value for key, value in given.items() if key not in ("named", "from")}}

    return {name: whole(given) for name, given in OWN[engine].items()}


def scored(problem, frames):
    """Error and overlap of a run's frames, or that it broke."""
    if not numpy.isfinite(frames).all():
        return {"ended": "numbers that are not finite"}
    error = problem.error(frames[-1])
    return {"error": error, "certain": error >= problems.CERTAINTY * problem.estimate, "overlap": problem.overlap(frames)}


def of_rapier(problem, values, tools, folder):
    """Rows of Rapier, each step's."""
    scenes.write_poses(folder / "poses.f64", problem.start)
    problem.velocity(problem.start[:, :3]).astype("<f8").tofile(folder / "forces.f64")
    for halvings in range(HALVINGS + 1):
        steps = problem.coarsest << halvings
        words = {"version": "0.36", **values, "poses": folder / "poses.f64", "frames": folder / "frames.f64"}
        words.update(forces=folder / "forces.f64", repeats=REPEATS, dt=repr(problem.end / steps), end=problem.end)
        words.update(every=problem.end / problem.coarsest, radius=problem.form["radius"], half=problem.form["half"])
        command = [tools["rapier"], *(f"{key}={value}" for key, value in words.items())]
        said = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        _, frames = scenes.read_frames(folder / "frames.f64", len(problem.start))
        yield {**said, **scored(problem, frames)}


def of_mujoco(problem, values, _tools, folder):
    """Rows of MuJoCo, each step's."""
    uniform = None if problem.forces is None else problem.velocity(None).tolist()
    file = folder / "problem.json"
    file.write_text(json.dumps({
        "form": problem.form, "start": problem.start.tolist(), "end": problem.end, "frames": problem.coarsest,
        "velocity": uniform, "mobility": problem.mobility, "strides": [1 << k for k in range(HALVINGS + 1)],
        "repeats": REPEATS, "repeat_within": REPEAT_WITHIN, "settings": values,
    }))
    command = [sys.executable, HERE / "follow_mujoco.py", file, folder]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder)
    for said in map(json.loads, done.stdout.splitlines()):
        frames = numpy.fromfile(folder / f"{said['steps']}.f64", "<f8").reshape(problem.coarsest, -1, 7)
        yield {**said, **scored(problem, frames)}


def stepped(problem, curve, steps, relcp):
    """A run of relcp: the seconds of each step by the clock, the frames and the version."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "run")
        problem.run(relcp, out, steps, STEPPING[curve], problem.end / problem.coarsest)
        states = [numpy.load(state) for state in sorted((out / "states").glob("*.npz"))[1:]]
        with open(out / "steps.csv", newline="") as read:
            wall = numpy.array([float(step["wall_seconds"]) for step in csv.DictReader(read)])
        version = json.loads((out / "summary.json").read_text())["version"]
        return wall, numpy.array([problems.poses(state) for state in states]), version


def of_relcp(problem, curve, study, walls, relcp):
    """Rows of relcp: error and overlap from the states of a run of its own, seconds from it and from the study. `walls`
    has the least seconds of each step so far."""
    for row in study["rows"]:
        if (row["problem"], row["curve"]) != (problem.name, curve):
            continue
        key = problem.name, curve, row["steps"]
        for _ in range(RUNS):
            wall, states, version = stepped(problem, curve, row["steps"], relcp)
            walls[key] = numpy.minimum(walls.get(key, wall), wall)
        found = scored(problem, states)
        if abs(found["error"] - row["error"]) > ROUNDING * row["error"]:
            raise SystemExit(f"{problem.name}, {curve}: the error is {found['error']} here, {row['error']} in the study")
        seconds = min(row["wall_seconds"], float(walls[key].sum()))
        yield {"steps": row["steps"], "cpu_s": round(seconds, 9), "version": version, "machine": row["machine"], **found}


def studied(relcp, folder):
    """The study, run again on this machine by the program beside relcp."""
    lab = pathlib.Path(relcp).with_name("relcp-lab")
    command = [lab, "work-precision", "--backend", "cpu", "--threads", "1", "--json", "--out", folder / "study"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


class Results:
    """The file of rows."""

    def __init__(self, file):
        self.file = file
        have = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
        self.done = {(row["scene"], row["engine"], row["settings_name"], row["round"]) for row in have}

    def add(self, head, made):
        """Writes the rows of one setting on one scene at once, so that they are all there or none."""
        name = ("scene", "engine", "settings_name", "round")
        stamp = {"date": time.strftime("%Y-%m-%d", time.gmtime()), "load": round(os.getloadavg()[0], 2)}
        rows = [{**head, **row, **stamp} for row in made]
        with open(self.file, "a") as to:
            to.writelines(json.dumps(row) + "\n" for row in rows)
        least = min(rows, key=lambda row: row.get("error", float("inf")))
        print(*(head[key] for key in name), least.get("error"), least["cpu_s"], file=sys.stderr, flush=True)


def main():
    results, tools = Results(pathlib.Path(sys.argv[1])), {"relcp": sys.argv[2], "rapier": sys.argv[3]}
    walls = {}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        of = {name: problems.Problem(name, tools["relcp"], folder) for name in problems.SCENES}
        for round_ in range(1, ROUNDS + 1):
            wanted = [(scene, "relcp", curve, {}) for scene in of for curve in problems.CURVES]
            wanted += [(scene, engine, *item) for engine in OWN for scene in HAVE[engine] for item in settings(engine).items()]
            wanted = [each for each in wanted if (*each[:3], round_) not in results.done]
            study = studied(tools["relcp"], folder) if any(each[1] == "relcp" for each in wanted) else None
            for scene, engine, name, values in wanted:
                head = {"scene": scene, "engine": engine, "settings_name": name, "settings": values, "round": round_}
                if engine == "relcp":
                    made = of_relcp(of[scene], name, study, walls, tools["relcp"])
                else:
                    call = of_rapier if engine.startswith("rapier") else of_mujoco
                    made = call(of[scene], values, tools, folder)
                results.add(head, made)


if __name__ == "__main__":
    main()
