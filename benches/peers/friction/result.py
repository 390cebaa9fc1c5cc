"""The table of `run.py`'s results: what each engine is off by."""

from rough import CASES

# Below this an angle or a length is rounding.
ROUNDING = 1e-12


def blocks(rows, table):
    """`friction`: how far each engine is off, `friction cases`: what was run."""
    found = {(row["engine"], row["settings"], row["case"]): row for row in rows}
    columns = [(name, k, measure) for name, case in CASES.items() for k, measure in enumerate(case["measures"])]
    head = ["program", "settings", *(f"{name}: {measure[0]}" for name, _, measure in columns), "heap: CPU s"]
    body = []
    for engine, settings in dict.fromkeys((row["engine"], row["settings"]) for row in rows):
        cells = [cell(found.get((engine, settings, name)), k, measure[1]) for name, k, measure in columns]
        heap = found.get((engine, settings, "heap"), {})
        cells.append(f"{heap['cpu_s']:.1f}" if "cpu_s" in heap else "-")
        body.append([engine, settings, *cells])
    cases = [
        [name, case["about"], ", ".join(f"{what} {right:.7g}" for what, right, *_ in case["measures"])]
        for name, case in CASES.items()
    ]
    days = sorted({row["date"] for row in rows})
    days = days[0] if len(days) == 1 else f"{days[0]} to {days[-1]}"
    said = f"\nWhat each program is off by. Measured {days}, one thread, steps of 0.01, beside other programs.\n"
    return {"friction": table(head, body) + said, "friction cases": table(["case", "scene", "right value"], cases)}


def cell(row, k, right):
    if row is None:
        return "-"
    if row.get("found") is None:
        return "fails"
    off = abs(row["found"][k] - right)
    return "0" if off < ROUNDING else f"{off:.1e}"
