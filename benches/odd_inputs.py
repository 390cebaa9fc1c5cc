"""Odd values in the keys of the built-in scenes: what `relcp check` says, and what 40 steps of those it accepts do.

    python3 benches/odd_inputs.py target/release/relcp 200 --seed 1 [--refused]

Draws keys and values until so many scenes are accepted (with --refused: until so many are tried) and prints a line for
each: status, largest overlap, largest move, warnings, message. docs/notes/odd-inputs.md has what was found.
"""
import argparse
import copy
import json
import math
import pathlib
import random
import subprocess
import tempfile

VALUES = [None, True, "x", "", -1, 0, 1e-320, 1e308, -1e308, 0.5, 1e18, 1e-9, 3, [], {}, [1], [0, 0, 0], [1e200, 0, 0],
          "nan", {"x": 1}, 12345678901234567890123, 2**53 + 1]
STEPS = 40
SECONDS = 60


def paths(value, path=()):
    """The paths of all keys, and of the first two entries of each list."""
    if path:
        yield path
    entries = value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    for key, inner in entries:
        yield from paths(inner, path + (key,))


def put(scene, path, value):
    scene = copy.deepcopy(scene)
    inner = scene
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return scene


def is_finite(value):
    if isinstance(value, dict):
        return all(map(is_finite, value.values()))
    if isinstance(value, list):
        return all(map(is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def shortened(scene):
    """Ends the scene after some steps."""
    try:
        time = scene["time"]
        start, dt = float(time.get("start") or 0), float(time["dt"])
        if (float(time["end"]) - start) / dt > STEPS:
            return ["--set", f"time.end={start + STEPS * dt!r}"]
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        pass
    return []


def run(program, file, out, scene):
    command = [program, "run", file, "--out", out, "--threads", "1", *shortened(scene)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return "[not done in a minute]"
    try:
        summary, final = (json.loads((pathlib.Path(out) / name).read_text()) for name in ("summary.json", "final.json"))
    except (OSError, ValueError):
        return f"[run {done.returncode}] {' '.join(done.stderr.split())}"
    wrong = "" if is_finite(final) else " NOT FINITE"
    keys = ("max_overlap", "largest_move", "warnings", "message")
    return f"[run {done.returncode}{wrong}] " + ", ".join(f"{key} {summary.get(key)}" for key in keys)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("number", type=int)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--refused", action="store_true", help="show and count refused scenes too")
    given = arguments.parse_args()
    listed = subprocess.run([given.program, "scenes"], capture_output=True, text=True, check=True).stdout
    cases = []
    for name in [line.split()[0] for line in listed.splitlines() if line and not line[0].isspace()]:
        text = subprocess.run([given.program, "scenes", name], capture_output=True, text=True, check=True).stdout
        scene = json.loads(text)
        cases += [(name, path, value, scene) for path in paths(scene) for value in VALUES]
    random.Random(given.seed).shuffle(cases)
    shown = 0
    for name, path, value, scene in cases:
        if shown == given.number:
            break
        with tempfile.TemporaryDirectory() as place:
            scene, file = put(scene, path, value), f"{place}/scene.json"
            pathlib.Path(file).write_text(json.dumps(scene))
            check = subprocess.run([given.program, "check", file], capture_output=True, text=True)
            if check.returncode == 0:
                outcome = run(given.program, file, f"{place}/out", scene)
            elif given.refused or "panicked" in check.stderr:
                outcome = f"[refused {check.returncode}] {' '.join(check.stderr.split())[:200]}"
            else:
                continue
            shown += 1
            print(f"{name} {'.'.join(map(str, path))} = {json.dumps(value)}: {outcome}", flush=True)


if __name__ == "__main__":
    main()
