"""Tables and plots of `--precision`: errors at the end and the milliseconds of CPU time that they cost."""

import json
import pathlib

import matplotlib.pyplot as plot

ROOT = pathlib.Path(__file__).resolve().parents[3]
REFERENCES = ROOT / "assets/references"
STUDY = ROOT / "docs/studies/work-precision/work-precision.json"
# A reference is good enough for an error of so many times its own estimate: as the study has it.
CERTAINTY = 3
# Errors that are asked for.
WANTED = [1e-2, 1e-3, 1e-4, 1e-5]
# The errors of the summary.
TOLD = [1e-3, 1e-4]
# What is drawn of an error: ends that are this far off say nothing more.
DRAWN = [1e-7, 3.0]
MARKS = ["o", "s", "^", "D", "v", "P", "X", "*"]


def least(rows):
    """Of the rounds of each point the one with the least CPU time; those of a setting from coarse to fine."""
    best = {}
    for row in rows:
        key = row["scene"], row["engine"], row["settings_name"], row["steps"]
        if key not in best or row["cpu_s"] < best[key]["cpu_s"]:
            best[key] = row
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    return sorted(best.values(), key=lambda row: (scenes.index(row["scene"]), row["engine"] != "relcp", row["steps"]))


def settings_of(rows, scene):
    """The points of each program and setting on a scene."""
    of = {}
    for row in (row for row in rows if row["scene"] == scene):
        of.setdefault((row["engine"], row["settings_name"]), []).append(row)
    return of


def off(row):
    return row.get("error", float("inf"))


def within(points, error):
    """The cheapest point from where on all finer ones of the same setting are within the error too."""
    cheapest = None
    for row in reversed(points):
        if off(row) > error:
            break
        if cheapest is None or row["cpu_s"] < cheapest["cpu_s"]:
            cheapest = row
    return cheapest


def number(error, certain=True):
    return f"{'' if certain else '~'}{error:.1e}"


def milliseconds(row):
    return f"{1e3 * row['cpu_s']:.3g}"


def settled(scene, error):
    """Whether an error is so large that the reference's own does not count."""
    estimate = json.loads((REFERENCES / f"{scene}.json").read_text())["estimate"]
    return error >= CERTAINTY * max(estimate.values())


def best_of(points, program, error):
    """The cheapest of a program's points within an error, in any setting."""
    found = [within(some, error) for (engine, _), some in points.items() if engine == program]
    return min(filter(None, found), key=lambda row: row["cpu_s"], default=None)


def cheapest(rows, names, table):
    """Of each scene, error and program the cheapest point."""
    body, programs = [], [name for name in names if any(row["engine"] == name for row in rows)]
    for scene in dict.fromkeys(row["scene"] for row in rows):
        of = settings_of(rows, scene)
        for error in WANTED:
            line = [scene, f"{'' if settled(scene, error) else '~'}{error:.0e}"]
            for program in programs:
                best = best_of(of, program, error)
                if best:
                    line += [milliseconds(best), f"{best['settings_name']}, {best['steps']} steps", number(best["overlap"])]
                else:
                    line += ["-" if any(engine == program for engine, _ in of) else "cannot run it", "", ""]
            body.append(line)
    head = [word for program in programs for word in (f"{names[program]}, ms", "by", "overlap")]
    return table(["scene", "error", *head], body)


def summary(rows, names):
    """What an error costs by each program, in words."""
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        of = settings_of(rows, scene)
        engines = [name for name in names if name != "relcp" and any(engine == name for engine, _ in of)]
        for error in TOLD:
            own = best_of(of, "relcp", error)
            told = []
            for engine in engines:
                best = best_of(of, engine, error)
                times = best and f"{milliseconds(best)} ms, {best['cpu_s'] / own['cpu_s']:.1f} times as much"
                told.append(f"{names[engine]} {times or 'has no run that is so exact'}")
            lines.append(f"* {scene}, an error of {error:.0e}: relcp takes {milliseconds(own)} ms; {'; '.join(told)}.")
    return "\n".join(lines) + "\n"


def least_errors(rows, names, table):
    """Of each scene and setting the most exact point, and what the coarsest step gives."""
    body = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        for (program, name), points in settings_of(rows, scene).items():
            best, first = min(points, key=off), points[0]
            line = [scene, names[program], name]
            for row in (first, best):
                if "error" in row:
                    line += [str(row["steps"]), number(row["error"], row["certain"]), milliseconds(row), number(row["overlap"])]
                else:
                    line += [str(row["steps"]), row["ended"], "", ""]
            body.append(line)
    head = ["steps", "error", "ms", "overlap"]
    return table(["scene", "program", "settings", *head, *head], body)


def unbeaten(rows, names):
    """Runs of engines that are quicker than every run of relcp that is as exact."""
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        here = [row for row in rows if row["scene"] == scene and "error" in row]
        own = [row for row in here if row["engine"] == "relcp"]
        others = [row for row in here if row["engine"] != "relcp"]
        beaten = lambda row: any(a["error"] <= row["error"] and a["cpu_s"] <= row["cpu_s"] for a in own)
        left = sorted((row for row in others if not beaten(row)), key=lambda row: row["cpu_s"])
        quickest, best = min(own, key=lambda row: row["cpu_s"]), min(own, key=off)
        lines.append(
            f"* {scene}: {len(left)} of {len(others)}. relcp's quickest run takes {milliseconds(quickest)} ms, with an error of "
            f"{number(quickest['error'], quickest['certain'])}; its most exact has {number(best['error'], best['certain'])}."
        )
        lines += [
            f"  * {names[row['engine']]}, {row['settings_name']}, {row['steps']} steps: {milliseconds(row)} ms, error "
            f"{number(row['error'], row['certain'])}, overlap {number(row['overlap'])}"
            for row in left
        ]
    return "\n".join(lines) + "\n"


def given(rows, names, table):
    """What each setting is."""
    used = {(row["engine"], row["settings_name"]): row for row in rows if row["engine"] != "relcp"}
    body = [
        [names[program], row["version"], name, ", ".join(f"`{k}={v}`" for k, v in row["settings"].items()) or "nothing"]
        for (program, name), row in used.items()
    ]
    return table(["program", "version", "settings", "given"], body)


def origin(rows, best):
    """Where and when, and how far relcp's times are from those that the study's page has."""
    loads = [row["load"] for row in rows]
    days = " to ".join(dict.fromkeys(f(row["date"] for row in rows) for f in (min, max)))
    machines = sorted({row["machine"] for row in rows if "machine" in row})
    study = {(row["problem"], row["curve"], row["steps"]): row["wall_seconds"] for row in json.loads(STUDY.read_text())["rows"]}
    own = [row for row in best if row["engine"] == "relcp"]
    ratios = [row["cpu_s"] / study[row["scene"], row["settings_name"], row["steps"]] for row in own]
    return (
        f"Measured {days}, {', '.join(machines)}, one thread on one core. Other programs shared the machine: its load was "
        f"{min(loads):.1f} to {max(loads):.1f}. relcp's {len(ratios)} times are {min(ratios):.2f} to {max(ratios):.2f} of those on the "
        "page of the study.\n"
    )


def curves(rows, names, colours):
    """A plot a scene: error against CPU time, relcp's curves and the points of engines."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axes = plot.subplots(1, len(scenes), figsize=(6.5 * len(scenes), 7.5), squeeze=False)
    for scene, axis in zip(scenes, axes[0]):
        marks = {}
        for (program, name), points in settings_of(rows, scene).items():
            mark = marks.setdefault(program, iter(MARKS))
            points = [row for row in points if "error" in row]
            x, y = [1e3 * row["cpu_s"] for row in points], [min(row["error"], DRAWN[1]) for row in points]
            line = {"linestyle": "-" if program == "relcp" else ":", "linewidth": 2 if program == "relcp" else 0.6}
            label = f"{names[program]}, {name}" if program != "relcp" else name
            axis.loglog(x, y, next(mark), color=colours[program], markersize=5, label=label, **line)
        axis.set(title=scene, xlabel="CPU milliseconds of the steps, one core", ylabel="error at the end", ylim=(DRAWN[0], 2 * DRAWN[1]))
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.1), ncol=2)
    figure.tight_layout()
    return figure


def blocks(rows, names, table):
    """The blocks of docs/peers.md."""
    best = least(rows)
    return {
        "precision summary": summary(best, names),
        "precision": cheapest(best, names, table),
        "precision unbeaten": unbeaten(best, names),
        "precision least": least_errors(best, names, table),
        "precision settings": given(best, names, table),
        "precision origin": origin(rows, best),
    }
