"""The maps of the atlas as a figure, and their counts as a table."""

import math
import re
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.patches as patches  # noqa: E402
import matplotlib.pyplot as plot  # noqa: E402

PROGRAMS = {
    "relcp": "relcp",
    "relcp, f32": "relcp, f32",
    "rapier": "Rapier 0.36",
    "rapier, f64": "Rapier 0.36, f64",
    "mujoco": "MuJoCo 4.0",
}
AXES = {
    "aspect ratio": ("length over thickness", "time step"),
    "ellipsoids": ("length over thickness", "time step"),
    "size ratio": ("thickness over thickness", "time step"),
    "deep overlap": ("overlap at the start over thickness", "time step"),
    "jammed": ("rods", "speed of the outermost"),
    "spinning": ("angular velocity", "time step"),
    "distance": ("distance from the origin", "time step"),
}
# From best to worst: of several settings the best verdict counts. Colours that colour-blind readers tell apart.
VERDICTS = {"holds": "#4477aa", "reported": "#eecc66", "fails": "#bb3344", "slow": "#dddddd", "none": "#ffffff"}


def best(rows):
    """Of each map, cell and program the best settings: by the verdict, then by the overlap."""
    rank = lambda row: (list(VERDICTS).index(row["verdict"]), row.get("overlap") if row.get("overlap") is not None else 1e9)
    found = {}
    for row in rows:
        key = row["map"], row["x"], row["y"], row["program"]
        if key not in found or rank(row) < rank(found[key]):
            found[key] = row
    return found


def counts(rows):
    """Head and body of the table of counts."""
    found, body = best(rows), []
    for name in [*AXES, None]:
        for program in PROGRAMS:
            cells = [row for key, row in found.items() if key[0] in (name or AXES) and key[3] == program]
            cells = cells if name is None else [row for row in cells if row["map"] == name]
            if not cells:
                continue
            many = [str(sum(row["verdict"] == verdict for row in cells)) for verdict in ("holds", "reported", "fails", "slow")]
            held = [row["overlap"] for row in cells if row["verdict"] == "holds" and row["overlap"] is not None]
            body.append([name or "**all**", PROGRAMS[program], str(len(cells)), *many, f"{max(held):.0e}" if held else ""])
    head = ["map", "program", "cells", "holds", "is reported", "fails", "over a minute", "largest overlap that holds"]
    return head, body


def reasons(rows):
    """The cells of relcp that do not hold, with what it says; numbers of bodies and coordinates apart."""
    said = {}
    for key, row in best(rows).items():
        if key[3].startswith("relcp") and row["verdict"] != "holds":
            words = re.sub(r"bodies \d+ and \d+|coordinate,? [\d.e]+", lambda found: found[0].split()[0], row["why"])
            said.setdefault((row["map"], PROGRAMS[row["program"]], row["verdict"], words), []).append(row)
    lines = []
    for (name, program, verdict, words), cells in said.items():
        across = ", ".join(f"{x:g}" for x in sorted({row["x"] for row in cells}))
        upwards = ", ".join(f"{y:g}" for y in sorted({row["y"] for row in cells}))
        line = f"* {name} {across}, {AXES[name][1]} {upwards} ({program}, {len(cells)} cells): {verdict}: \"{words}\""
        lines += textwrap.wrap(line, 150, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines) + "\n" if lines else "None.\n"


def maps(rows):
    """The figure: a row of maps for each program that is in all, and one of the distance for all five."""
    found = best(rows)
    wide = [name for name in AXES if name != "distance"]
    figure = plot.figure(figsize=(3.1 * len(wide), 12.5), layout="constrained")
    grid = figure.add_gridspec(4, 30)
    for i, program in enumerate(("relcp", "rapier", "mujoco")):
        for j, name in enumerate(wide):
            draw(figure.add_subplot(grid[i, 5 * j : 5 * j + 5]), found, name, program, i == 0, j == 0)
    for j, program in enumerate(PROGRAMS):
        draw(figure.add_subplot(grid[3, 6 * j : 6 * j + 6]), found, "distance", program, True, True)
    handles = [patches.Patch(facecolor=colour, edgecolor="#555555", label=name) for name, colour in VERDICTS.items()]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles),
        title="numbers: log10 of the largest overlap over the thickness; -inf: none", frameon=False,
    )
    return figure


def draw(axis, found, name, program, titled, labelled):
    """A map."""
    cells = {(key[1], key[2]): row for key, row in found.items() if key[0] == name and key[3] == program}
    every = [key for key in found if key[0] == name]
    if not every:
        axis.set_axis_off()
        return
    xs, ys = sorted({key[1] for key in every}), sorted({key[2] for key in every})
    for (x, y), row in cells.items():
        at = xs.index(x), ys.index(y)
        axis.add_patch(patches.Rectangle(at, 1, 1, facecolor=VERDICTS[row["verdict"]], edgecolor="white"))
        said = number(row)
        dark = row["verdict"] in ("holds", "fails")
        axis.text(at[0] + 0.5, at[1] + 0.5, said, ha="center", va="center", fontsize=7, color="white" if dark else "black")
    axis.set(xlim=(0, len(xs)), ylim=(0, len(ys)))
    axis.set_xticks([k + 0.5 for k in range(len(xs))], [f"{x:g}".replace("e+", "e") for x in xs], fontsize=7, rotation=45)
    axis.set_yticks([k + 0.5 for k in range(len(ys))], [f"{y:g}" for y in ys], fontsize=7)
    axis.set_xlabel(AXES[name][0], fontsize=8)
    what = f"{name}\n" if titled else ""
    axis.set_title(f"{what}{PROGRAMS[program]}", fontsize=9)
    axis.set_ylabel(AXES[name][1] if labelled or name == "jammed" else "", fontsize=8)
    if not cells:
        axis.text(len(xs) / 2, len(ys) / 2, "has no such shape", ha="center", fontsize=8)


def number(row):
    """The exponent of the overlap over the thickness, to a tenth."""
    overlap = row.get("overlap")
    if row["verdict"] in ("none", "slow") or not row.get("frames") or overlap is None:
        return ""
    return "-inf" if overlap <= 0 else f"{math.log10(overlap):.1f}"
