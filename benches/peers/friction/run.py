"""Runs the cases with friction by every engine and adds what is missing to a file of JSON lines.

`python run.py OUT.jsonl RELCP RAPIER [case ...]`; `peers/run --friction` calls it.
"""

import json
import math
import os
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from rough import CASES, DT  # noqa: E402
from engines import SETTINGS, Bullet, Mujoco, Physx, Rapier, Relcp  # noqa: E402


def main():
    out, relcp, rapier, *names = sys.argv[1:]
    out = pathlib.Path(out)
    have = [json.loads(line) for line in out.read_text().splitlines()] if out.exists() else []
    done = {(row["case"], row["engine"], row["settings"]) for row in have}
    engines = [Relcp(relcp), Rapier(rapier), Mujoco(), Physx(), Bullet()]
    for name in names or CASES:
        case = CASES[name]
        for engine in engines:
            for label, settings in SETTINGS[engine.name].items():
                if (name, engine.name, label) in done:
                    continue
                row = {"case": name, "engine": engine.name, "settings": label, "dt": DT}
                try:
                    frames, seconds = engine.run(case, DT, settings)
                    row["cpu_s"] = round(seconds, 6)
                    row["found"] = [measure(frames) for *_, measure in case["measures"]]
                    if not all(math.isfinite(value) for value in row["found"]):
                        row.update(found=None, ended="not finite")
                except RuntimeError as fault:
                    row["ended"] = str(fault)
                row.update(date=time.strftime("%Y-%m-%d", time.gmtime()), load=os.getloadavg()[0])
                with open(out, "a") as to:
                    to.write(json.dumps(row) + "\n")
                print(row, flush=True)


if __name__ == "__main__":
    main()
