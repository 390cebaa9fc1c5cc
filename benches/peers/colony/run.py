"""relcp's colony of growing rods, from one cell to 1,024, by tolerance and step: `run.py RESULTS RELCP RAPIER`.

No engine here grows and divides rods by itself. The CPU time is that of the whole process. Overlaps are those of the
saved states, found by the checker, and the program's own after every step.
"""

import json
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import checker  # noqa: E402
import numpy  # noqa: E402

CELLS = 1024
# Tolerance and step. The built-in scene has 1e-5 and 0.001; in a step of 0.01 a cell of length 4 grows by 0.04.
RUNS = [(5e-4, 0.01), (1e-5, 0.01), (5e-4, 0.001), (1e-5, 0.001)]


def main():
    file, relcp = pathlib.Path(sys.argv[1]), sys.argv[2]
    have = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    for tolerance, dt in RUNS:
        if any((row["tolerance"], row["dt"]) == (tolerance, dt) for row in have):
            continue
        with tempfile.TemporaryDirectory() as folder:
            keys = [f"contact.overlap_tolerance={tolerance}", f"time.dt={dt}", "time.end=9", "output.every=0.25"]
            keys += [f"growth.stop.population={CELLS}", "output.picture=false"]
            sets = [word for key in keys for word in ("--set", key)]
            command = [relcp, "run", "colony", "--backend", "cpu", "--threads", "1", "--quiet", "--out", folder + "/run"]
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([*command, *sets], check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            out = pathlib.Path(folder, "run")
            summary = json.loads((out / "summary.json").read_text())
            largest = 0.0
            for state in sorted((out / "states").glob("*.npz")):
                read = numpy.load(state)
                radius, length = read["size"][:, 0] / 2, read["size"][:, 1]
                poses = numpy.hstack([read["position"], read["orientation"]])
                if len(poses) > 1:
                    largest = max(largest, checker.largest_of_rods(poses, radius, length / 2 - radius))
            row = {
                "tolerance": tolerance,
                "dt": dt,
                "bodies": summary["bodies"],
                "steps": summary["steps"],
                "cpu_s": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 3),
                "max_overlap": max(largest, summary["max_overlap"]),
                "checked_overlap": largest,
                "version": summary["version"],
                "date": time.strftime("%Y-%m-%d", time.gmtime()),
            }
            with open(file, "a") as to:
                to.write(json.dumps(row) + "\n")
            print(row, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
