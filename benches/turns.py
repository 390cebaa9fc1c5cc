"""Two programs on the same scenes by turns, one thread on one core: processor time, products with A, recursions, and
nanoseconds a constraint and product. Prints a Markdown table, a line as soon as it is measured.

    turns.py BEFORE NOW FOLDER [--scenes NAME,...] [--rounds 1] [--core N]

BEFORE and NOW are programs of relcp, FOLDER is made for their runs. Needs Python's own library. Of the rounds the least
time counts. "Same" says whether the last states of both have the same bits.
"""
import argparse
import csv
import json
import os
import resource
import shutil
import subprocess

ROD = {"spherocylinder": {"diameter": 0.5, "length": 1.5}}


def packed(count, dt, tolerance, end):
    """Rods drawn into a ball, as in the comparison with other engines, from random places."""
    return {
        "name": "packed",
        "seed": 1,
        "dynamics": {"overdamped": {"drag": 1 / 1.5}},
        "time": {"dt": dt, "end": end},
        "contact": {"overlap_tolerance": tolerance},
        "forces": [{"radial_inward": {}}],
        "generate": [{"isotropic": {"count": count, "shape": ROD, "volume_fraction": 0.05}}],
        "output": {"every": 1, "picture": False},
    }


def sets(name, *keys):
    return [name, *(part for key in keys for part in ("--set", key))]


def colony(cells):
    return sets("colony", "time.dt=0.01", "time.end=20", "output.every=1", f"growth.stop.population={cells}")


SCENES = {
    "1,000 rods, dt 0.1, 1e-5": packed(1000, 0.1, 1e-5, 15),
    "1,000 rods, dt 0.1, 5e-3": packed(1000, 0.1, 5e-3, 15),
    "1,000 rods, dt 0.02, 1e-5": packed(1000, 0.02, 1e-5, 12),
    "1,000 rods, dt 0.02, 5e-3": packed(1000, 0.02, 5e-3, 12),
    "8,000 rods, dt 0.1, 1e-5": packed(8000, 0.1, 1e-5, 25),
    "compaction": sets("compaction"),
    "colony to 1,024 cells": colony(1024),
    "colony to 4,096 cells": colony(4096),
    "colony to 16,384 cells": colony(16384),
    "mother-machine": sets("mother-machine"),
    "two-strains": sets("two-strains"),
    "chainmail": sets("chainmail"),
    "sedimentation": sets("sedimentation"),
    "pile": sets("pile"),
}


def run(program, scene, folder, core):
    """A run's processor time, its summary and its steps."""
    shutil.rmtree(folder, ignore_errors=True)
    source = scene
    if isinstance(scene, dict):
        file = folder + ".json"
        with open(file, "w") as to:
            json.dump(scene, to)
        source = [file]
    pin = (lambda: os.sched_setaffinity(0, {core})) if hasattr(os, "sched_setaffinity") else None
    command = [program, "run", *source, "--backend", "cpu", "--threads", "1", "--quiet", "--out", folder]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, preexec_fn=pin, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    with open(folder + "/summary.json") as of, open(folder + "/steps.csv") as steps:
        summary = json.load(of)
        rows = list(csv.DictReader(steps))
    work = sum(float(row["products"]) * float(row["constraints"]) for row in rows)
    return {
        "seconds": seconds,
        "steps": summary["steps"],
        "products": summary["solver"]["products"] / summary["steps"],
        "recursions": summary["recursions"]["mean"],
        "ns": 1e9 * summary["wall_seconds"]["solve"] / work if work else float("nan"),
        "overlap": summary["max_overlap"],
        "status": summary["status"],
        "hash": summary["state_hash"],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("now")
    parser.add_argument("folder")
    parser.add_argument("--scenes", help="only these, by semicolons")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)))
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    print("| scene | steps | seconds before, now | ratio | products a step | recursions a step | ns a constraint and product "
          "| largest overlap | same |")
    print("| --- | ---: | --- | ---: | --- | --- | --- | --- | --- |")
    for name in given.scenes.split(";") if given.scenes else SCENES:
        best = [None, None]
        for _ in range(given.rounds):
            for k, program in enumerate((given.before, given.now)):
                found = run(program, SCENES[name], os.path.join(given.folder, f"run-{k}"), given.core)
                if best[k] is None or found["seconds"] < best[k]["seconds"]:
                    best[k] = found
        old, new = best
        pair = lambda key, form: f"{old[key]:{form}}, {new[key]:{form}}"
        same = "yes" if old["hash"] == new["hash"] else "no"
        ended = "" if old["status"] == new["status"] == "done" else f" ({old['status']}, {new['status']})"
        print(f"| {name}{ended} | {new['steps']} | {pair('seconds', '.2f')} | {new['seconds'] / old['seconds']:.2f} | "
              f"{pair('products', '.1f')} | {pair('recursions', '.2f')} | {pair('ns', '.1f')} | {pair('overlap', '.2e')} | {same} |",
              flush=True)


if __name__ == "__main__":
    main()
