"""The example notebooks: their cells run, and their pages in the documentation have the same code."""

import importlib.util
import json
import pathlib
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
DRAWS = importlib.util.find_spec("matplotlib") is not None


def cells(name, kind):
    notebook = json.loads((ROOT / "examples" / f"{name}.ipynb").read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == kind]


def run(name):
    """Runs a notebook's cells, without those that draw where nothing can; returns its names and how many ran."""
    if DRAWS:
        import matplotlib

        matplotlib.use("Agg")
    names, ran = {}, 0
    for source in cells(name, "code"):
        if not DRAWS:
            source = source.replace("import matplotlib.pyplot as plt\n", "")
        if DRAWS or "plt" not in source:
            exec(compile(source, f"{name}.ipynb", "exec"), names)
            ran += 1
    return names, ran


class Notebooks(unittest.TestCase):
    def test_swimmers(self):
        names, ran = run("swimmers")
        self.assertGreaterEqual(ran, 4)
        self.assertEqual(names["summary"]["status"], "done")
        # Of random directions the mean cosine is under a half, of those that turned it is not.
        self.assertLess(names["order"][0], 0.5)
        self.assertGreater(names["order"][-1], 0.7)
        # Of 80 rods that swim alone: the closed form of active Brownian motion, at lags before and after the turning.
        ratio = names["spread"] / names["closed"]
        self.assertLess(abs(ratio[0] - 1), 0.05, ratio)
        self.assertTrue((abs(ratio - 1) < 0.3).all(), ratio)

    def test_crowding(self):
        names, ran = run("crowding")
        self.assertGreaterEqual(ran, 4)
        self.assertEqual(names["summary"]["status"], "done")
        last, distances = names["last"], names["distances"]
        resting = last.groups == 1
        self.assertTrue(10 < resting.sum() < len(last) - 10, resting.sum())
        # The inner cells rest, and a resting cell stays one.
        self.assertLess(distances[resting].mean(), 0.8 * distances[~resting].mean())
        self.assertTrue((np.asarray(names["summary"]["max_overlap"]) < 1e-5).all())

    def test_sweep(self):
        names, ran = run("sweep")
        self.assertGreaterEqual(ran, 3)
        self.assertEqual(set(names["batch"].table["status"]), {"done"})
        forces, measured = names["forces"], names["measured"]
        closed = names["D"] + forces**2 / (2 * names["D_r"])
        for force in np.unique(forces):
            own = measured[forces == force] / closed[forces == force]
            # 180 rods over two lags: a tenth is two standard errors.
            self.assertLess(abs(own.mean() - 1), 0.25, (force, own))
        means = [measured[forces == force].mean() for force in np.unique(forces)]
        self.assertEqual(means, sorted(means))

    def test_their_pages_are_of_these_notebooks(self):
        for name in ["swimmers", "crowding", "sweep"]:
            page = (ROOT / "docs" / "notebook" / f"{name}.md").read_text(encoding="utf-8")
            for source in cells(name, "code") + cells(name, "markdown"):
                self.assertIn(source.rstrip(";"), page)


if __name__ == "__main__":
    unittest.main()
