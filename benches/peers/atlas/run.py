"""The atlas of numerical stability: `run.py RESULTS RELCP RAPIER [MAP ...]` adds to RESULTS what is not in it yet.

The verdict on a cell, from the frames alone and by the checker of this folder:

* holds: every frame is finite and overlaps by no more than the bound, relcp by its tolerance (1e-5, two hundred-thousandths
  of the thickness), engines by a hundredth of the thickness. Of scenes that overlap at the start the last frame counts.
* reported: not so, and the program says it: relcp by its exit status, MuJoCo by its warnings. What relcp kept until then
  must hold.
* fails: neither, or the trap's bodies end three times as far out as they lie when they are clear of each other.
* slow: not done in a minute of CPU time. It is no verdict.
"""

import json
import pathlib
import sys
import tempfile
import time

import cases
import programs

# Of the thickness: what an engine may overlap by.
ENGINES_WITHIN = 1e-2
# The checker and a program may differ by so many roundings of the largest coordinate.
ROUNDINGS = 64
# Bodies that a trap draws in are thrown where they end so many times as far out as they lie when clear of each other.
THROWN = 3
EPSILON = {"relcp, f32": 2.0**-23}


def verdict(case, program, frames, ended):
    """The verdict, the largest overlap over the thickness and what speaks against it."""
    if frames is None:
        return {"verdict": "none", "why": ended["words"]}
    overlaps = [case.overlap(poses) for _, poses in frames]
    counted = overlaps[-1:] if case.overlapping else overlaps
    largest = max(counted, default=0.0)
    ours = program.startswith("relcp")
    reach = case.distance + case.lengths.max()
    bound = programs.TOLERANCE if ours else ENGINES_WITHIN * case.thickness
    bound += ROUNDINGS * reach * EPSILON.get(program, 2.0**-52)
    found = {"overlap": None if largest == float("inf") else largest / case.thickness, "frames": len(frames)}
    if ended["end"] == "slow":
        return {**found, "verdict": "slow", "why": ended["words"]}
    if ended["end"] == "crashed":
        return {**found, "verdict": "fails", "why": ended["words"]}
    over = f"overlaps by {largest:.1e}, over {bound:.1e}"
    if ended["end"] == "reported":
        # What was written before the report: of an engine that warns and goes on, all may be wrong.
        kept = not ours or case.overlapping or largest <= bound
        return {**found, "verdict": "reported" if kept else "fails", "why": ended["words"] if kept else over}
    if not frames:
        return {**found, "verdict": "fails", "why": "no frame"}
    if largest > bound:
        return {**found, "verdict": "fails", "why": over}
    if case.thrown(frames[-1][1]) > THROWN:
        return {**found, "verdict": "fails", "why": f"bodies are thrown out, {case.thrown(frames[-1][1]):.0f} times"}
    if ours and ended["own"] + ROUNDINGS * reach * EPSILON.get(program, 2.0**-52) < largest:
        return {**found, "verdict": "fails", "why": f"says {ended['own']:.1e}, overlaps by {largest:.1e}"}
    return {**found, "verdict": "holds"}


def main():
    file, relcp, rapier, *wanted = sys.argv[1:]
    file = pathlib.Path(file)
    have = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    key = lambda row: (row["map"], row["x"], row["y"], row["program"], row["settings"])
    done = {key(row) for row in have}
    tools = {"relcp": relcp, "rapier": rapier, "python": sys.executable}
    for case in cases.all_cases():
        if wanted and case.map not in wanted:
            continue
        for program, (call, settings, maps) in programs.PROGRAMS.items():
            if (maps and case.map not in maps) or (case.only and program not in case.only):
                continue
            for name, values in settings.items():
                row = {"map": case.map, "x": case.x, "y": case.y, "program": program, "settings": name}
                if key(row) in done:
                    continue
                since = time.monotonic()
                with tempfile.TemporaryDirectory() as folder:
                    row.update(verdict(case, program, *call(case, tools, pathlib.Path(folder), values)))
                row.update(date=time.strftime("%Y-%m-%d", time.gmtime()), wall_s=round(time.monotonic() - since, 2))
                with open(file, "a") as to:
                    to.write(json.dumps(row) + "\n")
                print(*row.values(), file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
