"""Solvers of optimisation on stored LCPs `0 <= q + A g _|_ g >= 0`, `A = J J^T`, beside relcp's `auto`.

An LCP of that kind is the optimum of two quadratic programmes: `min 1/2 g.A g + q.g, g >= 0` (the dual) and
`min 1/2 v.v, q + J v >= 0` (the primal), whose multipliers are `g`. Each solver is given the form in which it is the
faster one, and each of its tolerances from 1e-3 down; what counts is the first result whose residual
`max |min(q + A g, s g)|`, computed here in f64 with `s` the diagonal of `A`, is at most 1e-6: its set-up and its solve,
the least CPU time of three. Warm starts are the multipliers that were stored with the LCP as its start.

`run.py RESULTS RELCP RAPIER`: adds to RESULTS what is not in it yet.
"""

import json
import multiprocessing
import pathlib
import subprocess
import sys
import tempfile
import time

import codes
import numpy
import scipy.sparse

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
sys.path.insert(0, str(HERE.parent))

import scene as scenes  # noqa: E402

WANTED = 1e-6
TOLERANCES = [10.0**-k for k in range(3, 13)]
REPEATS = 3
# Calls of the study of relcp's solvers.
CALLS = 5


class Lcp:
    """A stored LCP."""

    def __init__(self, file):
        read = numpy.load(file)
        rows, unknowns = read["row_a"].shape
        index = lambda body: unknowns * body.astype(numpy.int64)[:, None] + numpy.arange(unknowns)
        columns = numpy.hstack([index(read["a"]), index(read["b"])]).ravel()
        entries = numpy.hstack([read["row_a"], read["row_b"]]).ravel()
        # The rows, scaled so that `A = J J^T`.
        of_row = numpy.repeat(numpy.arange(rows), 2 * unknowns)
        size = (rows, unknowns * int(read["bodies"]))
        self.j = scipy.sparse.csc_matrix((entries, (of_row, columns)), size)
        self.j.eliminate_zeros()
        self.q, self.start = read["q"].astype(float), read["gamma0"].astype(float)
        self.diagonal = numpy.asarray(self.j.multiply(self.j).sum(axis=1)).ravel()

    def residual(self, gamma):
        """A length."""
        if gamma is None or not numpy.isfinite(gamma).all():
            return float("inf")
        gap = self.q + self.j @ (self.j.T @ gamma)
        return float(numpy.abs(numpy.minimum(gap, self.diagonal * gamma)).max())


def fastest(lcp, code, form, start):
    """The CPU seconds of the loosest tolerance that suffices, its residual, and how often it was tried."""
    smallest = float("inf")
    for tolerance in TOLERANCES:
        since = time.process_time()
        try:
            gamma = code(lcp, form, start, tolerance)
        except codes.Refused as refused:
            return {"ended": str(refused)}
        except Exception as fault:  # noqa: BLE001: what a solver of others throws is its result
            return {"ended": f"{type(fault).__name__}: {str(fault)[:120]}"}
        seconds = time.process_time() - since
        residual = lcp.residual(gamma)
        smallest = min(smallest, residual)
        if residual <= WANTED:
            for _ in range(REPEATS - 1):
                since = time.process_time()
                code(lcp, form, start, tolerance)
                seconds = min(seconds, time.process_time() - since)
            return {"cpu_s": seconds, "residual": residual, "tolerance": tolerance}
        if seconds > codes.SECONDS:
            return {"ended": f"over {codes.SECONDS:.0f} s, residual {smallest:.1e}"}
    return {"ended": f"residual {smallest:.1e} at the tightest tolerance"}


def apart(*job):
    """`fastest` in a process of its own: a solver may crash, or not come back."""
    context = multiprocessing.get_context("fork")
    into, out = context.Pipe(duplex=False)
    process = context.Process(target=lambda: out.send(fastest(*job)), daemon=True)
    process.start()
    out.close()
    found = None
    if into.poll(10 * codes.SECONDS):
        try:
            found = into.recv()
        except EOFError:
            pass
    process.kill()
    process.join()
    return found or {"ended": f"no result, exit status {process.exitcode}"}


def systems(relcp, folder):
    """The stored LCPs, and two of the packing of 1,000 rods at its end, which are made here."""
    files = {file.stem: file for file in sorted((ROOT / "assets/lcps").glob("*.npz"))}
    scene = scenes.SCENES["rods-1000"]
    start = folder / "start.json"
    start.write_text(scenes.of_relcp(scene, scenes.start(scene), "rods-1000", 0.1, 1e-5))
    run = [relcp, "run", "--backend", "cpu", "--threads", "1", "--quiet"]
    subprocess.run([*run, start, "--set", "output.every=15", "--out", folder / "to"], check=True)
    keys = ["time.end=15.04", "time.dt=0.02", "contact.rows=paper", "solver.tolerance=1e-10", "solver.dump.when=all"]
    sets = [word for key in [*keys, "solver.dump.most=100"] for word in ("--set", key)]
    subprocess.run([*run, folder / "to/final.json", *sets, "--out", folder / "two"], check=True)
    number = lambda file: int(file.stem.rsplit("-", 1)[1])
    last = sorted((folder / "two/lcps").glob("step-000002-rec-*.npz"), key=number)
    return {**files, "rods-1000-first": last[0], "rods-1000-last": last[-1]}


def ours(relcp, files, folder):
    """relcp's own solver from both starts: `relcp-lab solvers`, the program beside it, measures it to the same residual, by
    the clock, so the least of several calls counts. `auto` is `pair_block_cg`, with a safeguard where that gives up."""
    paths = []
    for name, file in files.items():
        paths.append(folder / f"{name}.npz")
        paths[-1].write_bytes(pathlib.Path(file).read_bytes())
    lab = pathlib.Path(relcp).with_name("relcp-lab")
    command = [lab, "solvers", *paths, "--backend", "cpu", "--threads", "1", "--json", "--quick"]
    best = {}
    for _ in range(CALLS):
        done = subprocess.run([*command, "--out", folder / "study"], check=True, capture_output=True, text=True)
        for row in attempts(json.loads(done.stdout)):
            key = row["lcp"], row["start"]
            if key not in best or row.get("cpu_s", 1e99) < best[key].get("cpu_s", 1e99):
                best[key] = row
    return best.values()


def attempts(study):
    """Rows of the study's table that are of `pair_block_cg` to the residual that is wanted."""
    for instance in study["lcps"]:
        for attempt in instance["attempts"]:
            if attempt["solver"] == "pair_block_cg" and attempt["tolerance"] == WANTED:
                name = pathlib.Path(instance["lcp"]).stem
                row = {"lcp": name, "code": "relcp auto", "form": "", "start": attempt["start"]}
                if attempt["status"] == "solved":
                    row.update(cpu_s=1e-3 * attempt["milliseconds"], residual=attempt["residual"])
                else:
                    row["ended"] = attempt["status"]
                yield row


def main():
    file, relcp = pathlib.Path(sys.argv[1]), sys.argv[2]
    have = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["lcp"], row["code"], row["form"], row["start"]) for row in have}

    def add(row):
        row["date"] = time.strftime("%Y-%m-%d", time.gmtime())
        with open(file, "a") as to:
            to.write(json.dumps(row) + "\n")

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        files = systems(relcp, folder)
        if not any(row["code"] == "relcp auto" for row in have):
            for row in ours(relcp, files, folder):
                add(row)
        for name, path in files.items():
            lcp = Lcp(path)
            size = {"rows": len(lcp.q), "bodies": lcp.j.shape[1]}
            for code, (version, forms, warm, solve) in codes.CODES.items():
                for form in forms:
                    for start in ["cold", "warm"] if warm else ["cold"]:
                        if (name, code, form, start) in done:
                            continue
                        found = apart(lcp, solve, form, lcp.start if start == "warm" else None)
                        add({"lcp": name, "code": code, "version": version, "form": form, "start": start, **size, **found})
                        print(name, code, form, start, found, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
