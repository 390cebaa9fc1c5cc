"""Makes the tables and plots from the files of JSON lines: `report.py FOLDER [PAGE ...]`.

Writes `tables.md` and the plots into the folder, and fills the blocks `<!-- peers: NAME -->` to `<!-- peers: end -->` of
the pages. What is in them is made here alone.
"""

import json
import pathlib
import re
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plot  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

sys.path[:0] = [str(HERE / name) for name in ("atlas", "decades", "equal", "precision", "friction")]

import at_equal as equal  # noqa: E402
import draw as atlas  # noqa: E402
import page as precision  # noqa: E402
import result as friction  # noqa: E402
import table as decades  # noqa: E402
from scenes_table import SCENES  # noqa: E402

ENGINES = json.loads((HERE / "engines.json").read_text())
# A run whose bodies end elsewhere than those of the tightest run of relcp is another problem: it is listed, and beats
# nobody. Runs of relcp at three steps differ by 0.2 %.
GYRATION_WITHIN = 0.01
# What pages may show, measured or not.
BLOCKS = [
    *["origin", "best", "short", "rods-1000", "rods-1000 faster", "rods-8000", "ellipsoids-1000", "ellipsoids-1000 faster"],
    *["tuning", "settings", "colony", "lcp warm", "lcp cold", "atlas", "atlas relcp", "decades"],
    *["precision", "precision summary", "precision unbeaten", "precision least", "precision settings", "precision origin"],
    *["friction", "friction cases", "equal", "equal tolerances", "equal origin"],
]
NOT_MEASURED = "Not measured yet.\n"
COLOURS = {name: f"C{index}" for index, name in enumerate(ENGINES)}


def read(folder, name):
    file = folder / f"{name}.jsonl"
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def table(head, body):
    """Of Markdown; columns of numbers to the right."""
    right = [all(re.fullmatch(r"[-+\d.e%, ()]*", row[k]) for row in body) for k in range(len(head))]
    lines = [head, ["---:" if r else "---" for r in right], *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def least(rows):
    """Of the rounds of each point the one with the least CPU time."""
    best = {}
    for row in rows:
        key = row["scene"], row["dt"], row["engine"], row["settings_name"]
        if key not in best or row.get("cpu_s", 1e99) < best[key].get("cpu_s", 1e99):
            best[key] = row
    return list(best.values())


def name(row):
    return ENGINES[row["engine"]]["name"]


def whole(row):
    return row.get("ended") is None and row.get("max_overlap") is not None


def reference(rows, scene):
    """The radius of gyration of relcp's run with the smallest step and the tightest tolerance."""
    own = [row for row in rows if (row["scene"], row["engine"]) == (scene, "relcp") and whole(row)]
    own = [row for row in own if row["settings"].get("tolerance", "1e-5") == "1e-5"]
    return min(own, key=lambda row: row["dt"])["gyration"] if own else None


def astray(row, gyration):
    return gyration is not None and abs(row["gyration"] / gyration - 1) > GYRATION_WITHIN


def seconds(row):
    return f"{row['cpu_s']:.1f}" if row["cpu_s"] >= 10 else f"{row['cpu_s']:.2f}"


def packing_table(rows, scene):
    rows = [row for row in rows if row["scene"] == scene]
    gyration = reference(rows, scene)
    order = lambda row: (-row["dt"], list(ENGINES).index(row["engine"]), row["settings_name"])
    body = []
    for row in sorted(rows, key=order):
        head = [name(row), row["settings_name"], f"{row['dt']:g}"]
        if not whole(row):
            body.append([*head, "", "", "", row.get("ended") or "numbers that are not finite"])
            continue
        note = "ends elsewhere" if astray(row, gyration) else ""
        step = f"{1e3 * row['cpu_s'] / row['steps']:.1f}"
        body.append([*head, seconds(row), step, f"{row['max_overlap']:.1e}", f"{row['gyration']:.3f} {note}".strip()])
    return table(["program", "settings", "dt", "CPU s", "CPU ms a step", "largest overlap", "radius of gyration"], body)


def settings_table(rows):
    used = {(row["engine"], row["settings_name"]): row for row in rows}
    body = []
    for (engine, key), row in sorted(used.items(), key=lambda item: list(ENGINES).index(item[0][0])):
        given = ", ".join(f"`{k}={v}`" for k, v in row["settings"].items()) or "nothing"
        body.append([ENGINES[engine]["name"], row.get("version", ""), key, given])
    return table(["program", "version", "settings", "given"], body)


def looser(rows):
    """Of relcp's runs at looser tolerances than the default the quickest of each, the loosest first."""
    best = {}
    for row in sorted(rows, key=lambda row: row["cpu_s"]):
        if row["engine"] == "relcp" and set(row["settings"]) == {"tolerance"}:
            best.setdefault(float(row["settings"]["tolerance"]), row)
    return [best[tolerance] for tolerance in sorted(best, reverse=True)]


def best_table(rows, scene="rods-1000"):
    """Of each program the run with the least overlap at each step; relcp's at its default tolerance."""
    rows = [row for row in rows if row["scene"] == scene and whole(row)]
    gyration = reference(rows, scene)
    best = {}
    for row in rows:
        key = row["engine"], row["dt"]
        if "tolerance" in row["settings"] or astray(row, gyration):
            continue
        if key not in best or row["max_overlap"] < best[key]["max_overlap"] and row["engine"] != "relcp":
            best[key] = row
    order = lambda row: (row["engine"] != "relcp", row["max_overlap"])
    body = [
        [f"{name(row).split()[0]} {row['version']}", f"{row['dt']:g}", f"{row['cpu_s']:.1f} s", f"{row['max_overlap']:.1e}"]
        for row in sorted(best.values(), key=order)
    ]
    head = ["program", "time step", "CPU time, one core", "largest overlap"]
    return table(head, body) if body else NOT_MEASURED


def faster(rows, scene):
    """Runs of engines with an overlap under a hundredth that cost less than relcp: first at equal overlap, which is
    relcp at looser tolerances, then at its default tolerance and a step of 0.1."""
    rows = [row for row in rows if row["scene"] == scene and whole(row)]
    own = [r for r in rows if r["engine"] == "relcp" and r["dt"] == 0.1 and r["settings_name"] == "1e-5"]
    if not own:
        return "relcp is not measured at a step of 0.1.\n"
    own, gyration = own[0], reference(rows, scene)
    fair = [r for r in rows if r["engine"] != "relcp" and r["max_overlap"] < 1e-2 and not astray(r, gyration)]
    beat = [row for row in fair if row["cpu_s"] < own["cpu_s"]]
    told = lambda r: f"{name(r)} ({r['settings_name']}) at dt {r['dt']:g}: {seconds(r)} s, {r['max_overlap']:.1e}"
    said = ""
    for row in looser([row for row in rows if not astray(row, gyration)]):
        said += f"At a tolerance of {row['settings']['tolerance']}, relcp at dt {row['dt']:g} takes {seconds(row)} s of CPU "
        said += f"time and overlaps by {row['max_overlap']:.1e} at most"
        if fair:
            less = sum(other["cpu_s"] < row["cpu_s"] for other in fair)
            said += f". Of {len(fair)} runs of engines whose overlap stays under 1e-2, {less or 'none'} take"
            said += f"{'s' if less < 2 else ''} less; the quickest of them is {told(min(fair, key=lambda r: r['cpu_s']))}"
        said += ".\n\n"
    said += f"At its default tolerance, 1e-5, relcp at dt 0.1 takes {seconds(own)} s and overlaps by "
    said += f"{own['max_overlap']:.1e} at most. "
    if not fair:
        return said + "No run of an engine keeps its overlap under 1e-2.\n"
    said += f"Of the {len(fair)} runs of engines, {len(beat)} take less"
    listed = [told(row) for row in beat]
    return said + (":\n\n" + "\n".join(f"* {line}" for line in listed) if listed else ".") + "\n"


def origin(rows):
    dates = sorted({row["date"] for row in rows})
    machines = sorted({row["machine"] for row in rows if "machine" in row})
    loads = [row["load"] for row in rows if "load" in row]
    days = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
    words = f"Measured {days}, {', '.join(machines)}, one thread on one core."
    if loads:
        words += f" Other programs shared the machine: its load was {min(loads):.1f} to {max(loads):.1f}."
    return words + "\n"


def tuning_table(rows):
    """Of each engine and step what no other setting beats in both time and overlap."""
    body = []
    for engine in ENGINES:
        for dt in (0.1, 0.02):
            found = [row for row in rows if (row["engine"], row["dt"]) == (engine, dt)]
            gyration = reference(rows, "rods-216")
            fair = [row for row in found if whole(row) and not astray(row, gyration)]
            smallest = float("inf")
            for row in sorted(fair, key=lambda row: row["cpu_s"]):
                if row["max_overlap"] < smallest:
                    smallest = row["max_overlap"]
                    body.append([ENGINES[engine]["name"], f"{dt:g}", str(len(found)), row["settings_name"],
                                 seconds(row), f"{smallest:.1e}"])
    return table(["program", "dt", "settings tried", "not beaten", "CPU s", "largest overlap"], body)


def packing_plot(rows, folder):
    scenes = [scene for scene in SCENES if any(row["scene"] == scene for row in rows)]
    if not scenes:
        return
    figure, axes = plot.subplots(1, len(scenes), figsize=(6.5 * len(scenes), 5), squeeze=False)
    marks = {0.1: "o", 0.02: "s", 0.005: "^"}
    for scene, axis in zip(scenes, axes[0]):
        gyration = reference(rows, scene)
        for row in (row for row in rows if row["scene"] == scene and whole(row)):
            hollow = astray(row, gyration)
            axis.loglog(
                row["cpu_s"], max(row["max_overlap"], 1e-6), marks[row["dt"]], color=COLOURS[row["engine"]],
                fillstyle="none" if hollow else "full", label=name(row),
            )
        axis.set(title=scene, xlabel="CPU seconds, one core", ylabel="largest overlap ever, a length")
        axis.grid(alpha=0.3)
        handles = dict(zip(*reversed(axis.get_legend_handles_labels())))
        axis.legend(handles.values(), handles.keys(), title="o 0.1, square 0.02, triangle 0.005;\nhollow: ends elsewhere")
    figure.tight_layout()
    save(figure, folder / "overlap.svg")


def save(figure, file):
    """Without a date or random names, so that the same rows give the same file."""
    plot.rcParams["svg.hashsalt"] = "peers"
    figure.savefig(file, metadata={"Date": None})
    plot.close(figure)


def lcp_rows(rows):
    """The fastest form of each code, from each start; a code that takes no start has its cold time for both."""
    best = {}
    for row in rows:
        key = row["lcp"], row["code"], row["start"]
        if "cpu_s" in row and (key not in best or row["cpu_s"] < best[key]["cpu_s"]):
            best[key] = row
    return best


def lcp_table(rows, start):
    best = lcp_rows(rows)
    codes = sorted(dict.fromkeys(row["code"] for row in rows), key=lambda code: code != "relcp auto")
    tried = {system: {row["code"] for row in rows if row["lcp"] == system} for system in (row["lcp"] for row in rows)}
    # A system counts when every code was tried on it.
    systems = [system for system in tried if tried[system] == set(codes)]
    head, body = ["LCP", "rows", *codes, "fastest"], []
    sizes = {row["lcp"]: row["rows"] for row in rows if "rows" in row}
    for system in systems:
        cells, times = [], {}
        for code in codes:
            warm = best.get((system, code, start))
            cold = best.get((system, code, "cold"))
            found = min((row for row in (warm, cold) if row), key=lambda row: row["cpu_s"], default=None)
            if found:
                times[code] = found["cpu_s"]
            cells.append(f"{1e3 * found['cpu_s']:.2f}" if found else "-")
        body.append([system, str(sizes.get(system, "")), *cells, min(times, key=times.get) if times else "-"])
    won = sum(row[-1] == "relcp auto" for row in body)
    lost = [f"{row[0]} ({row[-1]})" for row in body if row[-1] != "relcp auto"]
    said = f"relcp's `auto` is the fastest on {won} of {len(body)} systems"
    return table(head, body) + f"\n{said}" + (f"; not on {', '.join(lost)}.\n" if lost else ".\n")


def colony_table(rows):
    body = [[f"{r['tolerance']:g}", f"{r['dt']:g}", str(r["bodies"]), str(r["steps"]), f"{r['cpu_s']:.1f}", f"{r['max_overlap']:.1e}"]
            for r in rows]
    return table(["overlap tolerance", "dt", "cells", "steps", "CPU s", "largest overlap"], body)


def blocks(folder):
    packing = least(read(folder, "packing"))
    made = {}
    if packing:
        made["origin"] = origin(packing)
        made["best"] = best_table(packing)
        made["settings"] = settings_table(packing)
        for scene in dict.fromkeys(row["scene"] for row in packing):
            made[scene] = packing_table(packing, scene)
            made[f"{scene} faster"] = faster(packing, scene)
    for key, rows, of in [
        ("tuning", least(read(folder, "tuning")), tuning_table),
        ("lcp cold", read(folder, "lcp"), lambda rows: lcp_table(rows, "cold")),
        ("lcp warm", read(folder, "lcp"), lambda rows: lcp_table(rows, "warm")),
        ("colony", read(folder, "colony"), colony_table),
        ("atlas", read(folder, "atlas"), lambda rows: table(*atlas.counts(rows))),
        ("decades", read(folder, "decades"), lambda rows: decades.tables(rows, table)),
        ("atlas relcp", read(folder, "atlas"), atlas.reasons),
    ]:
        if rows:
            made[key] = of(rows)
    packing_plot(packing, folder)
    if read(folder, "atlas"):
        save(atlas.maps(read(folder, "atlas")), folder / "atlas.svg")
    if ends := read(folder, "precision"):
        names = {key: engine["name"] for key, engine in ENGINES.items()}
        made.update(precision.blocks(ends, names, table))
        save(precision.curves(precision.least(ends), names, COLOURS), folder / "precision.svg")
    if turns := read(folder, "equal"):
        names = {key: engine["name"] for key, engine in ENGINES.items()}
        made.update(equal.blocks(turns, names, table))
        if any(row["engine"] != "relcp" for row in turns):
            save(equal.curves(turns, names, COLOURS), folder / "equal.svg")
    if rough := read(folder, "friction"):
        made.update(friction.blocks(rough, table))
    return {**{key: NOT_MEASURED for key in BLOCKS}, **made}


def fill(page, made):
    """Puts each block into its place in a page."""

    def block(found):
        if found[1] not in made:
            raise SystemExit(f"{page}: there is no table {found[1]}")
        return f"<!-- peers: {found[1]} -->\n\n{made[found[1]]}\n<!-- peers: end -->"

    text = re.sub(r"<!-- peers: (?!end)(.*?) -->.*?<!-- peers: end -->", block, page.read_text(), flags=re.S)
    page.write_text(text)


def main():
    folder, *pages = map(pathlib.Path, sys.argv[1:])
    made = blocks(folder)
    if not pages:
        # Of a run of its own, such as `--quick`: only what it has.
        made = {key: text for key, text in made.items() if text != NOT_MEASURED}
    titles = "".join(f"## {key}\n\n{text}\n" for key, text in made.items())
    (folder / "tables.md").write_text(f"# Tables\n\nMade by `benches/peers/run`.\n\n{titles}".rstrip() + "\n")
    for page in pages:
        fill(page, made)


if __name__ == "__main__":
    main()
