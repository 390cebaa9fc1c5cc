"""Tables of relcp beside each engine at the overlap of that engine's own run."""

# Tolerances that relcp is measured at, whatever engines overlap by.
DECADES = ["1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7"]
DEFAULT = "1e-5"
# relcp's time step, and that of scenes in which it is another.
DT = 0.1
OTHER_DT = {"colony-1024": 0.01}
# Where the names of engines stand beside their points, the one with the least overlap first: points lie close.
LABELS = [(-6, -12, "right"), (6, -12, "left"), (-6, 6, "right"), (0, 14, "center"), (6, 4, "left")]
TITLES = {"rods-1000": "1,000 rods", "ellipsoids-1000": "1,000 ellipsoids", "colony-1024": "a colony to 1,024 cells",
          "rods-8000": "8,000 rods"}


# An engine's run whose bodies overlap deeper than this has no twin: a rod's axis is 0.25 below its surface.
DEEPEST = 0.2


def twin_settings(overlap):
    """relcp's settings at an overlap, with solves to half of it: 1,000 rods at 4.7e-3 take 213 products with A a step by
    default, 151 at a quarter of it, 109 at half; the radius of gyration at the end is 3.480, 3.483, 3.486."""
    return {"tolerance": f"{overlap:.2e}", "solver.tolerance": f"{0.5 * overlap:.2e}"}


def dt(scene):
    """relcp's time step."""
    return OTHER_DT.get(scene, DT)


def twin(engine):
    """The name of relcp's settings at the overlap of an engine."""
    return f"as {engine}"


def quickest(rows):
    """Of the rounds of each point the one with the least CPU time."""
    best = {}
    for row in sorted((row for row in rows if "cpu_s" in row), key=lambda row: row["cpu_s"]):
        best.setdefault((row["scene"], row["engine"], row["settings_name"]), row)
    return best


def seconds(value):
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def pairs(rows, scene):
    """Each engine's run and relcp's at its overlap, the engine with the least overlap first."""
    best = quickest(row for row in rows if row["scene"] == scene and row.get("ended") is None)
    found = []
    for (_, engine, _), row in best.items():
        own = best.get((scene, "relcp", twin(engine)))
        if engine != "relcp" and (own or row["max_overlap"] > DEEPEST):
            found.append((row, own))
    return sorted(found, key=lambda pair: pair[0]["max_overlap"])


def against(rows, names, table, scenes):
    """One line an engine and scene: its run, relcp's time at that overlap, and the ratio of the times."""
    body = []
    for scene in scenes:
        for row, own in pairs(rows, scene):
            program = f"{names[row['engine']].split()[0]} {row['version']}"
            cells = [program, f"{row['max_overlap']:.1e}", f"{seconds(row['cpu_s'])} s"]
            beside = [f"{seconds(own['cpu_s'])} s", f"{own['cpu_s'] / row['cpu_s']:.2f}"] if own else ["rods cross", ""]
            body.append([*([TITLES[scene]] if len(scenes) > 1 else []), *cells, *beside])
    head = ["program", "its largest overlap", "its CPU time", "relcp at that overlap", "ratio"]
    return table([*(["scene"] if len(scenes) > 1 else []), *head], body)


def at_default(rows, scene):
    """What relcp takes at its default tolerance, beside the engines' own runs."""
    best = quickest(row for row in rows if row["scene"] == scene and row.get("ended") is None)
    own = best.get((scene, "relcp", DEFAULT))
    engines = [row["cpu_s"] for row, _ in pairs(rows, scene)]
    if own is None or not engines:
        return ""
    quicker = sum(cpu_s < own["cpu_s"] for cpu_s in engines)
    beside = "less than each" if quicker == 0 else f"more than {quicker} of them"
    return f"\nNone holds {DEFAULT}, relcp's default, which takes relcp {seconds(own['cpu_s'])} s: {beside}.\n"


def tolerances(rows, table):
    """relcp's CPU seconds by its tolerance, one line a scene."""
    best = quickest(row for row in rows if row["engine"] == "relcp" and row.get("ended") is None)
    scenes = [scene for scene in TITLES if any((scene, "relcp", name) in best for name in DECADES)]
    cell = lambda scene, name: seconds(best[scene, "relcp", name]["cpu_s"]) if (scene, "relcp", name) in best else ""
    body = [[TITLES[scene], *(cell(scene, name) for name in DECADES)] for scene in scenes]
    return table(["CPU s by tolerance", *DECADES], body)


def blocks(rows, names, table):
    """What pages show."""
    scenes = [scene for scene in TITLES if pairs(rows, scene)]
    days = sorted({row["date"] for row in rows})
    clocks = sorted(row["clock"] for row in rows)
    loads = [row["load"] for row in rows]
    said = f"Measured {' to '.join(dict.fromkeys([days[0], days[-1]]))} from {clocks[0]} to {clocks[-1]} UTC, "
    rounds = max(row["round"] for row in rows)
    said += f"{rows[0]['machine']}, one thread on one core, relcp at a step of {DT:g} (colony {OTHER_DT['colony-1024']:g}), by turns"
    said += f"; the least of {rounds} rounds" if rounds > 1 else ""
    said += f". Load of the machine, which other programs shared: {min(loads):.1f} to {max(loads):.1f}.\n"
    return {
        "short": against(rows, names, table, ["rods-1000"]) + at_default(rows, "rods-1000"),
        "equal": against(rows, names, table, scenes),
        "equal tolerances": tolerances(rows, table),
        "equal origin": said,
    }


def curves(rows, names, colours):
    """relcp's curve over its tolerances beside the point of each engine, one panel a scene."""
    import matplotlib.pyplot as plot

    scenes = [scene for scene in TITLES if pairs(rows, scene)]
    high = (len(scenes) + 1) // 2
    figure, axes = plot.subplots(high, 2, figsize=(9.2, 3.8 * high), squeeze=False)
    for axis in axes.flat[len(scenes) :]:
        axis.remove()
    for scene, axis in zip(scenes, axes.flat):
        best = quickest(row for row in rows if row["scene"] == scene and row.get("ended") is None)
        own = sorted((row["max_overlap"], row["cpu_s"]) for (_, engine, _), row in best.items() if engine == "relcp")
        axis.loglog(*zip(*own), "-o", color=colours["relcp"], markersize=4)
        axis.annotate("relcp", own[len(own) // 2], xytext=(6, 6), textcoords="offset points", color=colours["relcp"])
        for (row, _), (x, y, side) in zip(pairs(rows, scene), LABELS):
            at = row["max_overlap"], row["cpu_s"]
            axis.loglog(*at, "s", color=colours[row["engine"]])
            axis.annotate(names[row["engine"]], at, xytext=(x, y), textcoords="offset points", fontsize=8, ha=side)
        axis.set(title=TITLES[scene], xlabel="largest overlap, a length", ylabel="CPU seconds, one core")
        axis.margins(x=0.25)
        axis.grid(alpha=0.3)
    figure.tight_layout()
    return figure
