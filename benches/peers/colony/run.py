"""relcp's colony of growing rods, from one cell to 1,024, by tolerance and step: `run.py RESULTS RELCP RAPIER`.

The CPU time is that of the whole process. Overlaps are those of the
saved states, found by the checker, and the program's own after every step.
"""

import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import colony  # noqa: E402

# Tolerance and step. The built-in scene has 1e-5 and 0.001; in a step of 0.01 a cell of length 4 grows by 0.04.
RUNS = [(5e-4, 0.01), (1e-5, 0.01), (5e-4, 0.001), (1e-5, 0.001)]


def main():
    file, relcp = pathlib.Path(sys.argv[1]), sys.argv[2]
    have = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    for tolerance, dt in RUNS:
        if any((row["tolerance"], row["dt"]) == (tolerance, dt) for row in have):
            continue
        found = colony.of_relcp(relcp, tolerance, dt)
        checked, own = found.pop("max_overlap"), found.pop("own_max_overlap")
        row = {
            "tolerance": tolerance,
            "dt": dt,
            **found,
            "max_overlap": max(checked, own),
            "checked_overlap": checked,
            "date": time.strftime("%Y-%m-%d", time.gmtime()),
        }
        with open(file, "a") as to:
            to.write(json.dumps(row) + "\n")
        print(row, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
