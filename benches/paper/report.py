"""Fills the tables of a page from the runs of `benches/paper/run`: `report.py RESULTS PAGE`."""

import json
import pathlib
import re
import statistics
import sys

# The paper's Table 3: rows over ReLCP's and microseconds a row, mean and standard deviation; Table 2 by the step: rows at
# the end and time over ReLCP's.
TABLE_3 = {"ms-27": (252.0, 15.3), "ms-17": (101.0, 20.6), "ms-7": (17.0, 45.9), "ms-5": (8.77, 82.2), "relcp": (1.0, 341.0)}
TABLE_2 = {
    0.1: {"ms-23": (3.5e6, 642), "ms-17": (1.8e6, 402), "ms-13": (1.0e6, 174), "ms-7": (2.8e5, 28), "ms-3": (5.9e4, 1.9), "relcp": (2.9e4, 1.0)},
    0.01: {"ms-23": (3.0e6, 215), "ms-17": (1.7e6, 67), "ms-13": (9.9e5, 39), "ms-7": (2.7e5, 7), "ms-3": (5.8e4, 0.8), "relcp": (2.9e4, 1.0)},
}
NAMES = {"relcp": "ReLCP, one row a pair", "relcp-auto": "ReLCP, default rows"}
FAR = 0.2
# Why a line may differ from the paper's by more than a fifth.
REASONS = {
    "time": "Times a row are of one thread, this solver and this machine; the paper's are of 64 threads, another solver and larger colonies.",
    "rows": "The ratio grows with the colony, and this run is smaller than the paper's.",
    "default": "The default makes a row for each place in which two rods can touch, and none beyond a tenth of a thickness; the paper makes one a pair.",
    "half": "Ellipsoids have one row a pair in either setting; the default makes rows within half the distance.",
    "short": "The ball is not packed yet: the run goes on.",
}


def named(method):
    return NAMES.get(method, f"LCP-MS {method[3:]}" if method.startswith("ms-") else method)


def sentences(said):
    """A line for each reason, with the methods that it is for."""
    return "".join(f"* {', '.join(names)}: {reason}\n" for reason, names in said.items())


def read(results):
    """Head and windows of each run, by scene, step and method."""
    runs = {}
    # ReLCP first, then by the number of sub-spheres.
    order = lambda file: (int("".join(re.findall(r"ms-(\d+)", file.stem)) or 0), file.stem)
    for file in sorted(results.glob("*.jsonl"), key=order):
        head, *windows = map(json.loads, file.read_text().splitlines())
        runs[head["scene"], head["dt"], head["method"]] = head, windows
    return runs


def table(head, body):
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def spread(values):
    if not values:
        return ""
    return f"{statistics.mean(values):.3g} ± {statistics.pstdev(values):.2g}"


def over(found, paper):
    return "" if not paper or found is None else f"{found / paper:.2f}"


def costs(windows, length):
    """Microseconds of CPU time a row in each window that has rows."""
    found, before = [], 0.0
    for window in windows:
        if window["cpu_s"] is None:
            break
        if window["rows"] > 0:
            found.append(1e6 * (window["cpu_s"] - before) / length / window["rows"])
        before = window["cpu_s"]
    return found


def colony(runs):
    """Table 3."""
    own = runs.get(("colony", 0.001, "relcp"))
    if own is None:
        return "Not measured yet.\n"
    base = {window["step"]: window for window in own[1]}
    body, said = [], {}
    for (scene, _, method), (head, windows) in runs.items():
        if scene != "colony":
            continue
        pairs = [(w["rows"], base[w["step"]]["rows"]) for w in windows if w["step"] in base and base[w["step"]]["rows"] > 0]
        ratios = [a / b for a, b in pairs]
        micro = costs(windows, head["length"])
        paper = TABLE_3.get(method, (None, None))
        ratio = statistics.mean(ratios) if ratios else None
        cost = statistics.mean(micro) if micro else None
        seconds = [w["cpu_s"] for w in windows if w["cpu_s"] is not None]
        body.append([
            named(method), str(head["bodies"]), spread(ratios), f"{paper[0]:g}" if paper[0] else "", over(ratio, paper[0]),
            spread(micro), f"{paper[1]:g}" if paper[1] else "", over(cost, paper[1]), f"{max(seconds, default=0):.0f}",
            f"{max((w['max_overlap'] for w in windows), default=0):.1e}",
        ])
        if paper[0] and ratio and abs(ratio / paper[0] - 1) > FAR:
            said.setdefault(REASONS["rows"], []).append(named(method))
        if paper[1] and cost and abs(cost / paper[1] - 1) > FAR:
            said.setdefault(REASONS["time"], []).append(named(method))
        if method == "relcp-auto":
            said.setdefault(REASONS["default"], []).append(named(method))
    head = ["method", "cells reached", "rows over ReLCP's", "paper", "ours over it", "us a row", "paper", "ours over it", "CPU s", "largest overlap"]
    return table(head, body) + "\n" + sentences(said)


def compaction(runs, dt):
    """Table 2 at a step."""
    own = runs.get(("compaction", dt, "relcp"))
    if own is None:
        return "Not measured yet.\n"
    body, said = [], {}
    for (scene, step, method), (head, windows) in runs.items():
        if scene != "compaction" or step != dt or not windows:
            continue
        rows = windows[-1]["rows"]
        # Compared where both came to.
        there = {w["step"]: w for w in own[1]}
        with_own = next((w for w in reversed(windows) if w["step"] in there), windows[-1])
        same = there.get(with_own["step"], own[1][-1])
        paper = TABLE_2[dt].get(method, (None, None))
        wanted = paper[0] / TABLE_2[dt]["relcp"][0] if paper[0] else None
        ratio = with_own["rows"] / same["rows"] if same["rows"] else None
        of_time = cpu_ratio(with_own, same)
        body.append([
            named(method), f"{head['time']:.0f}", "yes" if head["completed"] else "no", f"{rows:.0f}",
            f"{ratio:.2f}" if ratio else "", f"{wanted:.1f}" if wanted else "", over(ratio, wanted),
            f"{of_time:.2f}" if of_time else "", f"{windows[-1]['cpu_s'] or 0:.0f}", f"{max(w['max_overlap'] for w in windows):.1e}",
        ])
        if wanted and ratio and abs(ratio / wanted - 1) > FAR:
            said.setdefault(REASONS["short"], []).append(named(method))
        if method == "relcp-auto":
            said.setdefault(REASONS["half"], []).append(named(method))
    head = ["method", "time reached", "to its end", "rows there", "over ReLCP's", "paper", "ours over it", "CPU time over ReLCP's, whole run", "CPU s", "largest overlap"]
    return table(head, body) + "\n" + sentences(said)


def from_states(file):
    """Table 2 from ReLCP's own states."""
    if not file.exists():
        return "Not measured yet.\n"
    found = json.loads(file.read_text())
    key = lambda line: (line["steps"], line["time"])
    own = {key(line): line for line in found if line["method"] == "relcp"}
    body = []
    for line in found:
        base = own.get(key(line))
        if base is None:
            continue
        rows = TABLE_2[0.1][line["method"]][0] / TABLE_2[0.1]["relcp"][0]
        ratio = line["rows"] / base["rows"]
        of_product = lambda line: line["cpu_s"] / max(line["products"], 1)
        body.append([
            f"{line['time']:g}", str(line["steps"]), named(line["method"]), str(line["rows"]), f"{ratio:.2f}", f"{rows:.1f}", over(ratio, rows),
            f"{line['products']}{' (cut)' if line.get('iterations') else ''}", f"{1e3 * of_product(line):.2f}", f"{of_product(line) / of_product(base):.1f}",
            "" if line.get("iterations") else f"{line['cpu_s'] / base['cpu_s']:.2f}", f"{TABLE_2[0.1][line['method']][1]:g}",
            "" if line.get("iterations") else f"{line['max_overlap']:.1e}",
        ])
    head = ["time", "steps from there", "method", "rows", "over ReLCP's", "paper", "ours over it", "products a step", "ms a product", "over ReLCP's",
            "CPU time a step over ReLCP's", "paper, whole run", "overlap"]
    return table(head, body)


def cpu_ratio(there, own):
    return there["cpu_s"] / own["cpu_s"] if there["cpu_s"] and own["cpu_s"] else None


def origin(table, heads):
    """By which program a table was made, and when."""
    if not heads:
        return ""
    dates = sorted({head["date"] for head in heads})
    builds = sorted({head["program"] for head in heads})
    return f"{table}: program {heads[0]['version']}, build {' and '.join(builds)}; {dates[0]} to {dates[-1]}."


def main():
    results, page = map(pathlib.Path, sys.argv[1:])
    runs = read(results)
    made = {"colony": colony(runs), "compaction 0.1": compaction(runs, 0.1), "compaction 0.01": compaction(runs, 0.01)}
    made["from states"] = from_states(results / "from-states.json")
    origins = [origin(table, [head for head, _ in runs.values() if head["scene"] == scene])
               for table, scene in [("Table 3", "colony"), ("Table 2", "compaction")]]
    made["origin"] = "One thread of a shared machine. " + " ".join(filter(None, origins)) + "\n"
    fill = lambda found: f"<!-- paper: {found[1]} -->\n\n{made.get(found[1], 'Not measured yet.' + chr(10))}\n<!-- paper: end -->"
    text = re.sub(r"<!-- paper: (?!end)(.*?) -->.*?<!-- paper: end -->", fill, page.read_text(), flags=re.S)
    page.write_text(text)


if __name__ == "__main__":
    main()
